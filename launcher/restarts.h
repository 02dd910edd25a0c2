/* How often a process may be started again. */
#ifndef SHAKEDOWN_LAUNCHER_RESTARTS_H
#define SHAKEDOWN_LAUNCHER_RESTARTS_H

#include <stdbool.h>

enum { RESTARTS_MAX = 100 };

/* Times of the last restarts, for a limit within any hour. */
struct restarts {
    double at_s[RESTARTS_MAX];
    int n;
};

/* Whether there may be one more at `now_s` with at most `limit` (up to RESTARTS_MAX) within an hour; notes it. */
bool restarts_allow(struct restarts *restarts, int limit, double now_s);

#endif
