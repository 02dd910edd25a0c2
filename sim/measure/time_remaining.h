/* How many steps a run still has: known where stages have fixed lengths, extrapolated where the present one ends with
 * its energy ratio, else at most the limits. For people; nothing is decided by it. */
#ifndef SHAKEDOWN_SIM_MEASURE_TIME_REMAINING_H
#define SHAKEDOWN_SIM_MEASURE_TIME_REMAINING_H

#include "common/scene.h"

/* Straight line through ln(E_kin/E_pot) of the samples of a stage against their steps, least squares; the k-th sample
 * weighs k^2, so that the beginning is forgotten as fast as the stage grows. Zero: a stage begins. */
struct time_remaining {
    int samples;
    double weight, step, log_ratio; /* sum of weights; weighted means */
    double ss, sl, ll;              /* weighted sums of squares and products about them */
    double last_step, last_log;
};

/* A sample at a step of the stage; a ratio that is not positive and finite is left out. */
void time_remaining_add(struct time_remaining *remaining, int64_t stage_step, double energy_ratio);

enum time_remaining_kind {
    TIME_REMAINING_KNOWN,
    TIME_REMAINING_EXTRAPOLATED, /* the present stage; the stress, where it is a condition too, is taken to be there
                                    earlier */
    TIME_REMAINING_AT_MOST       /* holds limits of stages that end by a condition */
};

/* Steps from `stage_step` of stage `stage` (before the first: -1, 0) to the end of the protocol. */
double time_remaining_steps(const struct time_remaining *remaining, const struct scene *scene, int stage,
                            int64_t stage_step, enum time_remaining_kind *kind);

#endif
