/* How well the walls kept what the scene asks of them: stresses against their targets, what coupled axes keep. */
#ifndef SHAKEDOWN_ANALYZER_CONTROL_QUALITY_H
#define SHAKEDOWN_ANALYZER_CONTROL_QUALITY_H

#include <stddef.h>

#include "analyzer/quantity.h"
#include "analyzer/run_file.h"

enum kept_quantity {
    KEPT_STRESS, /* stresses of axes under stress control, against their targets */
    KEPT_VOLUME, /* V against that of the first sample */
    KEPT_P,      /* p against its target */
    KEPT_Q,      /* q against its target */
    KEPT_PATH,   /* q - (deviator_pa + dq_dp (p - pressure_pa)) */
    KEPT_B,      /* b as such */
    KEPT_QUANTITIES
};

/* Deviations over the samples of a stage. Stresses are over the largest |target| in the stage, the path over
 * pressure_pa, the volume over itself; b is as it is, where sigma_zz - sigma_xx is above a hundredth of p. NaN: nothing
 * is to keep it. */
struct control_quality {
    double mean, largest;
    double tolerance; /* the smallest that one of its axes asks for; 0: none does */
};

/* Finds them from samples [begin, end) of a stage, with the targets of the scene in force. */
void control_quality_find(const struct run *run, int stage, size_t begin, size_t end,
                          struct control_quality kept[KEPT_QUANTITIES]);

/* The largest deviations as the quantities kept.*; absent where nothing is kept. */
void control_quality_quantities(const struct run *run, int stage, struct quantity *quantities);

#endif
