/* Time per step: every contestant in turn, again and again. Peers first try several settings of their neighbour lists
 * and keep the fastest. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/child.h"
#include "bench/peers_bench.h"
#include "bench/peers_output.h"
#include "bench/prepared_sample.h"
#include "sim/kernels/kernels.h"
#include "sim/run/sample_source.h"

enum { CONTESTANTS_MAX = 12, TUNE_STEPS = 500, TUNE_STEPS_MANY = 150, WARM_UP = 50 };

/* Skin over the mean radius, and steps without a look at the lists. */
static const double SKINS[] = {0.05, 0.15, 0.4};
static const int DELAYS[] = {0, 20};

struct contestant {
    const char *name, *note;
    const char *isa; /* ours; NULL: a peer */
    int precision;   /* ours */
    bool linear;     /* ours with a linear law instead of Hertz' */
    enum peer peer;
    enum peer_law law;
    const char *tangential; /* LAMMPS, Hertz */
    bool walls_move;
    double skin_ratio; /* found by trying */
    int delay;
    double us[PEERS_REPS_MAX], least, median;
};

static const struct contestant FRICTIONLESS[] = {
    {.name = "shakedown, AVX-512", .note = "hysteretic, cohesive, walls move", .isa = "avx512"},
    {.name = "shakedown, AVX2", .note = "hysteretic, cohesive, walls move", .isa = "avx2"},
    {.name = "shakedown, AVX-512, mixed",
     .note = "hysteretic, cohesive, walls move",
     .isa = "avx512",
     .precision = PRECISION_MIXED},
    {.name = "shakedown, AVX2, mixed",
     .note = "hysteretic, cohesive, walls move",
     .isa = "avx2",
     .precision = PRECISION_MIXED},
    {.name = "LAMMPS gran/hooke", .note = "linear, fixed walls", .peer = PEER_LAMMPS, .law = PEER_HOOKE},
    {.name = "LAMMPS granular", .note = "linear, fixed walls", .peer = PEER_LAMMPS, .law = PEER_GRANULAR},
    {.name = "LIGGGHTS hooke/stiffness", .note = "linear, fixed walls", .peer = PEER_LIGGGHTS, .law = PEER_STIFFNESS},
    {.name = "LIGGGHTS luding", .note = "hysteretic, fixed walls", .peer = PEER_LIGGGHTS, .law = PEER_LUDING},
};

static const struct contestant FRICTIONAL[] = {
    {.name = "shakedown, AVX-512", .note = "friction, walls move", .isa = "avx512"},
    {.name = "shakedown, AVX2", .note = "friction, walls move", .isa = "avx2"},
    {.name = "shakedown, AVX-512, mixed",
     .note = "friction, walls move",
     .isa = "avx512",
     .precision = PRECISION_MIXED},
    {.name = "shakedown, AVX2, mixed", .note = "friction, walls move", .isa = "avx2", .precision = PRECISION_MIXED},
    {.name = "LAMMPS gran/hooke/history", .note = "friction, fixed walls", .peer = PEER_LAMMPS, .law = PEER_HOOKE},
    {.name = "LAMMPS gran/hooke/history",
     .note = "friction, walls move",
     .peer = PEER_LAMMPS,
     .law = PEER_HOOKE,
     .walls_move = true},
    {.name = "LAMMPS granular", .note = "friction, fixed walls", .peer = PEER_LAMMPS, .law = PEER_GRANULAR},
    {.name = "LIGGGHTS hooke/stiffness", .note = "friction, fixed walls", .peer = PEER_LIGGGHTS, .law = PEER_STIFFNESS},
};

