/* The time step. */
#ifndef SHAKEDOWN_SIM_SAMPLE_TIME_STEP_H
#define SHAKEDOWN_SIM_SAMPLE_TIME_STEP_H

#include "sim/sample/sample.h"

/* One time step: velocity Verlet with velocities predicted for the force evaluation, second order also for forces that
 * depend on velocity. STATUS_UNSTABLE if a particle has left the box or is not finite. */
enum status sample_step(struct sample *sample) MUST_USE;

/* The same, but forces between particles and what follows from them are left to the next step, which goes on in as few
 * passes over the particles as it can: faster, and the same bits. Who reads velocities, accelerations, the contacts'
 * history or the ledger takes a complete sample. Walls and their forces are complete, and in double positions. */
enum status sample_step_open(struct sample *sample) MUST_USE;

/* Forces and accelerations of the current positions and velocities, no time passing: at the start of a stage. */
void time_step_forces_anew(struct sample *sample);

#endif
