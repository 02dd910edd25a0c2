/* The second half of a time step: forces between particles and the kick, which an open step leaves to the next one. */
#ifndef SHAKEDOWN_SIM_SAMPLE_STEP_COMPLETION_H
#define SHAKEDOWN_SIM_SAMPLE_STEP_COMPLETION_H

#include "sim/sample/sample.h"

/* Completes the last step if that is open. The result is good until the sample changes. */
struct complete_sample sample_complete(struct sample *sample);

/* The parts: forces between particles over dt_s (0: anew, no time passes) and the kick. They add to the ledger. */
void step_pair_forces(struct sample *sample, double dt_s);
void step_kick(struct sample *sample, double dt_s);
struct kick_constants step_kick_constants(const struct sample *sample, double dt_s);

#endif
