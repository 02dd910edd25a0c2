/* bench_accuracy --bin DIR --scenes DIR --out DIR [--scene NAME] [--quick] [--json FILE] [--plot FILE.png]
 * [--from FILE] [--through COMMAND] [--set key=value]...: how far the curve of a run is from that of the finest run,
 * how well its energy ledger closes, and what it costs, as time step, skin, exchange interval and precision vary; all
 * from one prepared sample; beside it what a shift of one particle by 1e-13 m does (docs/accuracy.md). */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/accuracy_curve.h"
#include "bench/accuracy_plot.h"
#include "bench/child.h"
#include "bench/prepared_sample.h"
#include "common/command_line.h"
#include "common/floating_point.h"
#include "common/scene_file.h"
#include "sim/run/checkpoint.h"
#include "sim/run/sample_source.h"
#include "sim/sample/sample.h"

enum { RUNS_MAX = 64, OVERRIDES_MAX = 4, STEPS_MAX = 8, OVERRIDE_MAX = 320, WINDOWS = 3, ARGUMENTS_MAX = 300 };
static const double SHIFT_M = 1e-13;

struct accuracy_case {
    const char *name, *file;
    const char *override; /* of the last stage; NULL: none */
    enum curve_quantity quantity;
    int component;
    const char *curve;
    bool steps_only; /* no skins and intervals */
    bool no_springs; /* the sample starts without tangential springs: theirs are those of the step it was made with */
    double window[WINDOWS];                    /* errors for strains up to this; rising, the last one all */
    double duration_s;                         /* of the last stage; 0: as it is */
    double sample_interval_s;                  /* a multiple of all time steps */
    double stiffness;                          /* N/m and mean radius [m], for the contact time of two mean particles */
    double radius_m;                           /* [m] */
    double dt[STEPS_MAX], quick_dt[STEPS_MAX]; /* s, falling, the last one the reference; 0 ends */
    double usual_dt;                           /* for all but the time step; one of both lists */
};

static const struct accuracy_case CASES[] = {
    {.name = "A",
     .file = "biaxial.cfg",
     .quantity = CURVE_STRESS_WALL,
     .component = 1,
     .curve = "sigma_zz(eps_zz)",
     .window = {0.001, 0.015, INFINITY},
     .sample_interval_s = 5e-5,
     .stiffness = 1e5,
     .radius_m = 1e-3,
     .dt = {2e-6, 1e-6, 5e-7, 2.5e-7, 1e-7, 5e-8},
     .quick_dt = {1e-6, 5e-7, 2.5e-7},
     .usual_dt = 5e-7},
    {.name = "A-cohesive",
     .file = "biaxial.cfg",
     .override = "stages.0.material.kc_n_per_m=1e5",
     .quantity = CURVE_STRESS_WALL,
     .component = 1,
     .curve = "sigma_zz(eps_zz), kc = k2",
     .steps_only = true,
     .window = {0.001, 0.015, INFINITY},
     .sample_interval_s = 5e-5,
     .stiffness = 1e5,
     .radius_m = 1e-3,
     .dt = {2e-6, 1e-6, 5e-7, 2.5e-7, 1e-7, 5e-8},
     .usual_dt = 5e-7},
    {.name = "B",
     .file = "triaxial_quick.cfg",
     .quantity = CURVE_STRAIN,
     .component = 0,
     .curve = "eps_xx of one cycle of sigma_xx",
     .window = {INFINITY, INFINITY, INFINITY},
     .duration_s = 0.2,
     .sample_interval_s = 2e-3,
     .stiffness = 5e3,
     .radius_m = 5e-3,
     .dt = {1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2.5e-6},
     .quick_dt = {5e-5, 2e-5, 1e-5, 5e-6},
     .usual_dt = 2e-5},
    {.name = "B-fresh",
     .file = "triaxial_quick.cfg",
     .quantity = CURVE_STRAIN,
     .component = 0,
     .curve = "eps_xx of one cycle of sigma_xx, no springs at the start",
     .no_springs = true,
     .steps_only = true,
     .window = {INFINITY, INFINITY, INFINITY},
     .duration_s = 0.2,
     .sample_interval_s = 2e-3,
     .stiffness = 5e3,
     .radius_m = 5e-3,
     .dt = {1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2.5e-6},
     .usual_dt = 2e-5},
};

