/* A run judges itself: notes with figures before it, while a stage runs and at its ends, and the verdict. */
#ifndef SHAKEDOWN_SIM_RUN_RUN_JUDGE_H
#define SHAKEDOWN_SIM_RUN_RUN_JUDGE_H

#include "sim/run/run_state.h"

/* Before the first step: what the sample does not bear is refused (STATUS_CONFIG), what is coarse is noted. */
enum status run_judge_before(struct run *run) MUST_USE;

/* When a stage has begun, after each step, and when one has ended, with the state complete; ended: enum stage_end. */
enum status run_judge_stage_start(struct run *run) MUST_USE;
enum status run_judge_step(struct run *run) MUST_USE;
enum status run_judge_stage_end(struct run *run, int ended) MUST_USE;

/* At the end, however the run came to it: the last note, if it failed, and the verdict on stderr. Returns `status`, or
 * STATUS_DOUBTFUL for a run that ended well but has notes that make it so. */
enum status run_judge_note_failure(struct run *run, enum status status) MUST_USE;
enum status run_judge_verdict(const struct run *run, enum status status) MUST_USE;

#endif
