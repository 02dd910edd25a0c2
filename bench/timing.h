/* Times of short parts of the program: many short blocks, CPU time of this thread. */
#ifndef SHAKEDOWN_BENCH_TIMING_H
#define SHAKEDOWN_BENCH_TIMING_H

#include <stdbool.h>

#include "common/status.h"

struct timing {
    double least_us, median_us; /* of one call; the least is the machine undisturbed */
    double instructions;        /* of one call; < 0: not known */
};

typedef enum status timed_part(void *user);

/* Calls `part` in `blocks` (at most 100) blocks of `repeats` calls; fails as it does. */
enum status timing_take(timed_part *part, void *user, int blocks, int repeats, struct timing *timing) MUST_USE;

/* Whether this machine lets us count instructions; says so on stdout if not. */
bool timing_counts_instructions(void);

/* The clock of the core as a chain of additions sees it, one a cycle [GHz]: what to judge times by on a machine whose
 * speed varies. The fastest of 5 chains of a tenth of a millisecond, so that a thread put to sleep does not count. */
double timing_core_ghz(void);

/* "core: ... GHz before, ... GHz after (chain of additions)" on stdout. */
void timing_core_print(double before_ghz, double after_ghz);

#endif
