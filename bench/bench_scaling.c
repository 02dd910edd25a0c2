/* bench_scaling [--dimension 2|3] [--precision double|mixed] [--counts N,N,...] [--threads T,T,...] [--ordered]
 * [--busy] [--bandwidth GB/s] [--cache MB] [--json FILE]: cost of a particle-step against the number of particles,
 * dense packings with the radii and materials of scenes A (2D) and B (3D). A packing is a jittered lattice at the solid
 * fraction that gives the scene's number of contacts, relaxed for a few hundred steps under strong damping. The skin is
 * about what scenes A and B choose when they are tested, for all sizes, so that a particle has as many candidates:
 * tuned, it would be wider the faster the fastest of all particles is. Particles get their places at random, as after
 * long mixing;
 * --ordered keeps them in rows. Times are the least of several blocks; beside them stands what the core could do, the
 * less of before and after (timing.h). Below the rows of a sample, for each number of threads: how many times as fast
 * as with the first of them, one thread, a step, its parts and a build of the lists are, how much of that number is
 * reached, and which part of the time would have to be serial to explain it (Amdahl). And a model of a step on more
 * cores (scaling_model.h) that can move --bandwidth GB/s together, where their caches, --cache MB each, do not hold the
 * sample. All threads are at work while steps and parts are timed.
 * --busy: instead, steps beside a program that keeps a core busy (scaling_busy.h).
 */
#include <inttypes.h>
#include <jansson.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/lattice_sample.h"
#include "bench/scaling_busy.h"
#include "bench/scaling_model.h"
#include "bench/timing.h"
#include "common/bus.h"
#include "common/command_line.h"
#include "common/floating_point.h"
#include "common/scene_file.h"
#include "sim/measure/measure.h"
#include "sim/run/sample_source.h"
#include "sim/sample/sample.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"

enum { BLOCKS = 8, RELAX_STEPS = 300, LIST_MAX = 32 };
static const double BLOCK_S = 0.12;

static const char *const precisions[] = {"double", "mixed"};

struct row {
    const char *precision;
    int count, contacts, candidates, threads;
    double memory_mb;           /* that the process had at most while it packed the sample and went through steps */
    double data_mb;             /* that a step needs */
    double bytes_mb, stream_us; /* that a step moves, and as long as it takes to move as many in order */
    struct timing_core before, after;
    double setup_s, step_us, pair_us, walls_us, drift_us, kick_us, build_us;
    double *block_us;          /* least time of each block, with one thread; NULL: not cut into blocks */
    int n_blocks, n_pieces[3]; /* of the walls of each axis, which are done at the same time */
    double in_step_us;         /* of the walls in such steps: longer than again and again, when caches have them */
    double rest_us;            /* of a step outside of blocks and walls */
    double job_us;             /* a job without pieces that take any time */
    double builds_per_step;    /* of the lists, while steps were timed: how fast the particles of this sample move */
};

/* The parts, each as often as wanted at one state: no time passes (dt = 0). */
static enum status one_pair(struct sample *sample)
{
    struct contact_losses losses = {0};
    threads_pair(&sample->threads, &sample->kernels, &sample->particles, &sample->pairs, &sample->law, 0, &losses);
    return STATUS_OK;
}

static enum status one_walls(struct sample *sample)
{
    struct contact_losses losses = {0};
    threads_walls(&sample->threads, &sample->kernels, &sample->particles, sample->walls, sample->n_walls, &sample->law,
                  0, &losses);
    return STATUS_OK;
}

static enum status one_drift(struct sample *sample)
{
    (void)threads_drift(&sample->threads, &sample->kernels, &sample->particles, 0, 0, INFINITY);
    return STATUS_OK;
}

static enum status one_kick(struct sample *sample)
{
    struct kick_constants constants = {0};
    (void)threads_kick(&sample->threads, &sample->kernels, &sample->particles, &constants);
    return STATUS_OK;
}

