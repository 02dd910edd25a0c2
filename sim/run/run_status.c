#include "sim/run/run_status.h"

#include <inttypes.h>
#include <stdio.h>
#include <unistd.h>

#include "common/signals.h"
#include "common/watch/progress.h"
#include "shakedown_status_t.h"

static const double STATUS_INTERVAL_S = 0.1;

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
        .stage_name = (char *)run_stage(run)->name,
        .fraction_done = run->fraction_done,
        .steps_per_second = run->steps_per_second,
        .elapsed_s = now - run->start_s,
        .time_left_s = run->steps_per_second > 0 ? steps_left / run->steps_per_second : -1,
        .time_left_kind = (int8_t)kind,
        .dimension = sample->particles.dimension,
        .strain = strain,
        .stress_wall_pa = stress,
        .kinetic_energy_j = run->sampled.kinetic_j,
        .elastic_energy_j = run->sampled.elastic_j,
        .commands_repeated = run->exchange.repeated,
        .interface_residual_j = sample->audit.residual_j,
        .controller_residual_j = sample->audit.controller_residual_j,
    };
    if (run->stream) {
        message->energy_residual_ratio = run->records.residual_ratio;
        message->records_repeated = record_sender_repeated(run->stream);
        message->records_waiting = record_sender_waiting(run->stream);
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

/* A run that is told to stop goes on to the next exchange, where it can write a checkpoint, but not for ever. */
static const double STOP_PATIENCE_S = 3;

enum status run_status_tick(struct run *run)
{
    double now = clock_now_s(), since = now - run->status_s, strain[3], stress[3];
    if (run->stream)
        TRY(record_sender_service(run->stream));
    if (stop_requested() && run->stop_s <= 0)
        run->stop_s = now;
    if (run->stop_s > 0 && now - run->stop_s > STOP_PATIENCE_S)
        return status_fail(STATUS_INTERRUPTED, "interrupted at %.0f %% (step %" PRId64 ")", 100 * run->fraction_done,
                           run->sample->step);
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
