/* bench_coupling --bin DIR --scenes DIR --out DIR [--scene NAME|FILE] [--scheme NAME] [--quick] [--json FILE] [--plot
 * FILE] [--lock FILES]: error against cost of the coupling schemes. The last stage of each scene goes from one prepared
 * sample through sim, wallctl and recorder over the bus, and beside it in one process with the exact loop, in turn
 * (docs/coupling.md). --shipped: the shipped scenes as they are coupled, and impedance beside.
 * SIGINT or SIGTERM: no more runs, but the report of what there is.
 * --lock A:B holds these locks while runs are timed, so that other work on the machine can wait for it. */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <time.h>
#include <unistd.h>

#include "bench/child.h"
#include "bench/coupling_bench.h"
#include "bench/element_tests.h"
#include "common/bus.h"
#include "common/command_line.h"
#include "common/scene_file.h"
#include "common/signals.h"

enum { ADAPTIVE_LONGEST = 1024, LOCKS_MAX = 4, TURN = 3 /* points beside one run in process */ };
static const double LIMIT_S = 120;    /* of a run */
static const double LOCK_HELD_S = 45; /* others get their turn after that */
static const double WORTH = 1.6;      /* a point that takes longer is timed once only */
static const double BUDGET_S = 840;   /* no further rounds after that */

/* Of the samples of seeds 1 to 5 of scene A, 2 has the median floor (docs/coupling.md). */
static const struct coupling_case cases[] = {
    {.name = "a",
     .title = "scene A: biaxial, kc = 0",
     .file = "biaxial.cfg",
     .override = {"seed=2"},
     .measure = MEASURE_STRESS,
     .rounds = 3,
     .target = {{5e-3, 1.15}, {1e-3, 1.5}}},
    {.name = "a-cohesion",
     .title = "scene A with kc = 2 k2, to 1.5 % of strain",
     .file = "biaxial.cfg",
     .override = {"seed=2", "material.kc_n_per_m=2e5"},
     .measure = MEASURE_EARLY,
     .rounds = 1,
     .few = true},
    {.name = "b",
     .title = "scene B: triaxial, one cycle",
     .file = "triaxial_cyclic.cfg",
     .measure = MEASURE_STRAIN,
     .duration_s = 1,
     .rounds = 3,
     .few = true,
     .target = {{1e-4, 1.05}}},
};
static const struct coupling_case quick_cases[] = {
    {.name = "a",
     .title = "scene A: biaxial, kc = 0",
     .file = "biaxial.cfg",
     .override = {"seed=2"},
     .measure = MEASURE_STRESS,
     .rounds = 1,
     .few = true,
     .target = {{5e-3, 1.15}, {1e-3, 1.5}}},
    {.name = "b",
     .title = "scene B: triaxial, a cycle of 0.1 s",
     .file = "triaxial_cyclic.cfg",
     .override = {"stages.2.walls.x.period_s=0.1"},
     .measure = MEASURE_STRAIN,
     .duration_s = 0.1,
     .rounds = 1,
     .few = true,
     .target = {{1e-4, 1.05}}},
};

enum { WORKS_MAX = 32, SHIPPED_STEPS = 50000 }; /* steps that are timed of a shipped scene's last stage */

struct bench {
    const struct coupling_options *options;
    struct coupling_case own[WORKS_MAX];
    char file[WORKS_MAX][64];
    struct coupling_work work[WORKS_MAX];
    int n_works;
    int lock[LOCKS_MAX], n_locks;
    double lock_s;        /* when the locks were taken; 0: they are not */
    double waited_s;      /* for them */
    double start_s;       /* of the timed runs */
    double planned, done; /* seconds of runs, as planned */
};

/* ---- locks ---- */

