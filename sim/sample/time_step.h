/* The time step. */
#ifndef SHAKEDOWN_SIM_SAMPLE_TIME_STEP_H
#define SHAKEDOWN_SIM_SAMPLE_TIME_STEP_H

#include "sim/sample/sample.h"

/* Forces and accelerations of the current positions and velocities, no time passing: at the start of a stage. */
void time_step_forces_anew(struct sample *sample);

#endif
