/* Particles divided into compact boxes of equal numbers: the sample is cut in two across its longest side, and so is
 * each part, down to `leaf` particles. */
#ifndef SHAKEDOWN_SIM_NEIGHBOURS_BISECTION_H
#define SHAKEDOWN_SIM_NEIGHBOURS_BISECTION_H

#include "sim/grains/particles.h"

/* Reorders order [p->count], a permutation of the particles, so that each `leaf` of them, from the first on, are a box;
 * and each 2, 4, 8 ... of these boxes side by side in the order are one too. Depends on positions and numbers alone. */
void bisection_order(const struct particles *particles, int leaf, int32_t *order);

#endif
