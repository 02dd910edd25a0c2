#include "sim/run/run.h"

#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "common/record_stream.h"
#include "common/signals.h"
#include "common/watch/progress.h"
#include "shakedown_status_t.h"
#include "sim/look/measure.h"
#include "sim/look/time_remaining.h"
#include "sim/run/checkpoint.h"
#include "sim/run/exchange.h"
#include "sim/run/records.h"
#include "sim/sample/sample.h"

static const double STATUS_INTERVAL_S = 0.1;
enum { STEPS_PER_LOOK = 16 }; /* steps between looks at the clock and the bus */

struct run_energies {
    struct held_energy held;
    int64_t step; /* at which it was measured */
};

struct run {
    const struct scene *scene;
    const struct run_options *options;
    struct sample *sample;
    struct bus bus;
    struct record_stream *stream;
    struct records records;
    struct exchange exchange;
    double fraction_done;
    struct run_energies energies;    /* for the controller's conditions */
    struct time_remaining remaining; /* of the stage */
    int frame_strain_next;           /* index in frame_strains */
    double start_s, status_s;
    int64_t status_step, status_seq;
    double steps_per_second;
    bool resumed;               /* went on from `before` */
    struct run_progress before; /* zero for a run from the start */
    struct run_energies told;   /* with the last state */
    struct wall_command command;
    bool has_command;    /* `command` is for the current step and was asked for ahead */
    double checkpoint_s; /* when the last one was written */
};

static const struct scene_stage *stage_of(const struct run *run)
{
    return &run->scene->stage[run->sample->stage];
}

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
    struct held_energy *held = &run->energies.held;
    run->energies.step = run->sample->step;
    if (run->stream) {
        struct measurement m;
        TRY(measure(run->sample, &m));
        *held = (struct held_energy){m.kinetic_j, m.elastic_normal_j + m.elastic_tangential_j};
        TRY(records_send_sample(&run->records, run->sample, &m));
    } else {
        *held = measure_held_energy(run->sample);
    }
    if (run->sample->stage_step > 0)
        time_remaining_add(&run->remaining, run->sample->stage_step, held->kinetic_j / held->elastic_j);
    return STATUS_OK;
}

static enum status take_frame(struct run *run)
{
    sample_complete(run->sample);
    return run->stream ? records_send_frame(&run->records, run->sample) : STATUS_OK;
}

/* Component whose upper wall is under strain control in this stage; -1: none. */
static int strained_component(const struct run *run)
{
    for (int c = 0; c < run->sample->particles.dimension; c++)
        if (stage_of(run)->axis[sample_axis(run->sample, c)].mode == WALL_STRAIN)
            return c;
    return -1;
}

/* Whether the next of frame_strains has been passed; in the direction of the final strain. */
static bool frame_strain_passed(struct run *run)
{
    const struct config_floats *list = &stage_of(run)->frame_strains;
    if (run->frame_strain_next >= list->count)
        return false;
    int c = strained_component(run);
    double length = run->sample->stage_position_m[2 * c + 1] - run->sample->stage_position_m[2 * c];
    double strain = 1 - sample_box_length_m(run->sample, c) / length;
    double next = list->value[run->frame_strain_next];
    bool passed = stage_of(run)->axis[sample_axis(run->sample, c)].strain >= 0 ? strain >= next : strain <= next;
    run->frame_strain_next += passed;
    return passed;
}

/* Records what is due after a step. */
static enum status record_step(struct run *run)
{
    const struct scene_stage *stage = stage_of(run);
    int64_t step = run->sample->stage_step;
    if (step % steps_in(run, stage->sample_interval_s) == 0)
        TRY(take_sample(run));
    bool strain = frame_strain_passed(run);
    bool interval = step > 0 && step % steps_in(run, stage->frame_interval_s) == 0;
    return strain || interval ? take_frame(run) : STATUS_OK;
}

/* The end of a stage is always recorded. */
static enum status record_stage_end(struct run *run)
{
    if (run->records.last_sample_step != run->sample->step)
        TRY(take_sample(run));
    return run->records.last_frame_step != run->sample->step ? take_frame(run) : STATUS_OK;
}