static const struct contestant HERTZIAN[] = {
    {.name = "shakedown, AVX-512", .note = "Hertz-Mindlin, walls move", .isa = "avx512"},
    {.name = "shakedown, AVX2", .note = "Hertz-Mindlin, walls move", .isa = "avx2"},
    {.name = "shakedown, AVX-512, mixed",
     .note = "Hertz-Mindlin, walls move",
     .isa = "avx512",
     .precision = PRECISION_MIXED},
    {.name = "shakedown, AVX2, mixed",
     .note = "Hertz-Mindlin, walls move",
     .isa = "avx2",
     .precision = PRECISION_MIXED},
    {.name = "shakedown, AVX-512", .note = "linear, friction, walls move", .isa = "avx512", .linear = true},
    {.name = "shakedown, AVX2", .note = "linear, friction, walls move", .isa = "avx2", .linear = true},
    {.name = "shakedown, AVX-512, mixed",
     .note = "linear, friction, walls move",
     .isa = "avx512",
     .precision = PRECISION_MIXED,
     .linear = true},
    {.name = "shakedown, AVX2, mixed",
     .note = "linear, friction, walls move",
     .isa = "avx2",
     .precision = PRECISION_MIXED,
     .linear = true},
    {.name = "LAMMPS granular",
     .note = "mindlin_rescale, fixed walls",
     .peer = PEER_LAMMPS,
     .law = PEER_HERTZ,
     .tangential = "mindlin_rescale"},
    {.name = "LAMMPS granular",
     .note = "mindlin_rescale/force, fixed walls",
     .peer = PEER_LAMMPS,
     .law = PEER_HERTZ,
     .tangential = "mindlin_rescale/force"},
    {.name = "LIGGGHTS hertz", .note = "history, fixed walls", .peer = PEER_LIGGGHTS, .law = PEER_HERTZ},
};

/* Of many particles on several threads or ranks: walls stay for all. */
#define OURS_THREADED(note_)                                                                                           \
    {.name = "shakedown, AVX-512", .note = note_, .isa = "avx512"},                                                    \
        {.name = "shakedown, AVX2", .note = note_, .isa = "avx2"},                                                     \
        {.name = "shakedown, AVX-512, mixed", .note = note_, .isa = "avx512", .precision = PRECISION_MIXED},           \
    {                                                                                                                  \
        .name = "shakedown, AVX2, mixed", .note = note_, .isa = "avx2", .precision = PRECISION_MIXED                   \
    }

static const struct contestant DISCS[] = {
    OURS_THREADED("hysteretic, cohesive, fixed walls"),
    {.name = "LAMMPS gran/hooke", .note = "linear, fixed walls", .peer = PEER_LAMMPS, .law = PEER_HOOKE},
};

static const struct contestant SPHERES[] = {
    OURS_THREADED("friction, fixed walls"),
    {.name = "LAMMPS gran/hooke/history", .note = "friction, fixed walls", .peer = PEER_LAMMPS, .law = PEER_HOOKE},
};

struct timing {
    const struct peers_work *work;
    struct scene *peers_scene; /* the last stage from the settled sample */
    struct sample *sample;     /* and its sample */
    char scene_path[2][1100];  /* of ours; with the linear law */
    struct contestant contestant[CONTESTANTS_MAX];
    int n;
};

static enum status read_time(const char *folder, const char *name, int processes, double *us)
{
    char path[1100], *text;
    snprintf(path, sizeof path, "%s/%s.log", folder, name);
    TRY(file_read(path, &text));
    enum status status = peers_read_loop(text, processes, us);
    free(text);
    return status;
}

/* The program itself, as users run it in process; no records, as the peers write none. */
static enum status time_ours(const struct timing *timing, const struct contestant *c, double *us)
{
    char log[1100], threads[32];
    snprintf(log, sizeof log, "%s/ours.log", timing->work->folder);
    snprintf(threads, sizeof threads, "threads=%d", timing->work->threads);
    const char *const argv[] = {timing->work->sim,
                                timing->scene_path[c->linear],
                                "--in-process",
                                "--progress",
                                "--set",
                                c->precision == PRECISION_MIXED ? "precision=\"mixed\"" : "precision=\"double\"",
                                "--set",
                                threads,
                                NULL};
    struct child child = {.argv = argv, .log = log, .variable = "SHAKEDOWN_ISA", .value = c->isa};
    TRY(child_run(&child));
    return read_time(timing->work->folder, "ours", 1, us);
}

static enum status time_peer(const struct timing *timing, const struct contestant *c, long steps, double *us)
{
    struct peer_input input = peers_input_of(timing->peers_scene, timing->sample);
    input.peer = c->peer;
    input.law = c->law;
    input.walls_move = c->walls_move;
    if (c->tangential)
        input.tangential = c->tangential;
    input.skin_m = c->skin_ratio * peers_mean_radius(timing->sample);
    input.delay = c->delay;
    input.warm_up = WARM_UP;
    input.steps = steps;
    input.processes = timing->work->threads;
    if (c->law == PEER_LUDING)
        input.restitution = 0.9;
    TRY(peers_run(&input, timing->sample, timing->work->folder, "timing"));
    return read_time(timing->work->folder, "timing", timing->work->threads, us);
}

