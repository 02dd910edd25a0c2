/* Times of short parts of the program: many short blocks, CPU time of this thread. */
#ifndef SHAKEDOWN_BENCH_TIMING_H
#define SHAKEDOWN_BENCH_TIMING_H

#include <jansson.h>
#include <stdbool.h>

#include "common/status.h"
#include "sim/base/thread_team.h"

struct timing {
    double least_us, median_us; /* of one call; the least is the machine undisturbed */
    double instructions;        /* of one call; < 0: not known */
};

typedef enum status timed_part(void *user);

/* Calls `part` in `blocks` (at most 100) blocks of `repeats` calls; fails as it does. */
enum status timing_take(timed_part *part, void *user, int blocks, int repeats, struct timing *timing) MUST_USE;

/* The value below which this part of n values lies, 0: the least; `values` is put in order. */
double timing_rank(double *values, int n, double part);

/* Whether this machine lets us count instructions; says so on stdout if not. */
bool timing_counts_instructions(void);

/* What the core can do just now, to judge times by on a machine whose speed varies: its clock, from a chain of
 * additions, one a cycle, and how many additions that wait for nothing it does, which neighbours on the same core take
 * away. The most of 10 tries of some 0.1 ms each. */
struct timing_core {
    double ghz, additions_per_ns;
};
struct timing_core timing_core(void);

/* What memory of this size gives the threads at work in the team (NULL: the caller) that read it, add, and write it
 * back, in order: bytes read and written [GB/s], the most of 5 passes; 0 if there is no room. */
double timing_stream_gb_per_s(double bytes, struct thread_team *team);

/* Both before and after a measurement: a line on stdout, and {"ghz": [before, after], "additions_per_ns": [...]}. */
void timing_core_print(const struct timing_core *before, const struct timing_core *after);
json_t *timing_core_json(const struct timing_core *before, const struct timing_core *after);

#endif
