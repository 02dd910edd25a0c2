/* What the launcher says, on the standard error. */
#ifndef SHAKEDOWN_LAUNCHER_REPORT_H
#define SHAKEDOWN_LAUNCHER_REPORT_H

#include <stdbool.h>

#include "common/status.h"
#include "launcher/child.h"
#include "launcher/run_folder.h"

enum { EXIT_CODE_TIMEOUT = -1 }; /* in place of a code: it did not end in time */

/* One line, with the program's name before it; over what stands in the terminal's last line. */
void say(const char *format, ...) PRINTF_LIKE(1, 2);

/* "was ended by signal KILL", "ended with exit code 10"; `text` [END_TEXT_MAX]. */
enum { END_TEXT_MAX = 80 };
void end_text(char *text, int exit_code);

/* How a process ended, the last lines of what it said, and what may help. */
void report_failure(struct child *child, int exit_code, const struct run_folder *folder);

/* Whether there is a record. */
void report_record(const struct run_folder *folder);

/* `path` as a word for a shell, to be freed by g_free. */
char *report_shell_word(const char *path);

/* The line that says how to go on. */
void report_way_on(const struct run_folder *folder);

#endif
