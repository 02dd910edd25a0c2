#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/coupling_bench.h"
#include "bench/prepared_sample.h"
#include "common/scene_file.h"
#include "sim/run/checkpoint.h"
#include "sim/run/sample_source.h"
#include "sim/sample/sample.h"

enum { OVERRIDES_MAX = 32 };
static const double SHIFT_M = 1e-13, LIMIT_S = 300;
static const char *const scheme_name[] = {
    [SCHEME_HOLD] = "hold",         [SCHEME_JACOBIAN] = "jacobian",   [SCHEME_PIPELINED] = "pipelined",
    [SCHEME_ADAPTIVE] = "adaptive", [SCHEME_IMPEDANCE] = "impedance", [SCHEME_COMPENSATED] = "compensated"};

void coupling_point_override(const struct coupling_point *point, struct trial *trial, char text[][COUPLING_TEXT_MAX])
{
    snprintf(text[0], COUPLING_TEXT_MAX, "coupling.scheme=\"%s\"", scheme_name[point->scheme]);
    snprintf(text[1], COUPLING_TEXT_MAX, "coupling.interval_steps=%d", point->n);
    trial->override[trial->n_overrides++] = text[0];
    trial->override[trial->n_overrides++] = text[1];
    if (point->scheme != SCHEME_ADAPTIVE)
        return;
    snprintf(text[2], COUPLING_TEXT_MAX, "coupling.tolerance=%g", point->tolerance);
    trial->override[trial->n_overrides++] = text[2];
}

void coupling_point_name(const struct coupling_point *point, char *text, size_t size)
{
    if (point->scheme == SCHEME_ADAPTIVE)
        snprintf(text, size, "%s %.0e", scheme_name[point->scheme], point->tolerance);
    else
        snprintf(text, size, "%s %d", scheme_name[point->scheme], point->n);
}

double coupling_error(const struct coupling_case *at, const struct curve_errors *errors)
{
    const double error[] = {
        [MEASURE_STRESS] = errors->stress, [MEASURE_EARLY] = errors->early, [MEASURE_STRAIN] = errors->strain};
    return error[at->measure];
}

static enum status make_shifted(struct coupling_work *work)
{
    char path[COUPLING_PATH_MAX + 32];
    struct sample *sample;
    const struct run_progress progress = {0};
    snprintf(path, sizeof path, "%s/shifted.h5", work->folder);
    TRY(sample_from_scene(&sample, work->scene));
    sample->particles.x[0][sample->particles.count / 2] += SHIFT_M;
    enum status status = checkpoint_write(path, sample, &progress);
    sample_free(sample);
    TRY(status);
    return prepare_path(path, work->shifted);
}

/* What would end the stage would end it at another step in each run. */
static void without_conditions(struct scene_stage *stage)
{
    stage->until_energy_ratio = stage->until_stress_error = stage->until_r_u = 0;
    stage->until_q_pa.count = stage->until_q_over_p.count = 0;
    for (int a = 0; a < SCENE_AXES; a++)
        stage->axis[a].until_strain.count = stage->axis[a].until_stress_pa.count = 0;
}

/* The last stage as a scene of its own, exact unless told otherwise, without frames: a run is its steps and samples. */
static void set_stage(struct coupling_work *work)
{
    struct scene_stage *stage = &work->scene->stage[0];
    if (work->at->duration_s > 0)
        stage->duration_s = work->at->duration_s;
    if (work->at->steps_max > 0)
        stage->duration_s = fmin(scene_total_time_s(work->scene), work->at->steps_max * stage->dt_s);
    if (work->at->shipped)
        without_conditions(stage);
    stage->cut_path = true; /* of a path a piece is timed */
    stage->frame_interval_s = 0;
    stage->frame_strains.count = 0;
    work->scene->coupling.scheme = SCHEME_HOLD;
    work->scene->coupling.interval_steps = 1;
    work->scene->record.walls = RECORD_WALLS_SAMPLED;
    work->scene->record.event_log = false;
    work->scene->analysis.stage[0] = 0;
}

static enum status make_scene(struct coupling_work *work)
{
    char path[COUPLING_PATH_MAX], sim[COUPLING_PATH_MAX];
    const char *override[OVERRIDES_MAX] = {"coupling.scheme=\"hold\"", "coupling.interval_steps=1",
                                           "record.walls=\"sampled\"", "record.event_log=false"};
    int n = 4;
    for (int k = 0; k < 2 && work->at->override[k]; k++)
        override[n++] = work->at->override[k];
    for (int k = 0; k < work->options->n_overrides && n < OVERRIDES_MAX; k++)
        override[n++] = work->options->override[k];
    if (strchr(work->at->file, '/'))
        snprintf(path, sizeof path, "%s", work->at->file);
    else
        snprintf(path, sizeof path, "%s/%s", work->options->scenes, work->at->file);
    snprintf(sim, sizeof sim, "%s/sim/sim", work->options->bin);
    TRY(prepare_sample(sim, path, override, n, work->folder, work->checkpoint));
    work->scene = calloc(1, sizeof *work->scene);
    if (!work->scene)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    TRY(scene_load(work->scene, path, override + 4, n - 4));
    work->own = work->scene->coupling;
    prepare_stage(work->scene, (int)work->scene->n_stages - 1, work->checkpoint);
    set_stage(work);
    snprintf(work->scene_path, sizeof work->scene_path, "%s/last.cfg", work->folder);
    TRY(prepare_scene_file(work->scene, work->scene_path));
    return make_shifted(work);
}

static enum status run_exact(struct coupling_work *work, const char *name, const char *checkpoint,
                             struct curve_errors *errors)
{
    char folder[COUPLING_PATH_MAX + 16], run[COUPLING_PATH_MAX + 32], start[CONFIG_STRING_MAX + 32];
    snprintf(folder, sizeof folder, "%s/%s", work->folder, name);
    snprintf(run, sizeof run, "%s/run.h5", folder);
    struct trial trial = {
        .bin = work->options->bin, .scene = work->scene_path, .folder = folder, .in_process = true, .limit_s = LIMIT_S};
    snprintf(start, sizeof start, "sample.checkpoint=\"%s\"", checkpoint);
    trial.override[trial.n_overrides++] = start;
    TRY(trial_run(&trial));
    if (trial.exit_code != 0)
        return status_fail(STATUS_UNSTABLE, "%s: the exact loop ended badly: %s", work->at->name, trial.message);
    return curve_errors_measure(work->reference[0] ? work->reference : run, run, errors);
}

enum status coupling_run_reference(struct coupling_work *work, const char *folder, struct curve_errors *errors)
{
    TRY(run_exact(work, folder, work->checkpoint, errors));
    if (!(work->reference_s > 0) || errors->elapsed_s < work->reference_s)
        work->reference_s = errors->elapsed_s;
    return STATUS_OK;
}

enum status coupling_prepare(struct coupling_work *work)
{
    struct curve_errors itself;
    snprintf(work->folder, sizeof work->folder, "%s/%s", work->options->out, work->at->name);
    TRY(make_scene(work));
    TRY(coupling_run_reference(work, "reference", &itself));
    snprintf(work->reference, sizeof work->reference, "%s/reference/run.h5", work->folder);
    work->steps = itself.steps;
    return run_exact(work, "floor", work->shifted, &work->floor);
}

void coupling_free(struct coupling_work *work)
{
    if (work->scene)
        scene_free(work->scene);
    free(work->scene);
    work->scene = NULL;
}
