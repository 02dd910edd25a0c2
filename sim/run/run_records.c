#include "sim/run/run_records.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "sim/measure/measure.h"
#include "sim/run/run_checkpoints.h"
#include "sim/run/run_judge.h"
#include "sim/sample/step_completion.h"

/* `every_s` in steps of the stage, at least one; 0 s: never. */
static int64_t steps_in(const struct run *run, double every_s)
{
    if (!(every_s > 0))
        return INT64_MAX;
    double steps = round(every_s / run->sample->dt);
    return steps < 1 ? 1 : (int64_t)steps;
}

static enum status take_sample(struct run *run)
{
    const struct complete_sample whole = sample_complete(run->sample);
    struct held_energy *held = &run->sampled;
    if (run->stream) {
        struct measurement m;
        TRY(measure(whole, &m));
        *held = (struct held_energy){m.kinetic_j, m.elastic_normal_j + m.elastic_tangential_j};
        TRY(records_send_sample(&run->records, run->sample, &m));
    } else {
        *held = energy_held(whole);
    }
    if (run->sample->stage_step > 0)
        time_remaining_add(&run->remaining, run->sample->stage_step, held->kinetic_j / held->elastic_j);
    return STATUS_OK;
}

static enum status take_frame(struct run *run)
{
    const struct complete_sample whole = sample_complete(run->sample);
    return run->stream ? records_send_frame(&run->records, whole) : STATUS_OK;
}

/* Component whose upper wall is under strain control in this stage; -1: none. */
static int strained_component(const struct run *run)
{
    for (int c = 0; c < run->sample->particles.dimension; c++)
        if (run_stage(run)->axis[sample_axis(run->sample, c)].mode == WALL_STRAIN)
            return c;
    return -1;
}

/* Whether the next of frame_strains has been passed; in the direction of the final strain. */
static bool frame_strain_passed(struct run *run)
{
    const struct config_floats *list = &run_stage(run)->frame_strains;
    if (run->frame_strain_next >= list->count)
        return false;
    int c = strained_component(run);
    double length = run->sample->stage_position_m[2 * c + 1] - run->sample->stage_position_m[2 * c];
    double strain = 1 - sample_box_length_m(run->sample, c) / length;
    double next = list->value[run->frame_strain_next];
    bool passed = run_stage(run)->axis[sample_axis(run->sample, c)].strain >= 0 ? strain >= next : strain <= next;
    run->frame_strain_next += passed;
    return passed;
}

enum status run_record_step(struct run *run)
{
    const struct scene_stage *stage = run_stage(run);
    int64_t step = run->sample->stage_step;
    if (step % steps_in(run, stage->sample_interval_s) == 0)
        TRY(take_sample(run));
    bool strain = frame_strain_passed(run);
    bool interval = step > 0 && step % steps_in(run, stage->frame_interval_s) == 0;
    if (!strain && !interval)
        return STATUS_OK;
    if (run->records.last_sample_step != run->sample->step) /* a frame has a sample of its own step */
        TRY(take_sample(run));
    return take_frame(run);
}

enum status run_record_stage_end(struct run *run)
{
    if (run->records.last_sample_step != run->sample->step)
        TRY(take_sample(run));
    return run->records.last_frame_step != run->sample->step ? take_frame(run) : STATUS_OK;
}

/* Whether the record, too, goes on; it does not if the checkpoint's run recorded nothing. */
static bool record_goes_on(const struct run *run)
{
    return run->resumed && run->before.record_total[RECORD_RUN_INFO] > 0;
}

/* The stream and the log as they were at the checkpoint. RUN_INFO and PARTICLES are said again on a bus, as the
 * recorder is a new one. */