static enum status lock(struct bench *bench)
{
    char names[COUPLING_PATH_MAX];
    const double start = clock_now_s();
    if (!bench->options->lock || bench->lock_s > 0)
        return STATUS_OK;
    snprintf(names, sizeof names, "%s", bench->options->lock);
    bench->n_locks = 0;
    for (char *name = names, *next; name && bench->n_locks < LOCKS_MAX; name = next) {
        next = strchr(name, ':');
        if (next)
            *next++ = 0;
        int file = open(name, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        if (file < 0 || flock(file, LOCK_EX) != 0)
            return status_fail(STATUS_IO, "%s: %s", name, strerror(errno));
        bench->lock[bench->n_locks++] = file;
    }
    bench->lock_s = clock_now_s();
    bench->waited_s += bench->lock_s - start;
    return STATUS_OK;
}

static void unlock(struct bench *bench)
{
    while (bench->n_locks > 0)
        (void)close(bench->lock[--bench->n_locks]);
    bench->lock_s = 0;
}

/* Those who wait get the locks: who asks again at once is first. */
static void give_way(struct bench *bench)
{
    const struct timespec pause = {.tv_sec = 1};
    unlock(bench);
    (void)nanosleep(&pause, NULL);
    bench->waited_s += 1;
}

/* ---- the plan ---- */

static void add(struct coupling_work *work, int scheme, int n, double tolerance)
{
    const struct coupling_point point = {.scheme = scheme, .n = n, .tolerance = tolerance};
    const char *only = work->options->scheme;
    char name[64];
    coupling_point_name(&point, name, sizeof name);
    *strchr(name, ' ') = 0;
    if (work->n < COUPLING_POINTS_MAX && (!only || strcmp(only, name) == 0))
        work->point[work->n++] = point;
}

static void plan(struct coupling_work *work)
{
    static const int schemes[] = {SCHEME_HOLD, SCHEME_JACOBIAN, SCHEME_COMPENSATED, SCHEME_PIPELINED, SCHEME_IMPEDANCE};
    const int factor = work->at->few ? 4 : 2;
    if (work->at->shipped) {
        add(work, work->own.scheme, (int)work->own.interval_steps, work->own.tolerance);
        add(work, SCHEME_IMPEDANCE, (int)work->own.interval_steps, 0);
        return;
    }
    for (size_t s = 0; s < sizeof schemes / sizeof *schemes; s++)
        for (int n = 1; n <= 256; n *= factor)
            add(work, schemes[s], n, 0);
    if (work->at->few) { /* what scene A is shipped with, and the loop in the drive beside it */
        add(work, SCHEME_COMPENSATED, 8, 0);
        add(work, SCHEME_IMPEDANCE, 8, 0);
    }
    for (int digits = 2; digits <= 6; digits += work->at->few ? 2 : 1)
        add(work, SCHEME_ADAPTIVE, ADAPTIVE_LONGEST, pow(10, -digits));
}

/* Seconds that a run is expected to take: an exchange costs some 30 us. */
static double expected_s(const struct coupling_work *work, const struct coupling_point *point)
{
    double exchange_s = point->scheme == SCHEME_ADAPTIVE ? 3e-6 : 3e-5 / point->n;
    return 0.8 + work->reference_s + (double)work->steps * exchange_s;
}

static double turn_s(const struct coupling_work *work)
{
    return work->reference_s / TURN;
}

static void say(const struct bench *bench, const struct coupling_work *work, const char *what)
{
    double past = clock_now_s() - bench->start_s - bench->waited_s;
    double left = bench->done > 0 ? past / bench->done * (bench->planned - bench->done) : bench->planned;
    fprintf(stderr, "%-10s %-44s about %.0f s left\n", work->at->name, what, fmax(left, 0));
}

/* ---- runs ---- */

static enum status run_point(struct coupling_work *work, struct coupling_point *point, double reference_s)
{
    char folder[COUPLING_PATH_MAX + 16], run[COUPLING_PATH_MAX + 32], text[4][COUPLING_TEXT_MAX];
    struct curve_errors errors;
    snprintf(folder, sizeof folder, "%s/point", work->folder);
    snprintf(run, sizeof run, "%s/run.h5", folder);
    struct trial trial = {.bin = work->options->bin, .scene = work->scene_path, .folder = folder, .limit_s = LIMIT_S};
    coupling_point_override(point, &trial, text);
    enum status status = trial_run(&trial);
    if (stop_requested() && trial.exit_code != 0)
        return STATUS_OK; /* it was told to stop, too */
    point->exit_code = trial.exit_code;
    snprintf(point->message, sizeof point->message, "%s", status == STATUS_OK ? trial.message : status_message());
    if (status == STATUS_OK && trial.exit_code == 0)
        status = curve_errors_measure(work->reference, run, &errors);
    point->failed =
        status != STATUS_OK || (trial.exit_code != 0 && trial.exit_code != status_exit_code(STATUS_UNSTABLE));
    if (status != STATUS_OK)
        snprintf(point->message, sizeof point->message, "%s", status_message());
    point->ran = !point->failed && trial.exit_code == 0;
    if (!point->ran)
        return STATUS_OK; /* a result, too */
    point->errors = errors;
    if (point->n_ratios < COUPLING_ROUNDS_MAX)
        point->ratio[point->n_ratios++] = errors.elapsed_s / reference_s;
    return STATUS_OK;
}

static void tell(const struct bench *bench, const struct coupling_work *work, const struct coupling_point *point)
{
    char name[64], what[sizeof point->message + 128];
    coupling_point_name(point, name, sizeof name);
    if (point->ran)
        snprintf(what, sizeof what, "%-16s %6.3f times, %.1e", name, point->ratio[point->n_ratios - 1],
                 coupling_error(work->at, &point->errors));
    else
        snprintf(what, sizeof what, "%-16s %s%s", name, point->failed ? "failed: " : "unstable",
                 point->failed ? point->message : "");
    say(bench, work, what);
}

/* Whether time decides about it: its error is good enough for a target, or for the first one of other scenes. */
static bool is_worth(const struct coupling_work *work, const struct coupling_point *point)
{
    double wanted = work->at->target[0].error > 0 ? work->at->target[0].error : INFINITY;
    return point->ran && coupling_error(work->at, &point->errors) <= wanted && coupling_median_ratio(point) <= WORTH;
}

/* All points of a round, a run in process beside every few of them; forwards and backwards in turn. */
static enum status run_round(struct bench *bench, struct coupling_work *work, int round)
{
    struct curve_errors beside = {0};
    int since = TURN;
    for (int k = 0; k < work->n; k++) {
        struct coupling_point *point = &work->point[round % 2 == 0 ? k : work->n - 1 - k];
        if (round > 0 && !is_worth(work, point))
            continue;
        if (bench->lock_s > 0 && clock_now_s() - bench->lock_s > LOCK_HELD_S) {
            give_way(bench);
            since = TURN;
        }
        if (stop_requested())
            return STATUS_OK;
        TRY(lock(bench));
        if (since++ >= TURN) {
            since = 1;
            TRY(coupling_run_reference(work, "beside", &beside));
        }
        TRY(run_point(work, point, beside.elapsed_s));
        bench->done += expected_s(work, point) + turn_s(work);
        if (point->ran || point->exit_code != 0 || point->failed)
            tell(bench, work, point);
    }
    return STATUS_OK;
}

/* Later rounds are planned with what the first one has found. */
static void plan_rounds(struct bench *bench, const struct coupling_work *work)
{
    for (int k = 0; k < work->n; k++)
        if (is_worth(work, &work->point[k]))
            bench->planned += (work->at->rounds - 1) * (expected_s(work, &work->point[k]) + turn_s(work));
}

static enum status run_all(struct bench *bench)
{
    bench->start_s = clock_now_s();
    bench->waited_s = 0;
    for (int w = 0; w < bench->n_works; w++)
        for (int k = 0; k < bench->work[w].n; k++)
            bench->planned += expected_s(&bench->work[w], &bench->work[w].point[k]) + turn_s(&bench->work[w]);
    for (int w = 0; w < bench->n_works; w++) {
        TRY(run_round(bench, &bench->work[w], 0));
        plan_rounds(bench, &bench->work[w]);
    }
    for (int round = 1; round < COUPLING_ROUNDS_MAX; round++)
        for (int w = 0; w < bench->n_works; w++) {
            if (stop_requested() || round >= bench->work[w].at->rounds ||
                clock_now_s() - bench->start_s - bench->waited_s > BUDGET_S)
                continue;
            TRY(run_round(bench, &bench->work[w], round));
        }
    unlock(bench);
    return STATUS_OK;
}

/* ---- cases and report ---- */

/* What walls that stresses lead leave open is a strain; else it is the stress. */
static enum status measure_of(const char *folder, const char *file, int *measure)
{
    struct scene *scene = calloc(1, sizeof *scene);
    char path[COUPLING_PATH_MAX];
    snprintf(path, sizeof path, "%s/%s", folder, file);
    if (!scene)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    const enum status status = scene_load(scene, path, NULL, 0);
    if (status == STATUS_OK) {
        const int mode = scene->stage[scene->n_stages - 1].axis[AXIS_Z].mode;
        *measure = mode == WALL_STRESS || mode == WALL_COUPLED ? MEASURE_STRAIN : MEASURE_EARLY;
        scene_free(scene);
    }
    free(scene);
    return status;
}

/* The shipped scenes, or the one of that name: what the last stage of each costs as it is coupled. */
static enum status choose_shipped(struct bench *bench)
{
    const struct coupling_options *options = bench->options;
    for (int k = 0; k < element_tests_count && bench->n_works < WORKS_MAX; k++) {
        const struct element_test *test = &element_tests[k];
        const int n = bench->n_works;
        if (options->only && strcmp(options->only, test->scene) != 0)
            continue;
        snprintf(bench->file[n], sizeof bench->file[n], "%s.cfg", test->scene);
        bench->own[n] = (struct coupling_case){.name = test->scene,
                                               .title = test->scene,
                                               .file = bench->file[n],
                                               .steps_max = SHIPPED_STEPS,
                                               .shipped = true,
                                               .rounds = 1};
        TRY(measure_of(options->scenes, bench->file[n], &bench->own[n].measure));
        bench->work[bench->n_works++] = (struct coupling_work){.at = &bench->own[n], .options = options};
    }
    return STATUS_OK;
}

static void choose(struct bench *bench)
{
    const struct coupling_options *options = bench->options;
    const struct coupling_case *list = options->quick ? quick_cases : cases;
    const int n = (int)(options->quick ? sizeof quick_cases / sizeof *quick_cases : sizeof cases / sizeof *cases);
    for (int k = 0; k < n; k++)
        if (!options->only || strcmp(options->only, list[k].name) == 0 ||
            (strcmp(options->only, "hard") == 0 && strcmp(list[k].name, "a") == 0))
            bench->work[bench->n_works++] = (struct coupling_work){.at = &list[k], .options = options};
    if (bench->n_works > 0 || !options->only || access(options->only, R_OK) != 0)
        return;
    bench->own[0] = (struct coupling_case){.name = "own",
                                           .title = options->only,
                                           .file = options->only,
                                           .measure = MEASURE_STRESS,
                                           .rounds = options->quick ? 1 : 3,
                                           .few = options->quick};
    bench->work[bench->n_works++] = (struct coupling_work){.at = &bench->own[0], .options = options};
}

static bool wants(const struct coupling_options *options, const char *name)
{
    return !options->only || strcmp(options->only, name) == 0;
}

static enum status prepare_all(struct bench *bench)
{
    for (int w = 0; w < bench->n_works; w++) {
        TRY(lock(bench)); /* the reference gives the first time */
        TRY(coupling_prepare(&bench->work[w]));
        if (!bench->options->only || strcmp(bench->options->only, "hard") != 0)
            plan(&bench->work[w]);
        fprintf(stderr, "%-10s prepared; in process %.2f s, %.2f us per step; floor %.1e\n", bench->work[w].at->name,
                bench->work[w].reference_s, 1e6 * bench->work[w].reference_s / (double)bench->work[w].steps,
                coupling_error(bench->work[w].at, &bench->work[w].floor));
        unlock(bench);
    }
    return STATUS_OK;
}

static enum status write_report(const struct bench *bench, json_t *report)
{
    const struct coupling_options *options = bench->options;
    json_t *list = json_object_get(report, "cases");
    for (int w = 0; w < bench->n_works; w++)
        if (bench->work[w].n > 0)
            json_array_append_new(list, coupling_report(&bench->work[w]));
    if (options->shipped)
        coupling_shipped_report(bench->work, bench->n_works);
    if (bench->n_works > 0 && strcmp(bench->work[0].at->name, "a") == 0 && wants(options, "hard") && !stop_requested())
        json_object_set_new(report, "hard", coupling_hard(&bench->work[0]));
    if (options->json_path && json_dump_file(report, options->json_path, JSON_INDENT(1) | JSON_REAL_PRECISION(6)) != 0)
        return status_fail(STATUS_IO, "%s cannot be written", options->json_path);
    return options->plot ? coupling_plot(list, options->out, options->plot) : STATUS_OK;
}

static enum status bench_coupling(const struct coupling_options *options)
{
    struct bench *bench = calloc(1, sizeof *bench);
    if (!bench)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    bench->options = options;
    enum status status = folder_make(options->out);
    if (status == STATUS_OK && options->shipped)
        status = choose_shipped(bench);
    else
        choose(bench);
    if (status == STATUS_OK && bench->n_works == 0)
        status = options->shipped
                     ? status_fail(STATUS_USAGE, "--scene with --shipped is one of scenes/, without .cfg, not %s",
                                   options->only)
                     : status_fail(STATUS_USAGE, "--scene is a, a-cohesion, b, hard or a file, not %s", options->only);
    if (status == STATUS_OK)
        status = prepare_all(bench);
    if (status == STATUS_OK)
        status = run_all(bench);
    unlock(bench);
    json_t *report =
        json_pack("{s:b, s:i, s:[]}", "quick", options->quick, "cores", (int)sysconf(_SC_NPROCESSORS_ONLN), "cases");
    if (status == STATUS_OK)
        status = write_report(bench, report);
    json_decref(report);
    for (int w = 0; w < bench->n_works; w++)
        coupling_free(&bench->work[w]);
    free(bench);
    return status;
}

int main(int argc, char **argv)
{
    struct coupling_options options = {0};
    const struct command_line_option own[] = {{"bin", &options.bin, NULL},
                                              {"scenes", &options.scenes, NULL},
                                              {"out", &options.out, NULL},
                                              {"scene", &options.only, NULL},
                                              {"json", &options.json_path, NULL},
                                              {"plot", &options.plot, NULL},
                                              {"lock", &options.lock, NULL},
                                              {"scheme", &options.scheme, NULL},
                                              {"quick", NULL, &options.quick},
                                              {"shipped", NULL, &options.shipped},
                                              {NULL, NULL, NULL}};
    struct command_line line;
    enum status status = command_line_parse(&line, argc, argv, own);
    if (status == STATUS_OK && (!options.bin || !options.scenes || !options.out || line.n_positional > 0))
        status =
            status_fail(STATUS_USAGE, "--bin, --scenes and --out are needed; start it with ./shakedown bench coupling");
    options.override = line.override;
    options.n_overrides = line.n_overrides;
    if (status == STATUS_OK)
        status = signals_install();
    if (status == STATUS_OK)
        status = bench_coupling(&options);
    return status_report("bench_coupling", status);
}
