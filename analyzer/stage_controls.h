/* What the controls of a stage did: read from the configuration in force, and from the record where that says more (a
 * volume that is kept by two strain paths; targets that came from a controller of the user's own). It decides what is
 * evaluated. */
#ifndef SHAKEDOWN_ANALYZER_STAGE_CONTROLS_H
#define SHAKEDOWN_ANALYZER_STAGE_CONTROLS_H

#include <stdbool.h>
#include <stddef.h>

#include "analyzer/run_file.h"
#include "common/scene.h"

enum test_kind {
    TEST_NONE,            /* nothing that has an evaluation */
    TEST_ISOTROPIC,       /* all axes under one pressure that changes, or strained alike */
    TEST_OEDOMETER,       /* one axis moves, the lateral walls rest */
    TEST_SHEAR,           /* one axis leads, the lateral ones hold a stress or follow a path in (p, q) */
    TEST_CONSTANT_VOLUME, /* one axis leads, the lateral ones keep the volume */
    TEST_CYCLIC,          /* an axis is cycled */
    TEST_CREEP,           /* all stresses are held */
    TEST_RELAXATION,      /* all walls rest, or the axial ones while the lateral ones hold a stress */
    TEST_KINDS
};

struct stage_controls {
    enum test_kind kind;
    enum axis axial;            /* the leading axis; z if none leads */
    bool extension;             /* it was stretched, not compressed */
    bool stress_led;            /* it is led by a stress, not by a strain */
    bool volume_kept;           /* the volume changes by less than 2 % of the axial strain */
    bool pressure_kept;         /* p changes by less than 2 % while q does by more than 10 % of p */
    double lateral_pressure_pa; /* p_x, the mean over the lateral targets; NaN unless all are constant stresses */
    double period_s;            /* of the cycles; 0 */
};

/* Finds them from samples [begin, end) of the stage; with none, from the configuration alone. */
void stage_controls_find(struct stage_controls *controls, const struct run *run, int stage, size_t begin, size_t end);

/* "drained triaxial compression", ... of a run of dimension 2 or 3. */
const char *stage_controls_name(const struct stage_controls *controls, int dimension);

/* Axis index in arrays of length D (2D: x, z). */
int stage_controls_slot(int dimension, int axis);

/* Index of the leading axis in them, and the mean of the other components of a vector [D]. */
void stage_controls_split(const struct stage_controls *controls, int dimension, const double *vector, double *axial,
                          double *lateral);

#endif
