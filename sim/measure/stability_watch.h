/* What is looked at while a stage runs, on a schedule of its own in steps: what is recorded changes nothing here. */
#ifndef SHAKEDOWN_SIM_MEASURE_STABILITY_WATCH_H
#define SHAKEDOWN_SIM_MEASURE_STABILITY_WATCH_H

#include "sim/measure/overlaps.h"
#include "sim/sample/sample.h"

enum { STABILITY_WATCH_STEPS = 256 };

/* All doubles, so that a checkpoint keeps it as a row of them. */
struct stability_watch {
    double looks;
    double overlap_ratio, overlap_step; /* the largest, and where it was */
    double fastest_ratio;               /* largest overlaps_of_fastest */
    double inertial_sum, inertial_max;  /* inertial number */
    double error_looks;                 /* in the second half of the stage, by its longest duration: */
    double error_sum[3], error_max[3];  /* stress control: |stress - target| over the target */
    double target_pa[3];                /* the last one */
    double pulled_on_nothing[3];        /* looks in a row at a wall that pulls and touches nothing */
    double touched[3], left[3];         /* of walls led by strains: they have touched something; looks in a row since */
    double drift[3];                    /* of the middle of the box since the stage began, over its length then */
    double overlap_noted, fastest_noted, left_noted[3], drift_noted;
};

/* Forgets all: a stage begins. */
void stability_watch_start(struct stability_watch *watch);

/* Looks in a row at a wall without contacts that are too many: one may fall between two contacts. */
enum { STABILITY_WATCH_ALONE_MAX = 4 };

/* A look at the sample as it is; its last step need not be complete. STATUS_UNSTABLE, with what was seen, when the
 * model does not hold any more: an overlap beyond limits.overlap_ratio, a wall that pulls on nothing, a box that has
 * grown beyond all of it. fastest: overlaps_of_fastest of it. `passing`: sees which particles pass through each other,
 * or NULL (overlaps_look). */
enum status stability_watch_look(struct stability_watch *watch, struct sample *sample, double fastest,
                                 struct passing_watch *passing) MUST_USE;

/* The part of it that looks at overlaps, for samples so fast that contacts come and go between looks. */
enum status stability_watch_look_at_contacts(struct stability_watch *watch, struct sample *sample,
                                             struct passing_watch *passing) MUST_USE;

#endif
