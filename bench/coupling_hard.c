/* Hard cases, in process: what each scheme does with the walls of the test of scene A. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/child.h"
#include "bench/coupling_bench.h"
#include "bench/prepared_sample.h"
#include "sim/run/checkpoint.h"
#include "sim/run/sample_source.h"
#include "sim/sample/sample.h"

struct hard_case {
    const char *name, *title;
    const char *override[4];
    double away_m; /* the wall under stress control starts that far from where it was */
};

static const struct hard_case hard_cases[] = {
    {"light", "light wall, m_x = 1e-4 kg", {"stages.0.walls.x.mass_kg=1e-4"}, 0},
    {"lighter", "lighter, m_x = 1e-6 kg", {"stages.0.walls.x.mass_kg=1e-6"}, 0},
    {"heavy", "heavy wall, m_x = 1 kg", {"stages.0.walls.x.mass_kg=1.0"}, 0},
    {"empty", "nothing within reach: the wall starts 50 mm away", {"stages.0.duration_s=5e-3"}, 0.05},
    {"contact", "sudden contact: 5 mm away, 2.6 m/s", {"stages.0.duration_s=1e-2"}, 0.005},
    {"undamped", "the same from 0.5 mm, gamma_x = 0.2 kg/s", {"stages.0.walls.x.damping_kg_per_s=0.2"}, 0.0005},
    {"pull",
     "kc = 4 k2 pulls the wall, p_x = 5 N/m^2",
     {"stages.0.material.kc_n_per_m=4e5", "stages.0.walls.x.pressure_pa=5.0"},
     0},
    {"fast", "f = 100 1/s", {"stages.0.walls.z.frequency_hz=100.0", "stages.0.duration_s=5e-3"}, 0},
};
static const double DURATION_S = 0.01, LIMIT_S = 60, TOLERANCE = 1e-4;
static const int schemes[] = {SCHEME_HOLD,      SCHEME_JACOBIAN,  SCHEME_COMPENSATED,
                              SCHEME_PIPELINED, SCHEME_IMPEDANCE, SCHEME_ADAPTIVE};
enum { SCHEMES = sizeof schemes / sizeof *schemes, ADAPTIVE_LONGEST = 256 };

struct hard_work {
    const struct coupling_work *from;
    const struct hard_case *at;
    char folder[COUPLING_PATH_MAX + 16], reference[COUPLING_PATH_MAX + 64], moved[CONFIG_STRING_MAX],
        shifted[CONFIG_STRING_MAX];
};

/* The sample with its upper wall in x moved, and with a particle shifted. */
static enum status vary(struct hard_work *work, double shift_m, const char *name, char *checkpoint)
{
    char path[COUPLING_PATH_MAX + 64];
    struct sample *sample;
    const struct run_progress progress = {0};
    snprintf(path, sizeof path, "%s/%s", work->folder, name);
    TRY(sample_from_scene(&sample, work->from->scene));
    sample->walls[1].x += work->at->away_m;
    sample->particles.x[0][sample->particles.count / 2] += shift_m;
    enum status status = checkpoint_write(path, sample, &progress);
    sample_free(sample);
    TRY(status);
    return prepare_path(path, checkpoint);
}

static enum status run(struct hard_work *work, const char *name, const char *checkpoint,
                       const struct coupling_point *point, struct trial *trial)
{
    char folder[COUPLING_PATH_MAX + 48], duration[64], start[CONFIG_STRING_MAX + 32], text[4][COUPLING_TEXT_MAX];
    snprintf(folder, sizeof folder, "%s/%s", work->folder, name);
    snprintf(duration, sizeof duration, "stages.0.duration_s=%g", DURATION_S);
    snprintf(start, sizeof start, "sample.checkpoint=\"%s\"", checkpoint);
    *trial = (struct trial){.bin = work->from->options->bin,
                            .scene = work->from->scene_path,
                            .folder = folder,
                            .in_process = true,
                            .limit_s = LIMIT_S};
    trial->override[trial->n_overrides++] = duration;
    trial->override[trial->n_overrides++] = start;
    trial->override[trial->n_overrides++] = "stages.0.cut_path=true";
    for (int k = 0; k < 4 && work->at->override[k]; k++)
        trial->override[trial->n_overrides++] = work->at->override[k];
    coupling_point_override(point, trial, text);
    return trial_run(trial);
}

static enum status run_point(struct hard_work *work, struct coupling_point *point)
{
    char path[COUPLING_PATH_MAX + 64];
    struct trial trial;
    snprintf(path, sizeof path, "%s/point/run.h5", work->folder);
    TRY(run(work, "point", work->moved, point, &trial));
    snprintf(point->message, sizeof point->message, "%s", trial.message);
    point->exit_code = trial.exit_code;
    point->ran = trial.exit_code == 0;
    point->failed = !point->ran && trial.exit_code != status_exit_code(STATUS_UNSTABLE);
    return point->ran ? curve_errors_measure(work->reference, path, &point->errors) : STATUS_OK;
}