struct options {
    const char *bin, *scenes, *out, *only, *json_path, *plot, *through, *from;
    bool quick;
    const struct command_line *line; /* its overrides are those of every run */
};

struct run {
    char series[16];
    double value; /* of what varies */
    double dt_s;
    char override[OVERRIDES_MAX][OVERRIDE_MAX];
    int n_overrides;
    bool ran;
    struct curve curve;
    double cpu_s;
    double error[WINDOWS];      /* to the finest run if the time step varies, else to the usual settings */
    double finest[WINDOWS];     /* to the finest run */
    double order, ledger_order; /* from the coarser time step to this one; NaN: not to be seen */
};

struct work {
    const struct accuracy_case *at;
    const struct options *options;
    const char *sim;
    char folder[1024], checkpoint[CONFIG_STRING_MAX], shifted[CONFIG_STRING_MAX], scene_path[1100];
    struct run run[RUNS_MAX];
    int n, reference, usual, floor; /* indices of runs */
};

static double contact_time_s(const struct accuracy_case *at)
{
    const double pi = acos(-1.0), density = 2000;
    double mass = 4.0 / 3 * pi * density * at->radius_m * at->radius_m * at->radius_m;
    return pi * sqrt(0.5 * mass / at->stiffness);
}

static struct run *add(struct work *work, const char *series, double value, double dt_s)
{
    struct run *run = &work->run[work->n++];
    *run = (struct run){.value = value, .dt_s = dt_s, .order = NAN, .ledger_order = NAN};
    snprintf(run->series, sizeof run->series, "%s", series);
    snprintf(run->override[0], OVERRIDE_MAX, "stages.0.dt_s=%.17g", dt_s);
    run->n_overrides = 1;
    return run;
}

static void add_override(struct run *run, const char *format, const char *text, double value)
{
    snprintf(run->override[run->n_overrides], OVERRIDE_MAX, format, text, value);
    run->n_overrides++;
}

static void add_intervals(struct work *work, const char *scheme, bool quick)
{
    static const int all[] = {2, 4, 8, 16, 32, 64}, few[] = {4, 16};
    const int *n = quick ? few : all, count = quick ? 2 : 6;
    for (int k = 0; k < count; k++) {
        struct run *run = add(work, scheme, n[k], work->at->usual_dt);
        add_override(run, "coupling.scheme=\"%s\"", scheme, 0);
        add_override(run, "coupling.interval_steps=%s%.0f", "", n[k]);
    }
}

static void plan(struct work *work, bool quick)
{
    static const double skins[] = {0.05, 0.6};
    const double *dt = quick ? work->at->quick_dt : work->at->dt;
    for (int k = 0; k < STEPS_MAX && dt[k] > 0; k++) {
        if (dt[k] == work->at->usual_dt)
            work->usual = work->n;
        work->reference = work->n;
        add(work, "dt", dt[k], dt[k]);
    }
    work->floor = work->n;
    struct run *run = add(work, "floor", SHIFT_M, work->at->usual_dt);
    add_override(run, "sample.checkpoint=\"%s\"", work->shifted, 0);
    run = add(work, "precision", 32, work->at->usual_dt);
    add_override(run, "precision=\"%s\"", "mixed", 0);
    if (work->at->steps_only)
        return;
    for (size_t k = 0; k < sizeof skins / sizeof *skins && !quick; k++)
        add_override(add(work, "skin", skins[k], work->at->usual_dt), "neighbor.skin_ratio=%s%.17g", "", skins[k]);
    add_intervals(work, "hold", quick);
    add_intervals(work, "jacobian", quick);
    add_intervals(work, "compensated", quick);
}

