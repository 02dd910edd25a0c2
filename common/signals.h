/* SIGINT, SIGTERM and SIGHUP as a request to stop that loops look at. */
#ifndef SHAKEDOWN_COMMON_SIGNALS_H
#define SHAKEDOWN_COMMON_SIGNALS_H

#include <stdbool.h>

#include "common/status.h"

/* Installs the handlers, also when the shell that started us made the signals ignored or blocked (as it does for jobs
 * in the background). Calls that wait (poll) return early, others are restarted. When the launcher is the parent
 * (its id is in SHAKEDOWN_LAUNCHER) and a request comes from elsewhere, it is told by SIGUSR1. */
enum status signals_install(void) MUST_USE;

/* Whether one of them has come, and how often: the second one means "at once". */
bool stop_requested(void);
int stop_request_count(void);

#endif
