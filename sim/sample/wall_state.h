/* What the controller is told. */
#ifndef SHAKEDOWN_SIM_SAMPLE_WALL_STATE_H
#define SHAKEDOWN_SIM_SAMPLE_WALL_STATE_H

#include "sim/sample/sample.h"

/* Walls and forces now; energies are filled by the caller. */
void sample_wall_state(const struct sample *sample, struct wall_state *state);

/* Makes `state`, told when the interval in force began, ask for the command after it (pipelined). */
void sample_wall_state_ahead(const struct sample *sample, struct wall_state *state);

#endif