/* The sample of `scene` once more as FOLDER/NAME, without springs if so wanted, and with one particle shifted. */
static enum status vary_sample(const struct work *work, const struct scene *scene, bool no_springs, double shift_m,
                               const char *name, char *checkpoint)
{
    char path[1100];
    struct sample *sample;
    const struct run_progress progress = {0};
    snprintf(path, sizeof path, "%s/%s", work->folder, name);
    TRY(sample_from_scene(&sample, scene));
    sample->particles.x[0][sample->particles.count / 2] += shift_m;
    enum status status = no_springs ? prepare_forget(sample) : STATUS_OK;
    if (status == STATUS_OK)
        status = checkpoint_write(path, sample, &progress);
    sample_free(sample);
    TRY(status);
    return prepare_path(path, checkpoint);
}

static void set_stage(const struct accuracy_case *at, struct scene *scene)
{
    struct scene_stage *stage = &scene->stage[0];
    if (at->duration_s > 0)
        stage->duration_s = at->duration_s;
    stage->cut_path = true; /* a piece of the test */
    stage->sample_interval_s = at->sample_interval_s;
    stage->frame_interval_s = 0;
    stage->frame_strains.count = 0;
    scene->coupling.interval_steps = 1;
    scene->coupling.scheme = SCHEME_HOLD;
    scene->precision = PRECISION_DOUBLE;
}

static enum status make_scene(struct work *work, struct scene *scene, const char *path)
{
    TRY(prepare_sample(work->sim, path, NULL, 0, work->folder, work->checkpoint));
    TRY(scene_load(scene, path, NULL, 0));
    prepare_stage(scene, (int)scene->n_stages - 1, work->checkpoint);
    set_stage(work->at, scene);
    if (work->at->no_springs) {
        TRY(vary_sample(work, scene, true, 0, "no-springs.h5", work->checkpoint));
        prepare_stage(scene, 0, work->checkpoint);
    }
    snprintf(work->scene_path, sizeof work->scene_path, "%s/last.cfg", work->folder);
    TRY(prepare_scene_file(scene, work->scene_path));
    return vary_sample(work, scene, false, SHIFT_M, "shifted.h5", work->shifted);
}

static int add_set(const char **argv, int n, const char *override)
{
    if (!override || n + 3 > ARGUMENTS_MAX)
        return n;
    argv[n] = "--set";
    argv[n + 1] = override;
    return n + 2;
}

/* sim in one process, samples into a log. One that became unstable is a result, too. */
static enum status run_one(const struct work *work, struct run *run)
{
    char url[1200], path[1100], words[1100];
    const struct command_line *line = work->options->line;
    const char *argv[ARGUMENTS_MAX];
    int n = 0;
    snprintf(path, sizeof path, "%s/run.lcm", work->folder);
    (void)remove(path); /* of the run before */
    snprintf(url, sizeof url, "file://%s?mode=w", path);
    snprintf(words, sizeof words, "%s/run.log", work->folder);
    if (work->options->through)
        argv[n++] = work->options->through;
    const char *const fixed[] = {work->sim, work->scene_path, "--in-process", "--lcm", url};
    for (size_t k = 0; k < sizeof fixed / sizeof *fixed; k++)
        argv[n++] = fixed[k];
    n = add_set(argv, n, work->at->override);
    for (int k = 0; k < line->n_overrides; k++)
        n = add_set(argv, n, line->override[k]);
    for (int k = 0; k < run->n_overrides; k++)
        n = add_set(argv, n, run->override[k]);
    argv[n] = NULL;
    struct child child = {.argv = argv, .log = words};
    enum status status = child_run(&child);
    if (status != STATUS_OK && child.exit_code == status_exit_code(STATUS_UNSTABLE))
        return STATUS_OK;
    TRY(status);
    TRY(curve_read(&run->curve, path, work->at->quantity, work->at->component));
    run->cpu_s = child.cpu_s;
    run->ran = true;
    return STATUS_OK;
}

static enum status compare(struct work *work, struct run *run)
{
    const struct run *reference = &work->run[work->reference], *usual = &work->run[work->usual];
    bool step = strcmp(run->series, "dt") == 0;
    for (int w = 0; w < WINDOWS && run->ran; w++) {
        double window = work->at->window[w];
        TRY(curve_error(&run->curve, &reference->curve, window, &run->finest[w]));
        TRY(curve_error(&run->curve, step ? &reference->curve : &usual->curve, window, &run->error[w]));
    }
    return STATUS_OK;
}