static enum status run_reference(struct hard_work *work, struct curve_errors *floor)
{
    const struct coupling_point exact = {.scheme = SCHEME_HOLD, .n = 1};
    char path[COUPLING_PATH_MAX + 64];
    struct trial trial;
    snprintf(work->folder, sizeof work->folder, "%s/hard", work->from->folder);
    snprintf(work->reference, sizeof work->reference, "%s/reference/run.h5", work->folder);
    snprintf(path, sizeof path, "%s/floor/run.h5", work->folder);
    TRY(vary(work, 0, "moved.h5", work->moved));
    TRY(vary(work, 1e-13, "shifted.h5", work->shifted));
    TRY(run(work, "reference", work->moved, &exact, &trial));
    if (trial.exit_code != 0)
        return status_fail(STATUS_UNSTABLE, "exact loop: %s", trial.message);
    TRY(run(work, "floor", work->shifted, &exact, &trial));
    return curve_errors_measure(work->reference, path, floor);
}

static json_t *tell(const struct coupling_point *point)
{
    char name[64];
    coupling_point_name(point, name, sizeof name);
    if (point->ran)
        printf("    %-16s %.1e  position %.1e\n", name, point->errors.stress, point->errors.position);
    else
        printf("    %-16s %s: %s\n", name, point->failed ? "failed" : "stopped", point->message);
    *strchr(name, ' ') = 0;
    json_t *row = json_pack("{s:s, s:i, s:b, s:b}", "scheme", name, "interval_steps", point->n, "ran", point->ran,
                            "failed", point->failed);
    if (point->ran) {
        json_object_set_new(row, "stress", coupling_number(point->errors.stress));
        json_object_set_new(row, "position", coupling_number(point->errors.position));
        json_object_set_new(row, "exchanges", json_integer(point->errors.exchanges));
    } else
        json_object_set_new(row, "message", json_string(point->message));
    return row;
}

static bool is_wanted(const struct coupling_options *options, int scheme)
{
    const struct coupling_point point = {.scheme = scheme};
    char name[64];
    coupling_point_name(&point, name, sizeof name);
    *strchr(name, ' ') = 0;
    return !options->scheme || strcmp(options->scheme, name) == 0;
}

/* From short intervals to long ones; those beyond the first that is stopped are not tried. */
static enum status run_scheme(struct hard_work *work, int scheme, bool quick, json_t *rows)
{
    if (scheme == SCHEME_ADAPTIVE) {
        struct coupling_point point = {.scheme = scheme, .n = ADAPTIVE_LONGEST, .tolerance = TOLERANCE};
        TRY(run_point(work, &point));
        json_array_append_new(rows, tell(&point));
        return STATUS_OK;
    }
    for (int n = quick ? 16 : 2; n <= 256; n *= quick ? 16 : 2) {
        struct coupling_point point = {.scheme = scheme, .n = n};
        TRY(run_point(work, &point));
        json_array_append_new(rows, tell(&point));
        if (!point.ran)
            return STATUS_OK;
    }
    return STATUS_OK;
}

static json_t *run_case(const struct coupling_work *from, const struct hard_case *at)
{
    struct hard_work work = {.from = from, .at = at};
    struct curve_errors floor = {0};
    json_t *rows = json_array();
    fprintf(stderr, "%-10s %s\n", "hard", at->title);
    enum status status = run_reference(&work, &floor);
    printf("  %s: floor %.1e, position %.1e\n", at->title, floor.stress, floor.position);
    for (int s = 0; s < SCHEMES && status == STATUS_OK; s++)
        if (is_wanted(from->options, schemes[s]))
            status = run_scheme(&work, schemes[s], from->options->quick, rows);
    json_t *result =
        json_pack("{s:s, s:s, s:o, s:o, s:o}", "name", at->name, "title", at->title, "floor",
                  coupling_number(floor.stress), "floor_position", coupling_number(floor.position), "rows", rows);
    if (status != STATUS_OK) { /* a result, too */
        printf("    %s\n", status_message());
        json_object_set_new(result, "message", json_string(status_message()));
    }
    return result;
}

json_t *coupling_hard(const struct coupling_work *work)
{
    json_t *result = json_array();
    char folder[COUPLING_PATH_MAX + 16];
    snprintf(folder, sizeof folder, "%s/hard", work->folder);
    printf("\nhard cases, in process, %g s: error of the stress against the exact loop\n", DURATION_S);
    if (folder_make(folder) != STATUS_OK)
        return result;
    for (size_t k = 0; k < sizeof hard_cases / sizeof *hard_cases; k++)
        json_array_append_new(result, run_case(work, &hard_cases[k]));
    return result;
}