static void fill_status(struct run *run, double now, shakedown_status_t *message, double *strain, double *stress)
{
    const struct sample *sample = run->sample;
    for (int c = 0; c < sample->particles.dimension; c++) {
        double length = sample_box_length_m(sample, c), area = 1;
        double start = sample->stage_position_m[2 * c + 1] - sample->stage_position_m[2 * c];
        for (int b = 0; b < sample->particles.dimension; b++)
            area *= b == c ? 1 : sample_box_length_m(sample, b);
        strain[c] = 1 - length / start;
        stress[c] = 0.5 * (sample->walls[2 * c].force + sample->walls[2 * c + 1].force) / area;
    }
    enum time_remaining_kind kind;
    const double steps_left =
        time_remaining_steps(&run->remaining, run->scene, sample->stage, sample->stage_step, &kind);
    *message = (shakedown_status_t){
        .run_id = run->options->run_id,
        .seq = run->status_seq++,
        .step = sample->step,
        .time_s = sample->time_s,
        .stage = sample->stage,
        .n_stages = (int32_t)run->scene->n_stages,
        .stage_name = (char *)stage_of(run)->name,
        .fraction_done = run->fraction_done,
        .steps_per_second = run->steps_per_second,
        .elapsed_s = now - run->start_s,
        .time_left_s = run->steps_per_second > 0 ? steps_left / run->steps_per_second : -1,
        .time_left_kind = (int8_t)kind,
        .dimension = sample->particles.dimension,
        .strain = strain,
        .stress_wall_pa = stress,
        .kinetic_energy_j = run->energies.held.kinetic_j,
        .elastic_energy_j = run->energies.held.elastic_j,
        .commands_repeated = run->exchange.repeated,
        .interface_residual_j = sample->audit.residual_j,
        .controller_residual_j = sample->audit.controller_residual_j,
    };
    if (run->stream) {
        message->energy_residual_ratio = run->records.residual_ratio;
        message->records_repeated = record_stream_repeated(run->stream);
        message->records_waiting = record_stream_waiting(run->stream);
    }
}

static enum status publish_status(struct run *run, const shakedown_status_t *message)
{
    uint8_t buffer[1024];
    if (!run->stream || run->bus.is_log)
        return STATUS_OK;
    int size = shakedown_status_t_encode(buffer, 0, sizeof buffer, message);
    if (size < 0)
        return status_fail(STATUS_LIMIT, "STATUS is larger than %zu bytes", sizeof buffer);
    return bus_publish(&run->bus, CHANNEL_STATUS, buffer, (size_t)size);
}

static void print_progress(const shakedown_status_t *message)
{
    char text[PROGRESS_TEXT_MAX];
    if (!isatty(STDERR_FILENO))
        return;
    progress_format(text, message, 100);
    fprintf(stderr, "\r\033[K%s", text);
}

/* About ten times a second: speed, STATUS, and what came over the bus meanwhile. */
static enum status look_around(struct run *run)
{
    double now = clock_now_s(), since = now - run->status_s, strain[3], stress[3];
    if (run->stream)
        TRY(record_stream_service(run->stream));
    if (stop_requested())
        return status_fail(STATUS_INTERRUPTED, "interrupted at step %" PRId64, run->sample->step);
    if (since < STATUS_INTERVAL_S)
        return STATUS_OK;
    double speed = (double)(run->sample->step - run->status_step) / since;
    run->steps_per_second = run->steps_per_second > 0 ? 0.9 * run->steps_per_second + 0.1 * speed : speed;
    run->status_s = now;
    run->status_step = run->sample->step;
    shakedown_status_t message;
    fill_status(run, now, &message, strain, stress);
    if (run->options->progress)
        print_progress(&message);
    return publish_status(run, &message);
}

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
        TRY(record_step(run));
        if (run->sample->step % STEPS_PER_LOOK == 0)
            TRY(look_around(run));
    }
    return STATUS_OK;
}