/* Orders in the first window, from errors that stand clear of the floor there, and of the reference's own error: those
 * of the last but one do not. The ledger needs no reference. */
static void find_orders(struct work *work)
{
    double floor = work->run[work->floor].ran ? work->run[work->floor].error[0] : 0;
    for (int k = 1; k <= work->reference; k++) {
        struct run *a = &work->run[k - 1], *b = &work->run[k];
        if (!a->ran || !b->ran)
            continue;
        b->ledger_order = convergence_order(a->dt_s, a->curve.residual_ratio, b->dt_s, b->curve.residual_ratio);
        if (k + 1 < work->reference && b->error[0] > 5 * floor)
            b->order = convergence_order(a->dt_s, a->error[0], b->dt_s, b->error[0]);
    }
}

static json_t *number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

/* Errors in all windows; one column if there is but one. */
static void print_errors(const struct work *work, const struct run *run)
{
    for (int w = 0; w < WINDOWS; w++)
        if (w + 1 == WINDOWS || isfinite(work->at->window[w]))
            printf(" %10.1e", run->error[w]);
}

static void print_order(double order)
{
    if (isfinite(order))
        printf(" %5.1f", order);
    else
        printf("     -");
}

static void print_run(const struct work *work, const struct run *run)
{
    const struct run *usual = &work->run[work->usual];
    printf("  %-9s %9.4g  t_c/%-5.0f", run->series, run->value, contact_time_s(work->at) / run->dt_s);
    if (!run->ran) {
        printf(" unstable\n");
        return;
    }
    printf(" %8.2f", run->cpu_s);
    print_errors(work, run);
    print_order(run->order);
    printf(" %10.1e", run->curve.residual_ratio);
    print_order(run->ledger_order);
    if (run == &work->run[work->reference])
        printf("   finest");
    if (run == usual)
        printf("   usual");
    else if (run->curve.hash == usual->curve.hash)
        printf("   same bits as usual");
    printf("\n");
}

static json_t *errors(const double *error)
{
    return json_pack("[f, f, f]", error[0], error[1], error[2]);
}

static json_t *row_of(const struct work *work, const struct run *run)
{
    json_t *row = json_pack("{s:s, s:f, s:f, s:f, s:b}", "series", run->series, "value", run->value, "dt_s", run->dt_s,
                            "contact_time_over_dt", contact_time_s(work->at) / run->dt_s, "ran", run->ran);
    if (!run->ran)
        return row;
    json_object_set_new(row, "cpu_s", json_real(run->cpu_s));
    json_object_set_new(row, "error", errors(run->error));
    json_object_set_new(row, "error_to_finest", errors(run->finest));
    json_object_set_new(row, "order", number(run->order));
    json_object_set_new(row, "residual_ratio", json_real(run->curve.residual_ratio));
    json_object_set_new(row, "ledger_order", number(run->ledger_order));
    return row;
}

static void report(const struct work *work, json_t *cases)
{
    json_t *rows = json_array(), *windows = json_array();
    printf("\nscene %s: %s of %s; t_c = %.3g s; rows of dt against the finest, others against the usual settings\n",
           work->at->name, work->at->curve, work->at->file, contact_time_s(work->at));
    printf("  %-9s %9s  %-9s %8s", "varied", "value", "dt", "CPU s");
    for (int w = 0; w < WINDOWS; w++) {
        json_array_append_new(windows, number(work->at->window[w]));
        if (w + 1 < WINDOWS && isfinite(work->at->window[w]))
            printf("  to %4.1f %%", 100 * work->at->window[w]);
    }
    printf(" %10s %5s %10s %5s\n", "all", "order", "ledger", "order");
    for (int k = 0; k < work->n; k++) {
        print_run(work, &work->run[k]);
        json_array_append_new(rows, row_of(work, &work->run[k]));
    }
    json_array_append_new(cases, json_pack("{s:s, s:s, s:s, s:f, s:o, s:o}", "scene", work->at->name, "file",
                                           work->at->file, "curve", work->at->curve, "contact_time_s",
                                           contact_time_s(work->at), "windows", windows, "rows", rows));
}

