#include "sim/run/run.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "common/signals.h"
#include "sim/run/checkpoint.h"
#include "sim/run/run_checkpoints.h"
#include "sim/run/run_judge.h"
#include "sim/run/run_records.h"
#include "sim/run/run_state.h"
#include "sim/run/run_status.h"
#include "sim/run/sample_source.h"
#include "sim/sample/stage.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"
#include "sim/sample/wall_state.h"

enum { STEPS_PER_LOOK = 16 }; /* steps between looks at the clock and the bus */

static enum status ask(struct run *run, struct wall_state *state)
{
    run->told = run->energies;
    state->kinetic_energy_j = run->told.held.kinetic_j;
    state->elastic_energy_j = run->told.held.elastic_j;
    state->energy_step = run->told.step;
    return exchange_ask(&run->exchange, state);
}

/* The command for the current step, unless it was asked for ahead. */
static enum status take_command(struct run *run, struct wall_state *state)
{
    if (run->has_command)
        return STATUS_OK;
    TRY(ask(run, state));
    return exchange_answer(&run->exchange, &run->command);
}

static enum status steps(struct run *run, int n)
{
    for (int k = 0; k < n; k++) {
        TRY(sample_step_open(run->sample));
        TRY(run_record_step(run));
        TRY(run_judge_step(run));
        if (run->sample->step % STEPS_PER_LOOK == 0)
            TRY(run_status_tick(run));
    }
    return STATUS_OK;
}

/* What the controller wanted to know at the end of the interval; sim decides nothing by it. */
static void measure_energies(struct run *run)
{
    run->energies = (struct run_energies){energy_held(sample_complete(run->sample)), run->sample->step};
}

/* One interval, told where it began. The command for the next one may be asked for ahead, and comes meanwhile. */
static enum status interval(struct run *run, struct wall_state *state)
{
    const int n = run->command.n_steps, ahead = coupling_ahead_steps(&run->scene->coupling, n);
    const bool wanted = run->command.measure;
    run->has_command = false;
    if (ahead < n) {
        TRY(steps(run, n - ahead));
        sample_wall_state(run->sample, state);
        if (wanted)
            measure_energies(run);
    }
    if (ahead == 0)
        return STATUS_OK;
    sample_wall_state_ahead(run->sample, state);
    TRY(ask(run, state));
    TRY(steps(run, ahead));
    if (wanted && ahead == n)
        measure_energies(run);
    TRY(exchange_answer(&run->exchange, &run->command));
    run->has_command = run->command.n_steps > 0; /* 0: a stage begins, with a state of its own */
    return STATUS_OK;
}

/* The current state is one to go on from, as no command has answered it. Before the first there is nothing to save;
 * with commands that are asked for ahead an answer that did not come belongs to an older state. */
static enum status interrupt(struct run *run)
{
    const int64_t step = run->sample->step;
    if (run->sample->stage >= 0)
        TRY(run_checkpoint(run, false));
    return status_fail(STATUS_INTERRUPTED, "interrupted at %.0f %% (step %" PRId64 ")", 100 * run->fraction_done, step);
}

/* From exchange to exchange until the controller says that the protocol is done. */
static enum status loop(struct run *run)
{
    struct wall_state state;
    const struct wall_command *command = &run->command;
    for (;;) {
        if (run_checkpoint_is_due(run) && !stop_requested())
            TRY(run_checkpoint(run, false));
        if (stop_requested())
            return interrupt(run);
        sample_wall_state(run->sample, &state);
        enum status status = take_command(run, &state);
        if (status == STATUS_INTERRUPTED)
            return interrupt(run);
        TRY(status);
        run->fraction_done = command->fraction_done;
        bool changes = command->finished || command->stage != run->sample->stage;
        if (changes && run->sample->stage >= 0) {
            TRY(run_record_stage_end(run));
            /* notes come after it: a run that goes on from here comes to the stage's end again */
            TRY(run_checkpoint(run, true));
            TRY(run_judge_stage_end(run, command->ended));
        }
        if (changes)
            run->records.stage_end = command->ended;
        if (command->finished)
            return STATUS_OK;
        TRY(sample_command(run->sample, command));
        if (changes) {
            run->frame_strain_next = 0;
            run->remaining = (struct time_remaining){0};
            TRY(run_record_step(run));
            TRY(run_judge_stage_start(run));
        }
        TRY(interval(run, &state));
    }
}

static enum status start_and_loop(struct run *run)
{
    run->start_s = run->status_s = run->checkpoint_s = clock_now_s();
    TRY(run_records_start(run));
    TRY(run_judge_before(run));
    TRY(exchange_init(&run->exchange, run->scene, &run->bus, run->stream, run->options->run_id,
                      run->options->in_process, run->options->replay));
    if (run->resumed)
        run_resume_progress(run);
    TRY(loop(run));
    struct replay *replay = run->options->replay;
    return replay ? replay_finish(replay, run->sample->step, sample_hash(sample_complete(run->sample))) : STATUS_OK;
}

static enum status make_sample(struct run *run)
{
    run->resumed = run->options->resume != NULL;
    return run->resumed ? checkpoint_resume(run->options->resume, run->scene, &run->sample, &run->before)
                        : sample_from_scene(&run->sample, run->scene);
}

enum status run_check_resume(const struct scene *scene, const char *path)
{
    struct sample *sample = NULL;
    struct run_progress progress;
    TRY(checkpoint_resume(path, scene, &sample, &progress));
    sample_free(sample);
    return STATUS_OK;
}

enum status run_scene(const struct scene *scene, const struct run_options *options)
{
    struct run run = {.scene = scene, .options = options};
    TRY(make_sample(&run));
    const int64_t first_step = run.sample->step;
    enum status status = run_records_open(&run);
    if (status == STATUS_OK)
        status = run_records_finish(&run, start_and_loop(&run));
    passing_watch_free(&run.judge.passing);
    record_sender_free(run.stream);
    if (run.bus.lcm || run.bus.log)
        bus_close(&run.bus);
    if (options->progress && run.start_s > 0)
        fprintf(stderr,
                "sim: %" PRId64 " steps, %.3f s, %.2f us per step, %" PRId64
                " list builds, %d candidates, hash %016" PRIx64 "\n",
                run.sample->step, clock_now_s() - run.start_s,
                run.sample->step > first_step
                    ? 1e6 * (clock_now_s() - run.start_s) / (double)(run.sample->step - first_step)
                    : 0,
                run.sample->verlet.rebuilds, run.sample->pairs.count, sample_hash(sample_complete(run.sample)));
    sample_free(run.sample);
    return run_judge_verdict(&run, status);
}
