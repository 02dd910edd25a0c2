/* Programs run by a bench: one at a time, their words in a file, their time measured. */
#ifndef SHAKEDOWN_BENCH_CHILD_H
#define SHAKEDOWN_BENCH_CHILD_H

#include <sys/types.h>

#include "common/status.h"

struct child {
    const char *const *argv; /* NULL at the end; argv[0] is looked up in PATH */
    const char *log;         /* stdout and stderr go there */
    const char *folder;      /* works there, once its log is open; NULL: here */
    const char *variable;    /* environment: this one is set to `value`, NULL: none */
    const char *value;
    double cpu_s;  /* result: time in user mode and in the system */
    int exit_code; /* result: 128 if it was ended by a signal */
};

/* Runs it to its end. STATUS_IO if it cannot be started or fails, with the last lines of its log. */
enum status child_run(struct child *child) MUST_USE;

/* Starts it; to be waited for by the caller. It dies with this process. */
enum status child_start(const struct child *child, pid_t *started) MUST_USE;

/* Reads a text file as a whole, to be freed. STATUS_IO, STATUS_NO_MEMORY. */
enum status file_read(const char *path, char **text) MUST_USE;

/* Makes the folder unless it is there. */
enum status folder_make(const char *path) MUST_USE;

/* This process, and the children to come, on one core. Which one: the last of those allowed. STATUS_IO. */
enum status pin_to_core(int *core) MUST_USE;

#endif