static enum status run_all(struct work *work, json_t *cases)
{
    for (int k = 0; k < work->n; k++) {
        fprintf(stderr, "scene %s: run %d of %d\n", work->at->name, k + 1, work->n);
        TRY(run_one(work, &work->run[k]));
    }
    if (!work->run[work->reference].ran || !work->run[work->usual].ran)
        return status_fail(STATUS_UNSTABLE, "scene %s: the reference became unstable", work->at->name);
    for (int k = 0; k < work->n; k++)
        TRY(compare(work, &work->run[k]));
    find_orders(work);
    report(work, cases);
    return STATUS_OK;
}

static enum status run_case(const struct accuracy_case *at, const char *sim, const struct options *options,
                            json_t *cases)
{
    char path[1024];
    struct work *work = calloc(1, sizeof *work);
    struct scene *scene = calloc(1, sizeof *scene);
    enum status status = work && scene ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "out of memory");
    if (status == STATUS_OK) {
        work->at = at;
        work->sim = sim;
        work->options = options;
        snprintf(path, sizeof path, "%s/%s", options->scenes, at->file);
        snprintf(work->folder, sizeof work->folder, "%s/%.*s", options->out, (int)strcspn(at->file, "."), at->file);
        status = make_scene(work, scene, path);
    }
    if (status == STATUS_OK) {
        plan(work, options->quick && at->quick_dt[0] > 0);
        status = run_all(work, cases);
    }
    for (int k = 0; work && k < work->n; k++)
        curve_free(&work->run[k].curve);
    if (scene)
        scene_free(scene);
    free(scene);
    free(work);
    return status;
}

static enum status run_cases(const struct options *options, json_t *root)
{
    char sim[1024];
    json_t *cases = json_array();
    bool any = false;
    json_object_set_new(root, "cases", cases);
    TRY(folder_make(options->out));
    snprintf(sim, sizeof sim, "%s/sim/sim", options->bin);
    for (size_t k = 0; k < sizeof CASES / sizeof *CASES; k++) {
        bool wanted =
            options->only ? strcmp(options->only, CASES[k].name) == 0 : !options->quick || CASES[k].quick_dt[0] > 0;
        if (wanted)
            TRY(run_case(&CASES[k], sim, options, cases));
        any = any || wanted;
    }
    return any ? STATUS_OK : status_fail(STATUS_USAGE, "there is no scene %s", options->only);
}

static enum status bench(const struct options *options)
{
    if (!options->bin || !options->scenes || !options->out)
        return status_fail(STATUS_USAGE, "start it with ./shakedown bench accuracy");
    json_error_t error;
    json_t *root = options->from ? json_load_file(options->from, 0, &error) : json_object();
    if (!root)
        return status_fail(STATUS_IO, "%s: %s", options->from, error.text);
    enum status status = options->from ? STATUS_OK : run_cases(options, root);
    if (status == STATUS_OK && options->json_path && json_dump_file(root, options->json_path, JSON_INDENT(1)) != 0)
        status = status_fail(STATUS_IO, "%s: cannot be written", options->json_path);
    if (status == STATUS_OK && options->plot)
        status = accuracy_plot(root, options->out, options->plot);
    json_decref(root);
    return status;
}

int main(int argc, char **argv)
{
    struct options options = {0};
    const struct command_line_option own[] = {{"bin", &options.bin, NULL},     {"scenes", &options.scenes, NULL},
                                              {"out", &options.out, NULL},     {"scene", &options.only, NULL},
                                              {"quick", NULL, &options.quick}, {"json", &options.json_path, NULL},
                                              {"plot", &options.plot, NULL},   {"through", &options.through, NULL},
                                              {"from", &options.from, NULL},   {NULL, NULL, NULL}};
    struct command_line line;
    options.line = &line;
    setvbuf(stdout, NULL, _IOLBF, 0);
    floating_point_flush_subnormals();
    enum status status = command_line_parse(&line, argc, argv, own);
    if (status == STATUS_OK)
        status = bench(&options);
    return status_report("bench_accuracy", status);
}