static enum status one_build(struct sample *sample)
{
    return sample_build_lists(sample);
}

/* Microseconds of one call: the least of the blocks. */
static enum status time_it(struct sample *sample, enum status (*part)(struct sample *), double *least_us)
{
    *least_us = INFINITY;
    for (int b = 0; b < BLOCKS; b++) {
        int done = 0;
        double start = clock_now_s(), now = start;
        for (; now - start < BLOCK_S; now = clock_now_s(), done++)
            TRY(part(sample));
        *least_us = fmin(*least_us, 1e6 * (now - start) / done);
    }
    return STATUS_OK;
}

/* Microseconds of a step, the least of the blocks, of the steps that built no lists: how often they do depends on how
 * fast the particles move, and a block of a large sample would have a build or none. */
static enum status time_steps(struct sample *sample, struct row *row)
{
    const int64_t before = sample->verlet.rebuilds;
    int64_t all = 0;
    row->step_us = INFINITY;
    TRY(sample_step_open(sample)); /* each step completes the one before */
    for (int b = 0; b < BLOCKS; b++) {
        int done = 0;
        double spent = 0, start = clock_now_s(), now = start;
        for (; now - start < BLOCK_S || done == 0; all++) {
            const int64_t builds = sample->verlet.rebuilds;
            const double then = now;
            TRY(sample_step_open(sample));
            now = clock_now_s();
            if (sample->verlet.rebuilds == builds) {
                spent += now - then;
                done++;
            }
        }
        row->step_us = fmin(row->step_us, 1e6 * spent / done);
    }
    row->builds_per_step = (double)(sample->verlet.rebuilds - before) / (double)all;
    return STATUS_OK;
}

/* As many threads as asked for in every step, without trials of fewer (thread_choice.h). */
static void hold_threads(struct sample *sample, int threads)
{
    sample->threads.choice = (struct thread_choice){.most = 1, .best = threads, .use = threads};
    if (sample->threads.team)
        thread_team_use(sample->threads.team, threads);
}

static enum status time_parts(struct sample *sample, struct row *row)
{
    hold_threads(sample, row->threads);
    TRY(time_steps(sample, row));
    (void)sample_complete(sample);
    TRY(time_it(sample, one_pair, &row->pair_us));
    TRY(time_it(sample, one_walls, &row->walls_us));
    TRY(time_it(sample, one_drift, &row->drift_us));
    TRY(time_it(sample, one_kick, &row->kick_us));
    TRY(time_it(sample, one_build, &row->build_us));
    row->stream_us = 1e3 * row->bytes_mb / timing_stream_gb_per_s(1e6 * row->bytes_mb / 2, sample->threads.team);
    return STATUS_OK;
}

/* Bytes of a step, walls left aside. Moved are, if what the parts hand over does not stay in a cache: pairs read row,
 * reach (mixed: and where it was built) and history of each slot, records and columns, and add to the sums; advance
 * reads the sums and zeroes their rows, reads constants, reads and writes what steps go on with (double: x, v,
 * rotations and their views, beside x_list; mixed: the views and a rest of each) and writes the records. */
static void count_bytes(const struct sample *sample, struct row *row)
{
    const struct particles *p = &sample->particles;
    const int d = p->dimension, s = p->n_rotations, real = p->mixed ? 4 : 8;
    const int record = 8 * RECORD_STRIDE(d, s > 0, p->mixed), rows = SUMS_BYTES(d, s > 0, p->mixed);
    int history = 0;
    for (int c = 0; c < HISTORY_COLUMNS; c++)
        history += history_has(&sample->pairs.model, c) ? real : 0;
    const int constant = 4 + real + (p->mixed ? (d + 1) * real : 0);
    const int positions = d * real, velocities = (d + s) * real, radius = s ? real : 0;
    const int lags = s ? LAG_COLUMNS(d, p->mixed) * real : 0;
    const int pair =
        record + positions + velocities + lags + radius + 2 * (rows + velocities); /* columns are velocities' size */
    const int state = p->mixed ? 4 * (positions + velocities) : 8 * (2 * (d + d + s) + d) + 2 * velocities;
    const int factors = (s ? 3 : 1) * real, advance = 2 * rows + velocities + lags + state + factors + record;
    const int own = p->mixed ? 2 * (positions + velocities) : 8 * (d + d + s + d) + velocities;
    const double slots = (double)SET_WIDTH * sample->pairs.n_sets;
    row->bytes_mb = 1e-6 * ((constant + 2 * history) * slots + (double)(pair + advance) * p->count);
    row->data_mb = 1e-6 * ((constant + history) * slots +
                           (double)(record + rows + velocities + lags + own + factors + radius) * p->count);
}

