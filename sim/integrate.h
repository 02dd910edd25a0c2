/* The time step. */
#ifndef SHAKEDOWN_SIM_INTEGRATE_H
#define SHAKEDOWN_SIM_INTEGRATE_H

#include "sim/world.h"

/* Forces and accelerations of the current positions and velocities, no time passing: at the start of a stage. */
void integrate_forces_anew(struct world *world);

#endif
