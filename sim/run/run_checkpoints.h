/* When a run writes checkpoints, and how it goes on from one. */
#ifndef SHAKEDOWN_SIM_RUN_RUN_CHECKPOINTS_H
#define SHAKEDOWN_SIM_RUN_RUN_CHECKPOINTS_H

#include "sim/run/run_state.h"

/* Whether one is due by the clock. */
bool run_checkpoint_is_due(const struct run *run);

/* Brings the record to disk, then writes a checkpoint; at the end of a stage, when the command for the current state
 * has been answered, also under the stage's name. One that cannot be written leaves the one before, and the run goes
 * on; errors are those of the record. */
enum status run_checkpoint(struct run *run, bool stage_end) MUST_USE;

/* Takes over where the run stood. */
void run_resume_progress(struct run *run);

/* The state of a run that stopped by itself, in checkpoint-failed.h5 beside the others: to be looked at, not to go on
 * from. */
enum status run_checkpoint_failed(struct run *run) MUST_USE;

#endif
