#include "sim/run/run_checkpoints.h"

#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "sim/run/checkpoint.h"
#include "sim/sample/step_completion.h"

/* Checkpoints by the clock take at most this part of the run's time. Who asks for several in a second wants them. */
static const double COST_MAX = 0.01, SPARING_INTERVAL_S = 1;

/* Where the run stands before it asks for the command that answers the current state; `answered`: it has asked already,
 * and a run that goes on from here asks again, with the same energies. */
static struct run_progress progress_of(const struct run *run, bool answered)
{
    const struct run_energies *energies = answered ? &run->told : &run->energies;
    struct run_progress progress = {.run_id = run->options->run_id,
                                    .fraction_done = run->fraction_done,
                                    .kinetic_j = energies->held.kinetic_j,
                                    .elastic_j = energies->held.elastic_j,
                                    .energy_step = energies->step,
                                    .frame_strain_next = run->frame_strain_next,
                                    .exchanges = run->exchange.seq - answered,
                                    .commands_repeated = run->exchange.repeated,
                                    .frames = run->records.n_frames,
                                    .last_sample_step = run->records.last_sample_step,
                                    .last_frame_step = run->records.last_frame_step,
                                    .watch = run->judge.watch,
                                    .hurry_steps = run->judge.hurry_steps,
                                    .passing_noted = run->judge.passing_noted,
                                    .doubts = run->judge.doubts,
                                    .elapsed_s = run->before.elapsed_s + clock_now_s() - run->start_s,
                                    .has_command = run->has_command};
    if (run->has_command)
        progress.command = run->command;
    for (int c = 0; run->stream && c < RECORD_CHANNELS; c++) {
        progress.record_total[c] = record_sender_total(run->stream, c);
        progress.record_hash[c] = record_sender_hash(run->stream, c);
    }
    return progress;
}

/* Brings the record to disk, so that a checkpoint never knows of records that are not there. */
static enum status secure_records(struct run *run, int64_t exchanges, int64_t *log_bytes)
{
    *log_bytes = 0;
    if (!run->stream)
        return STATUS_OK;
    TRY(record_sender_flush(run->stream));
    TRY(records_send_checkpoint(&run->records, run->sample, exchanges));
    TRY(record_sender_flush(run->stream));
    return bus_log_sync(&run->bus, log_bytes);
}

/* Under a name of its own too, so that other scenes can start from the stage. */
static enum status share_stage(const struct run *run)
{
    char path[PATH_MAX], name[CONFIG_STRING_MAX];
    snprintf(name, sizeof name, "%s", run_stage(run)->name);
    for (char *sign = strchr(name, '/'); sign; sign = strchr(sign, '/'))
        *sign = '_';
    const char *slash = strrchr(run->options->checkpoint, '/');
    int folder = slash ? (int)(slash - run->options->checkpoint) + 1 : 0;
    int length = snprintf(path, sizeof path, "%.*scheckpoint-%s.h5", folder, run->options->checkpoint, name);
    if (length >= (int)sizeof path)
        return status_fail(STATUS_IO, "the path %s is too long", run->options->checkpoint);
    return checkpoint_share(run->options->checkpoint, path);
}

enum status run_checkpoint(struct run *run, bool stage_end)
{
    int64_t log_bytes;
    const double start_s = clock_now_s();
    if (!run->options->checkpoint)
        return STATUS_OK;
    TRY(secure_records(run, run->exchange.seq - stage_end, &log_bytes));
    struct run_progress progress = progress_of(run, stage_end);
    progress.log_bytes = log_bytes;
    enum status status = checkpoint_write(run->options->checkpoint, run->sample, &progress);
    if (status == STATUS_OK && stage_end)
        status = share_stage(run);
    if (status != STATUS_OK)
        fprintf(stderr, "sim: warning: step %" PRId64 ": %s; the run goes on\n", run->sample->step, status_message());
    run->checkpoint_s = clock_now_s();
    run->checkpoint_cost_s = run->checkpoint_s - start_s;
    return STATUS_OK;
}

enum status run_checkpoint_failed(struct run *run)
{
    char path[PATH_MAX];
    if (!run->options->checkpoint || run->sample->stage < 0)
        return STATUS_OK;
    const char *slash = strrchr(run->options->checkpoint, '/');
    const int folder = slash ? (int)(slash - run->options->checkpoint) + 1 : 0;
    const int length = snprintf(path, sizeof path, "%.*scheckpoint-failed.h5", folder, run->options->checkpoint);
    if (length >= (int)sizeof path)
        return status_fail(STATUS_IO, "the path %s is too long", run->options->checkpoint);
    (void)sample_complete(run->sample);
    const struct run_progress progress = progress_of(run, false);
    return checkpoint_write(path, run->sample, &progress);
}

/* Looks at the clock of run_status_tick, so that an exchange costs no call. */
bool run_checkpoint_is_due(const struct run *run)
{
    double interval_s = run->scene->checkpoint_interval_s;
    if (interval_s >= SPARING_INTERVAL_S)
        interval_s = fmax(interval_s, run->checkpoint_cost_s / COST_MAX);
    return interval_s > 0 && run->status_s - run->checkpoint_s >= interval_s;
}

void run_resume_progress(struct run *run)
{
    const struct run_progress *before = &run->before;
    run->fraction_done = before->fraction_done;
    run->energies = (struct run_energies){{before->kinetic_j, before->elastic_j}, before->energy_step};
    run->sampled = run->energies.held;
    run->frame_strain_next = (int)before->frame_strain_next;
    run->exchange.seq = before->exchanges;
    run->exchange.repeated = before->commands_repeated;
    run->records.last_sample_step = before->last_sample_step;
    run->records.last_frame_step = before->last_frame_step;
    run->status_step = run->sample->step;
    run->judge.watch = before->watch;
    run->judge.hurry_steps = before->hurry_steps;
    run->judge.passing_noted = before->passing_noted != 0;
    run->judge.doubts = before->doubts;
    snprintf(run->judge.first_doubt, sizeof run->judge.first_doubt, "noted before the checkpoint");
    run->has_command = before->has_command != 0;
    run->command = before->command;
}
