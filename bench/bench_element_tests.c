/* bench_element_tests --bin DIR --scenes DIR --out DIR [--quick] [--bus] [--exact] [SCENE]...: runs the shipped scenes
 * and says how well each kept what it is to keep. --bus: through sim, wallctl and recorder, else in one process.
 * --exact: short forms of few grains both ways, at an exchange in every step, and whether they come to the same bits.
 * Exit code 1 if a scene does not keep to a bound. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "analyzer/analysis.h"
#include "bench/child.h"
#include "bench/curve_errors.h"
#include "bench/element_tests.h"
#include "bench/trial_run.h"
#include "common/command_line.h"

/* What is asked: p and q to 0.1 %, volumes to 1e-6, at inertial numbers below 1e-3. */
static const double STRESS_TOLERANCE = 1e-3, VOLUME_TOLERANCE = 1e-6, INERTIAL_BOUND = 1e-3;
static const double LIMIT_S = 600; /* of a run */

/* --exact: bits are as equal for few grains that hardly rest, and an exchange in every step takes its time. */
static const char *const exact_settings[] = {"coupling.interval_steps=1", "sample.count=64", "stages.0.duration_s=0.4",
                                             "stages.1.duration_s=0.05"};

struct options {
    const char *bin, *scenes, *out;
    bool quick, bus, exact;
    struct command_line line; /* scenes; seed and settings for all of them */
};