static enum status resume_records(struct run *run)
{
    int64_t total[RECORD_CHANNELS];
    if (!record_goes_on(run))
        return STATUS_OK;
    if (run->before.run_id != run->options->run_id)
        return status_fail(STATUS_USAGE, "the checkpoint is of run %" PRId64 ", not of run %" PRId64,
                           run->before.run_id, run->options->run_id);
    if (run->bus.is_log != (run->before.log_bytes > 0))
        return status_fail(STATUS_USAGE, "the checkpoint's run recorded %s: go on in the same way",
                           run->bus.is_log ? "over a bus" : "into a log");
    if (run->bus.is_log)
        TRY(bus_log_cut(&run->bus, run->before.log_bytes));
    memcpy(total, run->before.record_total, sizeof total);
    if (!run->bus.is_log)
        total[RECORD_RUN_INFO] = total[RECORD_PARTICLES] = 0;
    record_sender_resume(run->stream, total, run->before.record_hash, run->before.exchanges);
    run->records.n_frames = (int32_t)run->before.frames;
    return STATUS_OK;
}

enum status run_records_open(struct run *run)
{
    if ((!run->options->url && run->options->in_process) || run->options->replay)
        return STATUS_OK;
    if (run->resumed && run->options->url && strstr(run->options->url, "mode=w"))
        return status_fail(STATUS_USAGE, "%s would lose what was recorded: go on with ?mode=a", run->options->url);
    TRY(bus_open_direct(&run->bus, run->options->url));
    TRY(record_sender_create(&run->stream, &run->bus, run->options->run_id, run->scene->coupling.timeout_s));
    records_init(&run->records, run->stream, run->options->run_id);
    return resume_records(run);
}

enum status run_records_start(struct run *run)
{
    struct records_resumed resumed = {.frames = run->before.frames, .wall_states = run->before.exchanges};
    if (!run->stream || (run->bus.is_log && record_goes_on(run)))
        return STATUS_OK;
    memcpy(resumed.total, run->before.record_total, sizeof resumed.total);
    TRY(records_send_start(&run->records, run->sample, run->options->controller,
                           record_goes_on(run) ? &resumed : NULL));
    return record_sender_flush(run->stream); /* the recorder is there before anything happens */
}

/* A run that stopped by itself: the state that it stopped in, as a last sample, frame and checkpoint, so that one can
 * look at it; a sample that cannot be measured any more has no numbers to show. */
static enum status keep_failure(struct run *run, enum status status)
{
    if (status != STATUS_UNSTABLE && status != STATUS_LIMIT)
        return STATUS_OK;
    if (run->sample->stage >= 0 && run->records.last_sample_step != run->sample->step &&
        take_sample(run) == STATUS_OK && run->options->progress)
        fprintf(stderr, "sim: the state it stopped in is the last sample and frame\n");
    if (run->sample->stage >= 0)
        TRY(take_frame(run));
    return run_checkpoint_failed(run);
}

static enum status send_end(struct run *run, enum status status)
{
    TRY(exchange_settle(&run->exchange));
    struct run_totals totals = {exchange_states(&run->exchange), run->exchange.seq, run->exchange.repeated,
                                run->before.elapsed_s + clock_now_s() - run->start_s};
    return records_send_end(&run->records, sample_complete(run->sample), status, &totals);
}

enum status run_records_finish(struct run *run, enum status status)
{
    if (run->options->progress && isatty(STDERR_FILENO))
        fprintf(stderr, "\n");
    if (!run->stream)
        return status;
    char message[512];
    snprintf(message, sizeof message, "%s", status_message());
    enum status sent = run_judge_note_failure(run, status);
    if (sent == STATUS_OK)
        sent = keep_failure(run, status);
    if (sent != STATUS_OK)
        fprintf(stderr, "sim: warning: the state at the failure was not kept: %s\n", status_message());
    if (status != STATUS_OK)
        (void)status_fail(status, "%s", message); /* END's reason */
    sent = send_end(run, status);
    if (sent == STATUS_OK)
        sent = record_sender_flush(run->stream);
    int64_t log_bytes;
    if (sent == STATUS_OK) /* a recorder does that itself */
        sent = bus_log_sync(&run->bus, &log_bytes);
    return status != STATUS_OK ? status_fail(status, "%s", message) : sent;
}