static enum status tune(const struct timing *timing, struct contestant *c)
{
    struct contestant best = *c;
    double least = INFINITY;
    for (size_t s = 0; s < sizeof SKINS / sizeof *SKINS; s++)
        for (size_t d = 0; d < sizeof DELAYS / sizeof *DELAYS; d++) {
            double us;
            c->skin_ratio = SKINS[s];
            c->delay = DELAYS[d];
            TRY(time_peer(timing, c, timing->work->threads > 1 ? TUNE_STEPS_MANY : TUNE_STEPS, &us));
            if (us >= least)
                continue;
            least = us;
            best = *c;
        }
    *c = best;
    return STATUS_OK;
}

static bool isa_is_supported(const char *name)
{
    for (int isa = 0; isa < ISA_COUNT; isa++)
        if (strcmp(instruction_set_name(isa), name) == 0)
            return instruction_set_supported(isa);
    return false;
}

static bool is_hertz(const struct peers_work *work)
{
    return work->last->stage[0].material.law == LAW_HERTZ;
}

/* All that may take part; returns how many. */
static int list_contestants(const struct peers_work *work, const struct contestant **from)
{
    const bool frictional = scene_is_frictional(work->last);
#define LIST(list) (*from = (list), (int)(sizeof(list) / sizeof *(list)))
    if (work->threads > 1)
        return frictional ? LIST(SPHERES) : LIST(DISCS);
    return is_hertz(work) ? LIST(HERTZIAN) : frictional ? LIST(FRICTIONAL) : LIST(FRICTIONLESS);
#undef LIST
}

static void choose_contestants(struct timing *timing)
{
    const struct contestant *from;
    const int n = list_contestants(timing->work, &from);
    for (int k = 0; k < n; k++) {
        if (!from[k].isa || isa_is_supported(from[k].isa))
            timing->contestant[timing->n++] = from[k];
        else
            printf("  SKIPPED: %s: this CPU cannot run it\n", from[k].name);
    }
}

/* A linear law in place of Hertz': the mean contact keeps its force, and with it the sample its pressure; the rest as
 * in Hertz-Mindlin at that contact, whose stiffness is 3/2 of force over overlap. */
static enum status make_linear(struct timing *timing, struct scene_material *m)
{
    struct peers_scale scale;
    const double nu = m->poisson_ratio, ratio = 2 * (1 - nu) / (2 - nu), log_e = log(m->restitution);
    const double pi = acos(-1.0), beta = -log_e / sqrt(pi * pi + log_e * log_e);
    TRY(peers_start_stage(timing->sample));
    TRY(peers_measure_scale(timing->sample, &scale));
    m->law = LAW_LINEAR;
    m->kn_n_per_m = scale.force_n / scale.overlap_m;
    m->kt_n_per_m = 1.5 * m->kn_n_per_m * ratio;
    m->gamma_n_kg_per_s = 2 * sqrt(5.0 / 6) * beta * sqrt(1.5 * m->kn_n_per_m * 0.5 * scale.mass_kg);
    m->gamma_t_kg_per_s = m->gamma_n_kg_per_s * sqrt(ratio);
    m->youngs_modulus_pa = m->poisson_ratio = 0;
    m->restitution = 1;
    return STATUS_OK;
}

/* Our scene: as many steps as are timed, no samples between; a hysteretic law gets cohesion, kc = k2. */
static enum status write_our_scene(struct timing *timing, bool linear)
{
    struct scene *scene = prepare_scene_copy(timing->work->last);
    if (!scene)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    struct scene_stage *stage = &scene->stage[0];
    stage->cut_path = true; /* a piece of the test */
    stage->duration_s = (double)timing->work->at->our_steps * stage->dt_s;
    stage->sample_interval_s = stage->duration_s;
    stage->frame_interval_s = 0;
    stage->frame_strains.count = 0;
    if (scene_is_hysteretic(scene))
        stage->material.kc_n_per_m = stage->material.k2_n_per_m;
    enum status status = linear ? make_linear(timing, &stage->material) : STATUS_OK;
    if (linear)
        scene->material = stage->material;
    snprintf(timing->scene_path[linear], sizeof *timing->scene_path, "%s/timing%s.cfg", timing->work->folder,
             linear ? "-linear" : "");
    if (status == STATUS_OK)
        status = prepare_scene_file(scene, timing->scene_path[linear]);
    prepare_scene_free(scene);
    return status;
}