static double now_s(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static enum status run_one(const struct options *options, const struct element_test *test, bool bus, char *folder,
                           size_t size)
{
    char scene[1024];
    snprintf(scene, sizeof scene, "%s/%s.cfg", options->scenes, test->scene);
    snprintf(folder, size, "%s/%s%s", options->out, test->scene, bus ? "-bus" : "");
    struct trial trial = {
        .bin = options->bin, .scene = scene, .folder = folder, .in_process = !bus, .limit_s = LIMIT_S};
    for (int k = 0; (options->quick || options->exact) && k < ELEMENT_TEST_SETTINGS && test->quick[k]; k++)
        trial.override[trial.n_overrides++] = test->quick[k];
    for (size_t k = 0; options->exact && k < sizeof exact_settings / sizeof exact_settings[0]; k++)
        trial.override[trial.n_overrides++] = exact_settings[k];
    for (int k = 0; k < options->line.n_overrides && trial.n_overrides < TRIAL_OVERRIDES_MAX; k++)
        trial.override[trial.n_overrides++] = options->line.override[k];
    TRY(trial_run(&trial));
    if (trial.exit_code != 0 && trial.exit_code != status_exit_code(STATUS_DOUBTFUL))
        return status_fail(STATUS_LIMIT, "%s: %s", test->scene, trial.message);
    return STATUS_OK;
}

/* One line for each thing that is kept; counts what is beyond its bound. */
static void kept_print(const struct element_test *test, const struct analysis *analysis, int *beyond)
{
    static const enum quantity_id kept[] = {QUANTITY_KEPT_VOLUME, QUANTITY_KEPT_P,      QUANTITY_KEPT_Q,
                                            QUANTITY_KEPT_PATH,   QUANTITY_KEPT_STRESS, QUANTITY_KEPT_B};
    for (size_t k = 0; k < sizeof kept / sizeof kept[0]; k++) {
        const struct quantity *quantity = &analysis->quantity[kept[k]];
        const double bound = kept[k] == QUANTITY_KEPT_VOLUME ? VOLUME_TOLERANCE : STRESS_TOLERANCE;
        if (quantity->absent)
            continue;
        const bool kept_well = quantity->value <= bound;
        *beyond += !kept_well && !test->published;
        printf("  %s %.1e", quantity_key(kept[k]) + strlen("kept."), quantity->value);
        if (!test->published)
            printf(" (%.0e%s)", bound, kept_well ? "" : ": BEYOND");
    }
}

static void row_print(const struct element_test *test, const struct analysis *analysis, double wall_s, int *beyond)
{
    const double inertial = analysis->quantity[QUANTITY_INERTIAL_MAX].value;
    const bool slow = inertial < INERTIAL_BOUND, sound = analysis->judgement.verdict == WORTH_SOUND;
    *beyond += (!slow && !test->published) + !sound;
    printf("%-24s %-26s %6.1f %9.1e%s %-9s", test->scene, test->test, wall_s, inertial,
           slow ? "  " : (test->published ? "  " : " !"), judgement_worth_name(analysis->judgement.verdict));
    kept_print(test, analysis, beyond);
    printf("\n");
    for (size_t k = 0; !sound && k < analysis->judgement.n; k++)
        if (analysis->judgement.note[k].severity > WORTH_SOUND)
            printf("    %s: %s\n", analysis->judgement.note[k].stage, analysis->judgement.note[k].text);
}

static enum status measure(const struct options *options, const struct element_test *test, int *beyond)
{
    struct analysis analysis;
    char folder[2048];
    const double start_s = now_s();
    TRY(run_one(options, test, options->bus, folder, sizeof folder));
    const double wall_s = now_s() - start_s;
    TRY(analysis_make(&analysis, folder, NULL));
    row_print(test, &analysis, wall_s, beyond);
    analysis_free(&analysis);
    return STATUS_OK;
}

/* The hash of the last state, in one process and over the bus. */
static enum status compare(const struct options *options, const struct element_test *test, int *beyond)
{
    int64_t hash[2];
    for (int bus = 0; bus < 2; bus++) {
        char folder[2048], path[2100];
        TRY(run_one(options, test, bus, folder, sizeof folder));
        snprintf(path, sizeof path, "%s/run.h5", folder);
        hash[bus] = run_attribute_i64(path, "state_hash");
    }
    const bool same = hash[0] == hash[1] && hash[0] != 0;
    *beyond += !same;
    printf("%-24s %016" PRIx64 " %016" PRIx64 " %s\n", test->scene, (uint64_t)hash[0], (uint64_t)hash[1],
           same ? "the same bits" : "DIFFERENT");
    return STATUS_OK;
}

/* A scene that fails costs only itself. */
static int one(const struct options *options, const struct element_test *test, int *beyond)
{
    const enum status status = options->exact ? compare(options, test, beyond) : measure(options, test, beyond);
    if (status != STATUS_OK) {
        printf("%-24s FAILED\n", test->scene);
        (*beyond)++;
        return status_report("bench_element_tests", status);
    }
    fflush(stdout);
    return 0;
}

/* Those that are named, or all. */
static int all(const struct options *options)
{
    const int named = options->line.n_positional, n = named > 0 ? named : element_tests_count;
    int beyond = 0, failed = 0;
    if (folder_make(options->out) != STATUS_OK)
        return status_report("bench_element_tests", STATUS_IO);
    if (!options->exact)
        printf("%-24s %-26s %6s %9s   %-9s  %s\n", "scene", "test", "time/s", "I, max", "verdict",
               "kept to, largest (bound)");
    for (int k = 0; k < n; k++) {
        const struct element_test *test = named ? element_test_find(options->line.positional[k]) : &element_tests[k];
        if (!test)
            return status_report("bench_element_tests",
                                 status_fail(STATUS_USAGE, "no scene %s", options->line.positional[k]));
        if (test->published && (options->quick || options->exact))
            continue;
        const int code = one(options, test, &beyond);
        failed = failed ? failed : code;
    }
    return failed ? failed : beyond > 0;
}

int main(int argc, char **argv)
{
    struct options options = {.out = NULL};
    const struct command_line_option own[] = {{"bin", &options.bin, NULL}, {"scenes", &options.scenes, NULL},
                                              {"out", &options.out, NULL}, {"quick", NULL, &options.quick},
                                              {"bus", NULL, &options.bus}, {"exact", NULL, &options.exact},
                                              {NULL, NULL, NULL}};
    enum status status = command_line_parse(&options.line, argc, argv, own);
    if (status == STATUS_OK && (!options.bin || !options.scenes || !options.out))
        status = status_fail(STATUS_USAGE, "--bin, --scenes and --out are needed; start it with ./shakedown bench "
                                           "element-tests");
    if (status != STATUS_OK)
        return status_report("bench_element_tests", status);
    return all(&options);
}
