/* Time per step: every contestant in turn, again and again. Peers first try several settings of their neighbour lists
 * and keep the fastest. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/child.h"
#include "bench/peers_bench.h"
#include "bench/peers_output.h"
#include "bench/prepare.h"
#include "sim/kernels.h"

enum { CONTESTANTS_MAX = 8, TUNE_STEPS = 500, WARM_UP = 50 };

/* Skin over the mean radius, and steps without a look at the lists. */
static const double SKINS[] = {0.05, 0.15, 0.4};
static const int DELAYS[] = {0, 20};

struct contestant {
    const char *name, *note;
    const char *isa; /* ours; NULL: a peer */
    enum peer peer;
    enum peer_law law;
    bool walls_move;
    double skin_ratio; /* found by trying */
    int delay;
    double us[PEERS_REPS_MAX], least, median;
};

static const struct contestant FRICTIONLESS[] = {
    {.name = "shakedown, AVX-512", .note = "hysteretic, cohesive, walls move", .isa = "avx512"},
    {.name = "shakedown, AVX2", .note = "hysteretic, cohesive, walls move", .isa = "avx2"},
    {.name = "LAMMPS gran/hooke", .note = "linear, fixed walls", .peer = PEER_LAMMPS, .law = PEER_HOOKE},
    {.name = "LAMMPS granular", .note = "linear, fixed walls", .peer = PEER_LAMMPS, .law = PEER_GRANULAR},
    {.name = "LIGGGHTS hooke/stiffness", .note = "linear, fixed walls", .peer = PEER_LIGGGHTS, .law = PEER_STIFFNESS},
    {.name = "LIGGGHTS luding", .note = "hysteretic, fixed walls", .peer = PEER_LIGGGHTS, .law = PEER_LUDING},
};

static const struct contestant FRICTIONAL[] = {
    {.name = "shakedown, AVX-512", .note = "friction, walls move", .isa = "avx512"},
    {.name = "shakedown, AVX2", .note = "friction, walls move", .isa = "avx2"},
    {.name = "LAMMPS gran/hooke/history", .note = "friction, fixed walls", .peer = PEER_LAMMPS, .law = PEER_HOOKE},
    {.name = "LAMMPS gran/hooke/history",
     .note = "friction, walls move",
     .peer = PEER_LAMMPS,
     .law = PEER_HOOKE,
     .walls_move = true},
    {.name = "LAMMPS granular", .note = "friction, fixed walls", .peer = PEER_LAMMPS, .law = PEER_GRANULAR},
    {.name = "LIGGGHTS hooke/stiffness", .note = "friction, fixed walls", .peer = PEER_LIGGGHTS, .law = PEER_STIFFNESS},
};

struct timing {
    const struct peers_work *work;
    struct scene *peers_scene; /* the last stage from the settled sample */
    struct world *world;       /* and its world */
    char scene_path[1100];     /* of ours */
    struct contestant contestant[CONTESTANTS_MAX];
    int n;
};

static enum status read_time(const char *folder, const char *name, double *us)
{
    char path[1100], *text;
    snprintf(path, sizeof path, "%s/%s.log", folder, name);
    TRY(file_read(path, &text));
    enum status status = peers_read_loop(text, us);
    free(text);
    return status;
}

/* The program itself, as users run it in process; no records, as the peers write none. */
static enum status time_ours(const struct timing *timing, const char *isa, double *us)
{
    char log[1100];
    snprintf(log, sizeof log, "%s/ours.log", timing->work->folder);
    const char *const argv[] = {timing->work->sim, timing->scene_path, "--in-process", "--progress", NULL};
    struct child child = {.argv = argv, .log = log, .variable = "SHAKEDOWN_ISA", .value = isa};
    TRY(child_run(&child));
    return read_time(timing->work->folder, "ours", us);
}

static enum status time_peer(const struct timing *timing, const struct contestant *c, long steps, double *us)
{
    struct peer_input input = peers_input_of(timing->peers_scene, timing->world);
    input.peer = c->peer;
    input.law = c->law;
    input.walls_move = c->walls_move;
    input.skin_m = c->skin_ratio * peers_mean_radius(timing->world);
    input.delay = c->delay;
    input.warm_up = WARM_UP;
    input.steps = steps;
    input.restitution = 0.9;
    TRY(peers_run(&input, timing->world, timing->work->folder, "timing"));
    return read_time(timing->work->folder, "timing", us);
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
            TRY(time_peer(timing, c, TUNE_STEPS, &us));
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
        if (strcmp(kernel_isa_name(isa), name) == 0)
            return kernel_isa_supported(isa);
    return false;
}