/* What each core has of caches [MB]: as told, or its own second one alone; 0: the system does not say. */
static double cache_mb(const char *told)
{
    return told ? strtod(told, NULL) : 1e-6 * fmax((double)sysconf(_SC_LEVEL2_CACHE_SIZE), 0);
}

static const double PIECE_S = 5e-6;

static void spin(void *context, int piece)
{
    (void)context;
    (void)piece;
    for (const double start = clock_now_s(); clock_now_s() - start < PIECE_S;)
        ;
}

/* With more than one thread: what it takes to hand out a job with a piece for each of them, and to see its end. */
static void time_jobs(struct sample *sample, struct row *row)
{
    enum { JOBS = 2000 };
    if (!sample->threads.team || row->threads < 2)
        return;
    thread_team_use(sample->threads.team, row->threads);
    row->job_us = INFINITY;
    for (int k = 0; k < JOBS; k++) {
        const double start = clock_now_s();
        thread_team_run(sample->threads.team, row->threads, spin, NULL);
        row->job_us = fmin(row->job_us, 1e6 * (clock_now_s() - start - PIECE_S));
    }
}

/* With one thread: the least time of each block, and of all walls, in steps that do not build the lists. */
static enum status time_blocks(struct sample *sample, struct row *row)
{
    enum { STEPS = 40 };
    struct threads *threads = &sample->threads;
    const int n = threads->n_parts > 1 ? threads->halo.n_blocks : 1;
    if (n == 1 || row->threads != 1)
        return STATUS_OK;
    row->block_us = malloc((size_t)n * sizeof *row->block_us);
    threads->block_s = calloc((size_t)n, sizeof *threads->block_s);
    if (!row->block_us || !threads->block_s)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    row->n_blocks = n;
    for (int w = 0; w < sample->n_walls; w++)
        row->n_pieces[w / 2] += (sample->walls[w].contacts.n_sets + THREADS_PIECE_SETS - 1) / THREADS_PIECE_SETS;
    for (int b = 0; b < n; b++)
        row->block_us[b] = INFINITY;
    row->rest_us = row->in_step_us = INFINITY;
    for (int k = 0; k < STEPS; k++) {
        const double start = clock_now_s();
        TRY(sample_step_open(sample));
        double rest_us = 1e6 * (clock_now_s() - start - threads->walls_s);
        row->in_step_us = fmin(row->in_step_us, 1e6 * threads->walls_s);
        for (int b = 0; k > 0 && b < n; b++) {
            row->block_us[b] = fmin(row->block_us[b], 1e6 * threads->block_s[b]);
            rest_us -= 1e6 * threads->block_s[b];
        }
        row->rest_us = fmin(row->rest_us, rest_us);
    }
    free(threads->block_s);
    threads->block_s = NULL;
    return STATUS_OK;
}

/* What the process had in memory at most since it was last forgotten [MB]; 0: the system does not say. */
static double peak_mb(void)
{
    char line[128];
    double kb = 0;
    FILE *file = fopen("/proc/self/status", "r");
    while (file && fgets(line, sizeof line, file))
        if (sscanf(line, "VmHWM: %lf kB", &kb) == 1)
            break;
    if (file)
        fclose(file);
    return 1.024e-3 * kb;
}

