/* How far a study is, for people: on stderr, one line that is written over on a terminal, else a line a run. */
#ifndef SHAKEDOWN_STUDIES_PROGRESS_H
#define SHAKEDOWN_STUDIES_PROGRESS_H

#include <stdbool.h>

#include "common/status.h"

struct progress {
    int n, done, failed, running;
    double cost, cost_done; /* of all; of those that ended since the start */
    double cost_before;     /* of those that were there */
    double start_s;         /* monotonic clock */
    bool terminal;
};

/* `n` runs of `cost` in all, of which `done` of `cost_before` are there. */
void progress_start(struct progress *progress, int n, double cost, int done, double cost_before);

/* Prints the line. On a terminal over the last one. */
void progress_show(const struct progress *progress);

/* A message that stays, on a line of its own. */
void progress_say(const struct progress *progress, const char *format, ...) PRINTF_LIKE(2, 3);

#endif
