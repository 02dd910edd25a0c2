/* Turns the state of the sample into records: run info, particles, samples, frames, end. */
#ifndef SHAKEDOWN_SIM_RUN_RECORDS_H
#define SHAKEDOWN_SIM_RUN_RECORDS_H

#include "common/message.h"
#include "common/record_sender.h"
#include "sim/measure/measure.h"
#include "sim/sample/sample.h"

struct records {
    struct record_sender *stream;
    int64_t run_id;
    int32_t n_frames;                          /* frames sent so far */
    int64_t last_sample_step, last_frame_step; /* -1: none */
    int32_t stage_end;                         /* enum stage_end of the stage that ended last */
    double residual_ratio;                     /* of the last sample: ledger residual over work of walls and gravity */
};

void records_init(struct records *records, struct record_sender *stream, int64_t run_id);

/* What a record that goes on holds already. */
struct records_resumed {
    int64_t total[RECORD_CHANNELS];
    int64_t frames, wall_states;
};

/* The scene with its effective configuration, then what does not change about the particles. resumed NULL: a new run.
 * controller: command of the program in place of wallctl; NULL: none.
 */
enum status records_send_start(struct records *records, const struct sample *sample, const char *controller,
                               const struct records_resumed *resumed) MUST_USE;

/* Has all that was recorded so far brought to disk, as a checkpoint of this state follows. */
enum status records_send_checkpoint(struct records *records, const struct sample *sample, int64_t wall_states) MUST_USE;

/* A line about the run itself. */
enum status records_send_note(struct records *records, const struct sample *sample, enum note_severity severity,
                              const char *text) MUST_USE;

/* The state of the sample now, as `measure` found it. */
enum status records_send_sample(struct records *records, const struct sample *sample, struct measurement *m) MUST_USE;

/* Particles and contacts now, in chunks. */
enum status records_send_frame(struct records *records, struct complete_sample whole) MUST_USE;

struct run_totals {
    int64_t wall_states, wall_commands, commands_repeated;
    double elapsed_s;
};

/* The last record: why the run ended, and the totals of all channels. */
enum status records_send_end(struct records *records, struct complete_sample whole, enum status why,
                             const struct run_totals *totals) MUST_USE;

#endif