/* Earlier samples of this process are gone. */
static void forget_peak(void)
{
    FILE *file = fopen("/proc/self/clear_refs", "w");
    if (!file)
        return;
    (void)fputs("5", file); /* where that is not allowed, the peak is that of the largest sample so far */
    (void)fclose(file);
}

static enum status measure_world(struct sample *sample, const struct lattice_kind *kind, bool ordered, struct row *row)
{
    double start = clock_now_s();
    TRY(lattice_pack(sample, kind, ordered));
    TRY(lattice_begin(sample, 0));
    row->setup_s = clock_now_s() - start;
    TRY(lattice_steps(sample, RELAX_STEPS));
    TRY(lattice_begin(sample, 1));
    TRY(lattice_steps(sample, 20));
    row->contacts = measure_contacts(sample_complete(sample), NULL);
    row->candidates = sample->pairs.count;
    row->memory_mb = peak_mb();
    count_bytes(sample, row);
    row->before = timing_core();
    TRY(time_parts(sample, row));
    TRY(time_blocks(sample, row));
    time_jobs(sample, row);
    row->after = timing_core();
    return STATUS_OK;
}

static enum status measure_row(const struct lattice_kind *kind, int count, bool ordered, struct row *row)
{
    struct sample *sample = NULL;
    struct scene *scene = calloc(1, sizeof *scene);
    if (!scene)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    double start = clock_now_s();
    forget_peak();
    enum status status = lattice_scene(scene, kind, row->threads, row->precision, count);
    if (status == STATUS_OK)
        status = sample_from_scene(&sample, scene);
    double created_s = clock_now_s() - start;
    if (status == STATUS_OK)
        status = measure_world(sample, kind, ordered, row);
    row->setup_s += created_s;
    sample_free(sample);
    scene_free(scene);
    free(scene);
    return status;
}

static json_t *report_row(const struct lattice_kind *kind, const struct row *row)
{
    double n = row->count, parts = row->pair_us + row->walls_us + row->drift_us + row->kick_us;
    printf(
        "%dD %8d %2d %6s %6.2f %6.2f %7.2f %11.1f %9.2f %6.0f %7.1f  %3.0f %3.0f %3.0f %3.0f %10.1f %8.1f %8.4f %5.2f "
        "%4.1f %6.0f\n",
        kind->dimension, row->count, row->threads, row->precision, row->contacts / n, row->candidates / n, row->setup_s,
        row->step_us, 1e3 * row->step_us / n, 1e6 * row->bytes_mb / n, 1e3 * row->stream_us / n,
        100 * row->pair_us / parts, 100 * row->walls_us / parts, 100 * row->drift_us / parts,
        100 * row->kick_us / parts, 1e3 * row->build_us / n, row->build_us / row->step_us, row->builds_per_step,
        fmin(row->before.ghz, row->after.ghz), fmin(row->before.additions_per_ns, row->after.additions_per_ns),
        row->memory_mb);
    fflush(stdout);
    return json_pack("{s:i, s:s, s:f, s:f, s:i, s:i, s:i, s:i, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:o}",
                     "dimension", kind->dimension, "precision", row->precision, "bytes_mb", row->bytes_mb, "stream_us",
                     row->stream_us, "particles", row->count, "threads", row->threads, "contacts", row->contacts,
                     "candidates", row->candidates, "setup_s", row->setup_s, "step_us", row->step_us, "pair_us",
                     row->pair_us, "walls_us", row->walls_us, "drift_us", row->drift_us, "kick_us", row->kick_us,
                     "build_us", row->build_us, "builds_per_step", row->builds_per_step, "memory_mb", row->memory_mb,
                     "core", timing_core_json(&row->before, &row->after));
}

/* "1.90 (95 %, 5 %)": times as fast, of what P threads could be, and serial part. */
static void report_gain(const char *what, double one_us, double many_us, int threads)
{
    const double gain = one_us / many_us, serial = (threads / gain - 1) / (threads - 1);
    printf(" %s %.2f (%.0f %%, %.1f %%)", what, gain, 100 * gain / threads, 100 * serial);
}