/* One interval. Pipelined: the command for the next one is asked for at its start and comes meanwhile. */
static enum status interval(struct run *run, struct wall_state *state)
{
    const bool ahead = run->scene->coupling.scheme == SCHEME_PIPELINED;
    const int n = run->command.n_steps;
    run->has_command = false;
    if (ahead) {
        sample_wall_state_ahead(run->sample, state);
        TRY(ask(run, state));
    }
    TRY(steps(run, n));
    if (!ahead)
        return STATUS_OK;
    TRY(exchange_answer(&run->exchange, &run->command));
    run->has_command = run->command.n_steps > 0; /* 0: a stage begins, with a state of its own */
    return STATUS_OK;
}

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
                                    .elapsed_s = run->before.elapsed_s + clock_now_s() - run->start_s,
                                    .has_command = run->has_command};
    if (run->has_command)
        progress.command = run->command;
    for (int c = 0; run->stream && c < RECORD_CHANNELS; c++)
        progress.record_total[c] = record_stream_total(run->stream, c);
    return progress;
}

/* Brings the record to disk, so that a checkpoint never knows of records that are not there. */
static enum status secure_records(struct run *run, int64_t exchanges, int64_t *log_bytes)
{
    *log_bytes = 0;
    if (!run->stream)
        return STATUS_OK;
    TRY(record_stream_flush(run->stream));
    TRY(records_send_checkpoint(&run->records, run->sample, exchanges));
    TRY(record_stream_flush(run->stream));
    return bus_log_sync(&run->bus, log_bytes);
}

/* Under a name of its own too, so that other scenes can start from the stage. */
static enum status share_stage(const struct run *run)
{
    char path[PATH_MAX], name[CONFIG_STRING_MAX];
    snprintf(name, sizeof name, "%s", stage_of(run)->name);
    for (char *sign = strchr(name, '/'); sign; sign = strchr(sign, '/'))
        *sign = '_';
    const char *slash = strrchr(run->options->checkpoint, '/');
    int folder = slash ? (int)(slash - run->options->checkpoint) + 1 : 0;
    int length = snprintf(path, sizeof path, "%.*scheckpoint-%s.h5", folder, run->options->checkpoint, name);
    if (length >= (int)sizeof path)
        return status_fail(STATUS_IO, "the path %s is too long", run->options->checkpoint);
    return checkpoint_share(run->options->checkpoint, path);
}

/* A checkpoint that cannot be written leaves the one before, and the run goes on. */
static enum status save(struct run *run, bool stage_end)
{
    int64_t log_bytes;
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
    return STATUS_OK;
}

/* Looks at the clock of look_around, so that an exchange costs no call. */
static bool checkpoint_is_due(const struct run *run)
{
    double interval_s = run->scene->checkpoint_interval_s;
    return interval_s > 0 && run->status_s - run->checkpoint_s >= interval_s;
}

/* From exchange to exchange until the controller says that the protocol is done. */
static enum status loop(struct run *run)
{
    struct wall_state state;
    const struct wall_command *command = &run->command;
    for (;;) {
        if (checkpoint_is_due(run))
            TRY(save(run, false));
        sample_wall_state(run->sample, &state);
        TRY(take_command(run, &state));
        run->fraction_done = command->fraction_done;
        bool changes = command->finished || command->stage != run->sample->stage;
        if (changes && run->sample->stage >= 0) {
            TRY(record_stage_end(run));
            TRY(save(run, true));
        }
        if (command->finished)
            return STATUS_OK;
        TRY(sample_command(run->sample, command));
        if (changes) {
            run->frame_strain_next = 0;
            run->remaining = (struct time_remaining){0};
            TRY(record_step(run));
        }
        TRY(interval(run, &state));
    }
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
    record_stream_resume(run->stream, total, run->before.exchanges);
    run->records.n_frames = (int32_t)run->before.frames;
    return STATUS_OK;
}

static enum status open_records(struct run *run)
{
    if ((!run->options->url && run->options->in_process) || run->options->replay)
        return STATUS_OK;
    if (run->resumed && run->options->url && strstr(run->options->url, "mode=w"))
        return status_fail(STATUS_USAGE, "%s would lose what was recorded: go on with ?mode=a", run->options->url);
    TRY(bus_open_direct(&run->bus, run->options->url));
    TRY(record_stream_create(&run->stream, &run->bus, run->options->run_id, run->scene->coupling.timeout_s));
    records_init(&run->records, run->stream, run->options->run_id);
    return resume_records(run);
}

