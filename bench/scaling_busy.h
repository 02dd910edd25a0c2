/* Several threads on a machine that another program shares. */
#ifndef SHAKEDOWN_BENCH_SCALING_BUSY_H
#define SHAKEDOWN_BENCH_SCALING_BUSY_H

#include "bench/lattice_sample.h"

/* The same steps with `threads` threads and with one, in turns, while a program that never waits keeps one core busy.
 * Threads are chosen as in every run (thread_choice.h), lists built when they are due. */
struct scaling_busy {
    const struct lattice_kind *kind;
    const char *precision;
    int count, threads;
    int turns, steps;          /* result: turns, and steps of each */
    double one_us, many_us;    /* result: a step, mean of all turns */
    double worst, undisturbed; /* result: time with threads over that with one, of the worst turn; and of as many turns
                                * before, without the other program */
};

/* Errors: STATUS_NO_MEMORY; STATUS_IO (the other program). */
enum status scaling_busy_measure(struct scaling_busy *busy) MUST_USE;

#endif
