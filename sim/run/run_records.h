/* What a run records, and when: samples and frames as the stage asks, the start and the end. */
#ifndef SHAKEDOWN_SIM_RUN_RUN_RECORDS_H
#define SHAKEDOWN_SIM_RUN_RUN_RECORDS_H

#include "sim/run/run_state.h"

/* Opens the stream of records, if there is to be one; a resumed run goes on with that of before. STATUS_USAGE if it
 * cannot. */
enum status run_records_open(struct run *run) MUST_USE;

/* Says what is run, and waits until the recorder has heard it. */
enum status run_records_start(struct run *run) MUST_USE;

/* Records what is due after a step; the end of a stage is always recorded. */
enum status run_record_step(struct run *run) MUST_USE;
enum status run_record_stage_end(struct run *run) MUST_USE;

/* END with the totals, and the wait for its acknowledgement. `status`: how the run ended; that failure comes before one
 * of the records. */
enum status run_records_finish(struct run *run, enum status status) MUST_USE;

#endif