static void report_gains(const struct row *one, const struct row *row)
{
    if (one->threads != 1 || row->threads < 2)
        return;
    printf("%8d, %d threads for 1, times as fast (of %d, serial):", row->count, row->threads, row->threads);
    report_gain("step", one->step_us, row->step_us, row->threads);
    report_gain("pairs", one->pair_us, row->pair_us, row->threads);
    report_gain("walls", one->walls_us, row->walls_us, row->threads);
    report_gain("drift", one->drift_us, row->drift_us, row->threads);
    report_gain("kick", one->kick_us, row->kick_us, row->threads);
    report_gain("build", one->build_us, row->build_us, row->threads);
    report_gain("stream", one->stream_us, row->stream_us, row->threads);
    printf("\n");
}

/* The model's step on P cores; `two`: with the threads whose jobs were timed. */
static void report_model(const struct lattice_kind *kind, const struct row *one, const struct row *two,
                         double bandwidth, double cache)
{
    const int jobs = 2 + kind->dimension, most = 64; /* blocks, what was left to others, and walls */
    double blocks_us = 0;
    if (!one->block_us || two->threads < 2)
        return;
    for (int b = 0; b < one->n_blocks; b++)
        blocks_us += one->block_us[b];
    const double serial_us = fmax(one->rest_us, 0);
    const struct scaling_model model = {.n_blocks = one->n_blocks,
                                        .block_us = one->block_us,
                                        .walls_us = one->in_step_us,
                                        .n_axes = kind->dimension,
                                        .n_pieces = one->n_pieces,
                                        .n_jobs = jobs,
                                        .serial_us = serial_us,
                                        .job_us = two->job_us,
                                        .bytes_mb = one->bytes_mb,
                                        .bandwidth_gb_per_s = bandwidth,
                                        .data_mb = one->data_mb,
                                        .cache_mb = cache};
    printf("%8d, model, %d blocks, %.0f us + %.0f us walls + %.0f us serial, %.1f us a job, %.0f GB/s, %.1f of %.1f MB "
           "cached a core:",
           one->count, one->n_blocks, blocks_us, one->in_step_us, serial_us, two->job_us, bandwidth, cache,
           one->data_mb);
    for (int threads = 2; threads <= most; threads *= 2)
        printf(" %d: %.2f", threads, scaling_model_step_us(&model, 1) / scaling_model_step_us(&model, threads));
    printf("; measured %d: %.2f\n", two->threads, one->step_us / two->step_us);
}

/* "a,b,..." into list; returns how many. */
static int parse_list(const char *text, int *list)
{
    int n = 0;
    for (char *end; *text && n < LIST_MAX; text = *end ? end + 1 : end) {
        list[n++] = (int)strtod(text, &end);
        if (end == text)
            return 0;
    }
    return n;
}

struct options {
    const char *dimension, *precision, *counts, *threads, *json, *bandwidth, *cache;
    bool ordered, busy;
};

/* Whether an option that is not given, or the one value that it has, lets this through. */
static bool wanted(const char *option, const char *value)
{
    return !option || strcmp(option, value) == 0;
}

/* Beside a busy program: as many threads, and one, in turns. */
static enum status report_busy(const struct lattice_kind *kind, const char *precision, int count, int threads)
{
    struct scaling_busy busy = {.kind = kind, .precision = precision, .count = count, .threads = threads};
    if (threads < 2)
        return STATUS_OK;
    TRY(scaling_busy_measure(&busy));
    printf(
        "%8d, %d threads beside a busy program: %.1f us per step, one thread %.1f: %.2f times, worst of %d turns of %d "
        "steps %.2f; without it %.2f\n",
        count, threads, busy.many_us, busy.one_us, busy.many_us / busy.one_us, busy.turns, busy.steps, busy.worst,
        busy.undisturbed);
    fflush(stdout);
    return STATUS_OK;
}

