/* What a run says of itself while it goes on: STATUS on the bus, the progress on a terminal. */
#ifndef SHAKEDOWN_SIM_RUN_RUN_STATUS_H
#define SHAKEDOWN_SIM_RUN_RUN_STATUS_H

#include "sim/run/run_state.h"

/* To be called often; about ten times a second: speed, STATUS, and what came over the bus meanwhile. STATUS_INTERRUPTED
 * when a stop was requested and no exchange has come since for some seconds. */
enum status run_status_tick(struct run *run) MUST_USE;

#endif
