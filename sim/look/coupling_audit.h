/* The interface between walls and controller: the energy that a loop closed only now and then gains or loses there,
 * measured on both sides, and the watch for loops that are not stable. */
#ifndef SHAKEDOWN_SIM_LOOK_COUPLING_AUDIT_H
#define SHAKEDOWN_SIM_LOOK_COUPLING_AUDIT_H

#include "common/coupling.h"
#include "common/scene.h"
#include "common/status.h"

struct sample;

struct coupling_audit {
    /* Since the start of the stage [J], over all walls in a force loop: |work that sim integrated - (F + F')/2 dx| with
     * the forces at both ends of an interval; of sim, and as the controller's motion took them. */
    double residual_j, controller_residual_j;
    /* The same over |F + F'|/2 |dx|, of the last two intervals; 0: nothing moved. */
    double error, error_before;
    /* The interval in force; after its end, until the next command, the one that ended. */
    double force_told[SCENE_WALLS_MAX];       /* of the sample at its start, as told to the controller [N] */
    double force_start[SCENE_WALLS_MAX];      /* the same, but with the material of the stage */
    double controller_force[SCENE_WALLS_MAX]; /* as it took them; of an impedance: driving force at the start */
    double x_start[SCENE_WALLS_MAX];          /* m */
    double work[SCENE_WALLS_MAX];             /* of the sample on the walls, trapezoidal rule over all steps [J] */
    /* The watch, over windows of intervals. */
    double window_residual_j, window_error;
    int window_intervals, bad_windows, leaking_windows;
    double diameter_m, sound_m_per_s; /* mean; of the sample: follow from particles and material */
};

/* Sets what follows from the material of the stage. */
void coupling_audit_set_law(struct sample *sample);

/* New books for a stage. */
void coupling_audit_stage_start(struct sample *sample);

/* Closes the controller's side of the interval that ended, before a command is put in force and its stage begins; opens
 * the books of the next one, after that. */
void coupling_audit_close(struct sample *sample, const struct wall_command *command);
void coupling_audit_open(struct sample *sample);

/* After each step: adds up the work; at the end of an interval the residual, and the watch. STATUS_UNSTABLE if a wall
 * in a force loop is faster than sound in the sample, walls have passed each other, or the mismatch is beyond all
 * energy of the sample; the message names the interval that would hold. x_before [n_walls]: before the step. */
enum status coupling_audit_step(struct sample *sample, const double *x_before, const double *force_before) MUST_USE;

#endif