static void choose_contestants(struct timing *timing)
{
    bool frictional = scene_is_frictional(timing->work->last);
    const struct contestant *from = frictional ? FRICTIONAL : FRICTIONLESS;
    int n = (int)(frictional ? sizeof FRICTIONAL : sizeof FRICTIONLESS) / (int)sizeof *from;
    for (int k = 0; k < n; k++) {
        if (!from[k].isa || isa_is_supported(from[k].isa))
            timing->contestant[timing->n++] = from[k];
        else
            printf("  SKIPPED: %s: this CPU cannot run it\n", from[k].name);
    }
}

/* Our scene: as many steps as are timed, no samples between; a hysteretic law gets cohesion, kc = k2. */
static enum status write_our_scene(struct timing *timing)
{
    struct scene *scene = malloc(sizeof *scene);
    if (!scene)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    *scene = *timing->work->last; /* its text stays the original's */
    struct scene_stage *stage = &scene->stage[0];
    stage->duration_s = (double)timing->work->at->our_steps * stage->dt_s;
    stage->sample_interval_s = stage->duration_s;
    stage->frame_interval_s = 0;
    stage->frame_strains.count = 0;
    if (scene_is_hysteretic(scene))
        stage->material.kc_n_per_m = stage->material.k2_n_per_m;
    snprintf(timing->scene_path, sizeof timing->scene_path, "%s/timing.cfg", timing->work->folder);
    enum status status = prepare_scene_file(scene, timing->scene_path);
    free(scene);
    return status;
}

static int rising(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void report_times(struct timing *timing, int reps, json_t *rows)
{
    const struct contestant *first = &timing->contestant[0];
    printf("  %-26s %-33s %9s %9s   over %s\n", "us per step", "", "least", "median", first->isa);
    for (int k = 0; k < timing->n; k++) {
        struct contestant *c = &timing->contestant[k];
        char settings[64] = "";
        if (!c->isa)
            snprintf(settings, sizeof settings, "   skin %g a, delay %d", c->skin_ratio, c->delay);
        printf("  %-26s %-33s %9.2f %9.2f   %6.2f %6.2f%s\n", c->name, c->note, c->least, c->median,
               c->least / first->least, c->median / first->median, settings);
        json_t *times = json_array();
        for (int r = 0; r < reps; r++)
            json_array_append_new(times, json_real(c->us[r]));
        json_array_append_new(rows, json_pack("{s:s, s:s, s:f, s:f, s:f, s:f, s:f, s:i, s:o}", "name", c->name, "note",
                                              c->note, "least_us", c->least, "median_us", c->median, "ratio_least",
                                              c->least / first->least, "ratio_median", c->median / first->median,
                                              "skin_ratio", c->skin_ratio, "delay", c->delay, "us", times));
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
            TRY(c->isa ? time_ours(timing, c->isa, &c->us[r])
                       : time_peer(timing, c, timing->work->at->steps, &c->us[r]));
        }
    for (int k = 0; k < timing->n; k++) {
        double sorted[PEERS_REPS_MAX];
        memcpy(sorted, timing->contestant[k].us, sizeof sorted);
        qsort(sorted, (size_t)reps, sizeof *sorted, rising);
        timing->contestant[k].least = sorted[0];
        timing->contestant[k].median = sorted[reps / 2];
    }
    report_times(timing, reps, rows);
    return STATUS_OK;
}

/* The stage before the last once more, with the linear law of k1, to `checkpoint` [CONFIG_STRING_MAX]. */
static enum status settle(const struct peers_work *work, char *checkpoint)
{
    char path[1100], file[1100], log[1100];
    struct scene *scene = malloc(sizeof *scene);
    if (!scene)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    *scene = *work->whole; /* its text stays the original's */
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
    free(scene);
    TRY(status);
    return prepare_path(file, checkpoint);
}

static enum status make_peers_world(struct timing *timing)
{
    const struct peers_work *work = timing->work;
    char checkpoint[CONFIG_STRING_MAX];
    *timing->peers_scene = *work->last; /* its text stays the original's */
    if (scene_is_hysteretic(work->last)) {
        TRY(settle(work, checkpoint));
        prepare_stage(timing->peers_scene, 0, checkpoint);
    }
    return world_create(&timing->world, timing->peers_scene);
}

enum status peers_timing(const struct peers_work *work)
{
    json_t *rows = json_array();
    json_object_set_new(work->report, "timing", rows);
    struct timing *timing = calloc(1, sizeof *timing);
    struct scene *scene = calloc(1, sizeof *scene);
    enum status status = timing && scene ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "out of memory");
    if (status == STATUS_OK) {
        *timing = (struct timing){.work = work, .peers_scene = scene};
        choose_contestants(timing);
        status = make_peers_world(timing);
    }
    if (status == STATUS_OK)
        status = write_our_scene(timing);
    if (status == STATUS_OK)
        status = take_turns(timing, work->reps, rows);
    if (timing)
        world_free(timing->world);
    free(scene);
    free(timing);
    return status;
}
