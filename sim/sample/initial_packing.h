/* The particles and the box that a scene starts with. */
#ifndef SHAKEDOWN_SIM_SAMPLE_INITIAL_PACKING_H
#define SHAKEDOWN_SIM_SAMPLE_INITIAL_PACKING_H

#include "sim/grains/particles.h"

/* Radii, positions without overlap and starting velocities as the scene says; box_lo/box_hi [dimension] become the
 * starting box. Errors: STATUS_LIMIT when a random start finds no room. */
enum status initial_packing_make(struct particles *particles, const struct scene *scene, double *box_lo_m,
                                 double *box_hi_m) MUST_USE;

#endif