static int rising(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median_of(const double *values, int count)
{
    double sorted[PEERS_REPS_MAX];
    memcpy(sorted, values, (size_t)count * sizeof *values);
    qsort(sorted, (size_t)count, sizeof *sorted, rising);
    return 0.5 * (sorted[(count - 1) / 2] + sorted[count / 2]);
}

/* How many times as long as ours a contestant takes: the median over the turns, each with its own neighbours in time,
 * as the machine's speed drifts. */
static double times_ours(const struct contestant *c, const struct contestant *ours, int reps)
{
    double ratio[PEERS_REPS_MAX];
    for (int r = 0; r < reps; r++)
        ratio[r] = c->us[r] / ours->us[r];
    return median_of(ratio, reps);
}

static void report_one(const struct timing *timing, const struct contestant *c, int reps, json_t *rows)
{
    json_t *times = json_array(), *ratios = json_object();
    printf("  %-26s %-33s %8.2f %8.2f", c->name, c->note, c->least, c->median);
    for (int k = 0; k < timing->n; k++) {
        const struct contestant *ours = &timing->contestant[k];
        if (!ours->isa || ours->linear)
            continue;
        printf(" %8.2f", times_ours(c, ours, reps));
        json_object_set_new(ratios, ours->name, json_real(times_ours(c, ours, reps)));
    }
    if (!c->isa)
        printf("   skin %g a, delay %d", c->skin_ratio, c->delay);
    printf("\n");
    for (int r = 0; r < reps; r++)
        json_array_append_new(times, json_real(c->us[r]));
    json_array_append_new(rows, json_pack("{s:s, s:s, s:f, s:f, s:o, s:f, s:i, s:o}", "name", c->name, "note", c->note,
                                          "least_us", c->least, "median_us", c->median, "times_ours", ratios,
                                          "skin_ratio", c->skin_ratio, "delay", c->delay, "us", times));
}

static const struct contestant *find_linear(const struct timing *timing, const struct contestant *like)
{
    for (int k = 0; k < timing->n; k++) {
        const struct contestant *c = &timing->contestant[k];
        if (c->linear && strcmp(c->isa, like->isa) == 0 && c->precision == like->precision)
            return c;
    }
    return NULL;
}

/* Median of the ratios of the turns, and half of what lies between their quartiles. */
static void report_ratio(const char *what, const struct contestant *c, const struct contestant *ours, int reps,
                         json_t *rows)
{
    double ratio[PEERS_REPS_MAX];
    for (int r = 0; r < reps; r++)
        ratio[r] = c->us[r] / ours->us[r];
    qsort(ratio, (size_t)reps, sizeof *ratio, rising);
    const double median = median_of(ratio, reps), spread = 0.5 * (ratio[3 * (reps - 1) / 4] - ratio[(reps - 1) / 4]);
    printf("  %-48s %-26s %6.3f +- %.3f\n", what, ours->name, median, spread);
    json_array_append_new(
        rows, json_pack("{s:s, s:s, s:f, s:f}", "what", what, "ours", ours->name, "ratio", median, "spread", spread));
}

/* What Hertz-Mindlin costs us more than a linear law, and others. */
static void report_hertz(const struct timing *timing, int reps, json_t *rows)
{
    printf("ratios of times, median of the turns and half the distance of their quartiles\n");
    for (int k = 0; k < timing->n; k++) {
        const struct contestant *ours = &timing->contestant[k];
        if (!ours->isa || ours->linear)
            continue;
        const struct contestant *linear = find_linear(timing, ours);
        if (linear)
            report_ratio("Hertz-Mindlin over the linear law", ours, linear, reps, rows);
        for (int p = 0; p < timing->n; p++) {
            char what[80];
            const struct contestant *peer = &timing->contestant[p];
            snprintf(what, sizeof what, "%s %s over ours", peer->name, peer->tangential ? peer->tangential : "");
            if (!peer->isa)
                report_ratio(what, peer, ours, reps, rows);
        }
    }
}

static void report_times(struct timing *timing, int reps, json_t *rows)
{
    printf("us per step, %d turns; times ours: median over the turns\n", reps);
    printf("  %-26s %-33s %8s %8s", "", "", "least", "median");
    for (int k = 0; k < timing->n; k++)
        if (timing->contestant[k].isa && !timing->contestant[k].linear)
            printf(" %6s%s", timing->contestant[k].isa, timing->contestant[k].precision ? " m" : "  ");
    printf("\n");
    for (int k = 0; k < timing->n; k++) {
        struct contestant *c = &timing->contestant[k];
        c->median = median_of(c->us, reps);
        c->least = c->us[0];
        for (int r = 1; r < reps; r++)
            c->least = fmin(c->least, c->us[r]);
        report_one(timing, c, reps, rows);
    }
}

static enum status take_turns(struct timing *timing, int reps, json_t *rows)
{
    for (int k = 0; k < timing->n; k++)
        if (!timing->contestant[k].isa)
            TRY(tune(timing, &timing->contestant[k]));
    for (int r = 0; r < reps; r++)
        for (int k = 0; k < timing->n; k++) {
            struct contestant *c = &timing->contestant[k];
            TRY(c->isa ? time_ours(timing, c, &c->us[r]) : time_peer(timing, c, timing->work->at->steps, &c->us[r]));
        }
    report_times(timing, reps, rows);
    if (is_hertz(timing->work)) {
        json_t *ratios = json_array();
        json_object_set_new(timing->work->report, "ratios", ratios);
        report_hertz(timing, reps, ratios);
    }
    return STATUS_OK;
}

/* The stage before the last once more, with the linear law of k1, to `checkpoint` [CONFIG_STRING_MAX]. */
static enum status settle(const struct peers_work *work, char *checkpoint)
{
    char path[1100], file[1100], log[1100];
    struct scene *scene = prepare_scene_copy(work->whole);
    if (!scene)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    prepare_stage(scene, (int)work->whole->n_stages - 2, work->checkpoint);
    struct scene_material *m = &scene->stage[0].material;
    m->law = LAW_LINEAR;
    m->kn_n_per_m = m->k1_n_per_m;
    m->k1_n_per_m = m->k2_n_per_m = m->kc_n_per_m = 0;
    scene->material = *m;
    snprintf(path, sizeof path, "%s/settle.cfg", work->folder);
    snprintf(file, sizeof file, "%s/settled.h5", work->folder);
    snprintf(log, sizeof log, "%s/settle.log", work->folder);
    const char *const argv[] = {work->sim, path, "--in-process", "--checkpoint", file, NULL};
    struct child child = {.argv = argv, .log = log};
    enum status status = prepare_scene_file(scene, path);
    if (status == STATUS_OK)
        status = child_run(&child);
    prepare_scene_free(scene);
    TRY(status);
    return prepare_path(file, checkpoint);
}

static enum status make_peers_world(struct timing *timing)
{
    const struct peers_work *work = timing->work;
    char checkpoint[CONFIG_STRING_MAX];
    if (scene_is_hysteretic(work->last)) {
        TRY(settle(work, checkpoint));
        prepare_stage(timing->peers_scene, 0, checkpoint);
    }
    return sample_from_scene(&timing->sample, timing->peers_scene);
}

enum status peers_timing(const struct peers_work *work)
{
    json_t *rows = json_array();
    json_object_set_new(work->report, "timing", rows);
    struct timing *timing = calloc(1, sizeof *timing);
    struct scene *scene = prepare_scene_copy(work->last);
    enum status status = timing && scene ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "out of memory");
    if (status == STATUS_OK) {
        *timing = (struct timing){.work = work, .peers_scene = scene};
        choose_contestants(timing);
        status = make_peers_world(timing);
    }
    if (status == STATUS_OK)
        status = write_our_scene(timing, false);
    if (status == STATUS_OK && is_hertz(work))
        status = write_our_scene(timing, true);
    if (status == STATUS_OK)
        status = take_turns(timing, work->reps, rows);
    if (timing)
        sample_free(timing->sample);
    prepare_scene_free(scene);
    free(timing);
    return status;
}
