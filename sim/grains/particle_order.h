/* Ids and slots: every particle keeps its id, whatever its place in memory. */
#ifndef SHAKEDOWN_SIM_GRAINS_PARTICLE_ORDER_H
#define SHAKEDOWN_SIM_GRAINS_PARTICLE_ORDER_H

#include "sim/grains/particles.h"

/* Slot of every id from id of every slot; STATUS_FORMAT if these are not a permutation. */
enum status particles_set_slots(struct particles *particles) MUST_USE;

/* Copies values[first ... first + count - 1] in the order of ids. */
void particles_gather_by_id(const struct particles *particles, const double *values, int first, int count, double *out);

#endif
