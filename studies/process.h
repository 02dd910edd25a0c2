/* Programs that a study starts. They die with the process that started them. */
#ifndef SHAKEDOWN_STUDIES_PROCESS_H
#define SHAKEDOWN_STUDIES_PROCESS_H

#include <stdbool.h>
#include <sys/types.h>

#include "common/status.h"

/* Starts argv[0] (looked up in PATH unless it has a slash; argv ends with NULL) in `folder` (NULL: here), stdout and
 * stderr at the end of the file `log` (opened before the change of folder). With `own_group` it leads a process group
 * of its own, so that a Ctrl-C in a terminal does not reach it. STATUS_IO. */
enum status process_start(const char *const *argv, const char *folder, const char *log, bool own_group,
                          pid_t *started) MUST_USE;

/* Waits for it; `code` is the exit code, or 128 and the signal that ended it. STATUS_IO. */
enum status process_wait(pid_t pid, int *code) MUST_USE;

/* Whether it has ended, and how, without waiting. STATUS_IO. */
enum status process_poll(pid_t pid, bool *ended, int *code) MUST_USE;

/* Both in one. */
enum status process_run(const char *const *argv, const char *folder, const char *log, int *code) MUST_USE;

/* Whether a program of this name can be found in PATH. */
bool process_exists(const char *name);

#endif
