/* What a process says, on its way to its log file: the last lines stay in memory, so that they can be shown when the
 * disk took none of them. */
#ifndef SHAKEDOWN_LAUNCHER_CHILD_LOG_H
#define SHAKEDOWN_LAUNCHER_CHILD_LOG_H

#include <stdbool.h>
#include <stddef.h>

#include "common/status.h"

enum { CHILD_LOG_TAIL_MAX = 8192 };

struct child_log {
    char *path;
    int file; /* -1: cannot be written; what is said stays in `tail` alone */
    int pipe; /* the end that is read, not blocking; -1: closed */
    size_t n_tail;
    char tail[CHILD_LOG_TAIL_MAX];
};

/* Makes the pipe and opens the file for appending; *write_end is for the process. A file that cannot be opened is no
 * error. */
enum status child_log_open(struct child_log *log, const char *path, int *write_end) MUST_USE;

/* Takes what has come; closes the pipe at its end. Never blocks. */
void child_log_take(struct child_log *log);

/* Takes the rest and closes pipe and file; the tail stays. */
void child_log_close(struct child_log *log);

/* Start of the last `lines` lines of the tail, which is zero ended. */
const char *child_log_last_lines(struct child_log *log, int lines);

#endif
