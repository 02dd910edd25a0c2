/* How a run goes, as text for a terminal. */
#ifndef SHAKEDOWN_COMMON_WATCH_PROGRESS_H
#define SHAKEDOWN_COMMON_WATCH_PROGRESS_H

#include <stddef.h>

#include "shakedown_end_t.h"
#include "shakedown_status_t.h"

enum { PROGRESS_TEXT_MAX = 512 };

/* Writes one line without a line end, e.g. "stage 2/3 shear  45 %  12.3 µs/step  1:23 left  energy residual 1.0e-05";
 * parts that do not fit into `columns` of a terminal are left out from the right (0: no limit). What is unknown (speed
 * 0, negative time left) is left out too; the time left is "about 1:23 left" where it follows from a trend, "at most"
 * where it holds limits. `text` [PROGRESS_TEXT_MAX]. */
void progress_format(char *text, const shakedown_status_t *status, int columns);

/* The same for the last message of a run, e.g. "done: 20000 steps in 0:12, 12.3 µs/step". */
void progress_format_end(char *text, const shakedown_end_t *end);

#endif