static enum status say_start(struct run *run)
{
    struct records_resumed resumed = {.frames = run->before.frames, .wall_states = run->before.exchanges};
    if (!run->stream || (run->bus.is_log && record_goes_on(run)))
        return STATUS_OK;
    memcpy(resumed.total, run->before.record_total, sizeof resumed.total);
    TRY(records_send_start(&run->records, run->sample, record_goes_on(run) ? &resumed : NULL));
    return record_stream_flush(run->stream); /* the recorder is there before anything happens */
}

/* Takes over where the run stood. */
static void resume_progress(struct run *run)
{
    const struct run_progress *before = &run->before;
    run->fraction_done = before->fraction_done;
    run->energies = (struct run_energies){{before->kinetic_j, before->elastic_j}, before->energy_step};
    run->frame_strain_next = (int)before->frame_strain_next;
    run->exchange.seq = before->exchanges;
    run->exchange.repeated = before->commands_repeated;
    run->records.last_sample_step = before->last_sample_step;
    run->records.last_frame_step = before->last_frame_step;
    run->status_step = run->sample->step;
    run->has_command = before->has_command != 0;
    run->command = before->command;
}

static enum status send_end(struct run *run, enum status status)
{
    TRY(exchange_settle(&run->exchange));
    struct run_totals totals = {exchange_states(&run->exchange), run->exchange.seq, run->exchange.repeated,
                                run->before.elapsed_s + clock_now_s() - run->start_s};
    return records_send_end(&run->records, run->sample, status, &totals);
}

/* END with the totals, and the wait for its acknowledgement. The run's own failure comes before one of the records. */
static enum status finish(struct run *run, enum status status)
{
    if (run->options->progress && isatty(STDERR_FILENO))
        fprintf(stderr, "\n");
    if (!run->stream)
        return status;
    char message[512];
    snprintf(message, sizeof message, "%s", status_message());
    enum status sent = send_end(run, status);
    if (sent == STATUS_OK)
        sent = record_stream_flush(run->stream);
    return status != STATUS_OK ? status_fail(status, "%s", message) : sent;
}

static enum status start_and_loop(struct run *run)
{
    TRY(say_start(run));
    TRY(exchange_init(&run->exchange, run->scene, &run->bus, run->stream, run->options->run_id,
                      run->options->in_process, run->options->replay));
    run->start_s = run->status_s = run->checkpoint_s = clock_now_s();
    if (run->resumed)
        resume_progress(run);
    TRY(loop(run));
    struct replay *replay = run->options->replay;
    return replay ? replay_finish(replay, run->sample->step, sample_hash(run->sample)) : STATUS_OK;
}

static enum status make_sample(struct run *run)
{
    run->resumed = run->options->resume != NULL;
    return run->resumed ? checkpoint_resume(run->options->resume, run->scene, &run->sample, &run->before)
                        : sample_create(&run->sample, run->scene);
}

enum status run_scene(const struct scene *scene, const struct run_options *options)
{
    struct run run = {.scene = scene, .options = options};
    TRY(make_sample(&run));
    const int64_t first_step = run.sample->step;
    enum status status = open_records(&run);
    if (status == STATUS_OK)
        status = finish(&run, start_and_loop(&run));
    record_stream_free(run.stream);
    if (run.bus.lcm || run.bus.log)
        bus_close(&run.bus);
    if (options->progress)
        fprintf(stderr,
                "sim: %" PRId64 " steps, %.3f s, %.2f us per step, %" PRId64
                " list builds, %d candidates, hash %016" PRIx64 "\n",
                run.sample->step, clock_now_s() - run.start_s,
                run.sample->step > first_step
                    ? 1e6 * (clock_now_s() - run.start_s) / (double)(run.sample->step - first_step)
                    : 0,
                run.sample->verlet.rebuilds, run.sample->pairs.count, sample_hash(run.sample));
    sample_free(run.sample);
    return status;
}
