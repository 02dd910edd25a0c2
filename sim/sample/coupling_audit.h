/* The interface between walls and controller: the energy that a loop closed only now and then gains or loses there,
 * measured on both sides, and the watch for loops that are not stable. */
#ifndef SHAKEDOWN_SIM_MEASURE_COUPLING_AUDIT_H
#define SHAKEDOWN_SIM_MEASURE_COUPLING_AUDIT_H

#include "sim/sample/sample.h"

/* Sets what follows from the material of the stage. */
void coupling_audit_set_law(struct sample *sample);

/* New books for a stage. */
void coupling_audit_stage_start(struct sample *sample);

/* Closes the controller's side of the interval that ended, before a command is put in force and its stage begins; opens
 * the books of the next one, after that. */
void coupling_audit_close(struct sample *sample, const struct wall_command *command);
void coupling_audit_open(struct sample *sample);

/* After each step: adds up the work; at the end of an interval the residual, and the watch. STATUS_UNSTABLE if a wall
 * in a force loop is faster than sound in the sample and its pressure make it, walls have passed each other, or the
 * mismatch is beyond all energy of the sample; the message names the interval that would hold. x_before [n_walls]:
 * before the step. */
enum status coupling_audit_step(struct sample *sample, const double *x_before, const double *force_before) MUST_USE;

#endif