/* The numbers of threads for one sample. */
static enum status bench_count(const struct lattice_kind *kind, const char *precision, int count, const int *threads,
                               int n_threads, const struct options *options, json_t *rows)
{
    struct row row[LIST_MAX] = {{0}};
    enum status status = STATUS_OK;
    int n = 0;
    for (int k = 0; options->busy && k < n_threads; k++)
        TRY(report_busy(kind, precision, count, threads[k]));
    for (; n < n_threads && status == STATUS_OK && !options->busy; n++) {
        row[n] = (struct row){.precision = precision, .count = count, .threads = threads[n]};
        status = measure_row(kind, count, options->ordered, &row[n]);
        if (status == STATUS_OK)
            json_array_append_new(rows, report_row(kind, &row[n]));
    }
    for (int k = 1; k < n && status == STATUS_OK; k++)
        report_gains(&row[0], &row[k]);
    if (n > 1 && status == STATUS_OK)
        report_model(kind, &row[0], &row[1], strtod(options->bandwidth, NULL), cache_mb(options->cache));
    for (int k = 0; k < n; k++)
        free(row[k].block_us);
    return status;
}

/* Counts and threads of one dimension and precision. */
static enum status bench_kind(const struct lattice_kind *kind, const char *precision, const struct options *options,
                              json_t *rows)
{
    int count[LIST_MAX], threads[LIST_MAX];
    const int n_counts = parse_list(options->counts, count), n_threads = parse_list(options->threads, threads);
    if (n_counts == 0 || n_threads == 0)
        return status_fail(STATUS_USAGE,
                           "usage: bench_scaling [--dimension 2|3] [--precision double|mixed] [--counts N,N,...] "
                           "[--threads T,...] [--ordered] [--busy] [--bandwidth GB/s] [--cache MB] [--json FILE]");
    for (int n = 0; n < n_counts; n++)
        TRY(bench_count(kind, precision, count[n], threads, n_threads, options, rows));
    return STATUS_OK;
}

static enum status bench_scaling(const struct options *options, json_t *rows)
{
    printf("          N  T         contacts candid.  setup  us per step  ns per N bytes/N  stream  %% pair walls drift "
           "kick  build ns/N  in steps per step   GHz add/ns     MB\n");
    for (int dimension = 2; dimension <= 3; dimension++)
        for (size_t m = 0; m < sizeof precisions / sizeof *precisions; m++)
            if (wanted(options->dimension, dimension == 2 ? "2" : "3") && wanted(options->precision, precisions[m]))
                TRY(bench_kind(lattice_kind_of(dimension), precisions[m], options, rows));
    return STATUS_OK;
}

int main(int argc, char **argv)
{
    struct options options = {.counts = "1e3,3375,1e4,2e4,1e5,3e5,1e6", .threads = "1,2", .bandwidth = "200"};
    const struct command_line_option own[] = {{"dimension", &options.dimension, NULL},
                                              {"precision", &options.precision, NULL},
                                              {"counts", &options.counts, NULL},
                                              {"threads", &options.threads, NULL},
                                              {"bandwidth", &options.bandwidth, NULL},
                                              {"json", &options.json, NULL},
                                              {"ordered", NULL, &options.ordered},
                                              {"busy", NULL, &options.busy},
                                              {NULL, NULL, NULL}};
    struct command_line line;
    floating_point_flush_subnormals();
    json_t *rows = json_array();
    enum status status = command_line_parse(&line, argc, argv, own);
    if (status == STATUS_OK)
        status = bench_scaling(&options, rows);
    json_t *all = json_pack("{s:o}", "rows", rows);
    if (status == STATUS_OK && options.json && json_dump_file(all, options.json, JSON_INDENT(1)) != 0)
        status = status_fail(STATUS_IO, "%s: cannot be written", options.json);
    json_decref(all);
    return status_report("bench_scaling", status);
}
