/* Equal physics, shown: the same state given to all three, and what each makes of it. */
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/child.h"
#include "bench/peers_bench.h"
#include "bench/peers_output.h"
#include "bench/prepared_sample.h"
#include "sim/measure/measure.h"
#include "sim/run/sample_source.h"
#include "sim/sample/stage.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"

enum { PATH_STEPS = 200 };

/* What is compared. */
struct trial {
    const char *name;
    enum peer peer;
    enum peer_law law;
    bool friction, damping, hysteretic;
    int precision; /* ours */
    long steps;    /* 0: the forces of the state */
};

/* Friction so strong that nothing slides where forces are compared: without a spring yet, the three treat a slider
 * differently. */
static const double STICKY_MU = 100;

static const struct trial TRIALS[] = {
    {"forces, no friction", PEER_LAMMPS, PEER_GRANULAR, false, true, false, PRECISION_DOUBLE, 0},
    {"forces, no friction", PEER_LIGGGHTS, PEER_STIFFNESS, false, true, false, PRECISION_DOUBLE, 0},
    {"forces, Luding, first loading", PEER_LIGGGHTS, PEER_LUDING, false, false, true, PRECISION_DOUBLE, 0},
    {"forces, friction", PEER_LAMMPS, PEER_GRANULAR, true, true, false, PRECISION_DOUBLE, 0},
    {"forces, friction", PEER_LIGGGHTS, PEER_STIFFNESS, true, true, false, PRECISION_DOUBLE, 0},
    {"forces, ours in mixed precision", PEER_LAMMPS, PEER_GRANULAR, true, true, false, PRECISION_MIXED, 0},
    {"paths, no loss", PEER_LAMMPS, PEER_HOOKE, false, false, false, PRECISION_DOUBLE, PATH_STEPS},
    {"paths, no loss", PEER_LIGGGHTS, PEER_STIFFNESS, false, false, false, PRECISION_DOUBLE, PATH_STEPS},
    {"paths, friction and damping", PEER_LAMMPS, PEER_GRANULAR, true, true, false, PRECISION_DOUBLE, PATH_STEPS},
    {"paths, friction and damping", PEER_LIGGGHTS, PEER_STIFFNESS, true, true, false, PRECISION_DOUBLE, PATH_STEPS},
    {"paths, no loss", PEER_LAMMPS, PEER_HERTZ, false, false, false, PRECISION_DOUBLE, PATH_STEPS},
    {"paths, no loss", PEER_LIGGGHTS, PEER_HERTZ, false, false, false, PRECISION_DOUBLE, PATH_STEPS},
    {"paths, friction and damping", PEER_LAMMPS, PEER_HERTZ, true, true, false, PRECISION_DOUBLE, PATH_STEPS},
};

/* The trial's law in the scene, walls that stay, no background. */
static void set_law(struct scene *scene, const struct trial *trial, bool hysteretic)
{
    struct scene_material *m = &scene->stage[0].material;
    scene->precision = trial->precision;
    if (hysteretic && !trial->hysteretic) {
        m->law = LAW_LINEAR;
        m->kn_n_per_m = m->k1_n_per_m;
    }
    if (!trial->friction)
        m->mu_s = m->mu_d = 0;
    else if (trial->steps == 0)
        m->mu_s = m->mu_d = STICKY_MU;
    if (!trial->damping) {
        m->gamma_n_kg_per_s = m->gamma_t_kg_per_s = 0;
        m->restitution = 1;
    }
    m->gamma_b_kg_per_s = m->gamma_br_kg_per_s = 0;
    for (int k = 0; k < SCENE_AXES; k++)
        scene->stage[0].axis[k].mode = WALL_FIXED;
}

/* No history, as the peers start without. No rotation: the peers' lever arms are shorter by half the overlap. speed:
 * 0 leaves the velocities; else they are those of a compression, unlike along the axes, with about this relative
 * velocity in contacts: all approach, as we let none pull and rub, and the peers do. */
static enum status set_state(struct sample *sample, double speed)
{
    static const double share[3] = {1, 0.6, 0.3};
    const double rate = speed / (2 * peers_mean_radius(sample));
    struct particles *p = &sample->particles;
    TRY(prepare_forget(sample));
    for (int c = 0; c < p->n_rotations; c++)
        memset(p->omega[c], 0, (size_t)p->count * sizeof(double));
    for (int c = 0; speed > 0 && c < p->dimension; c++)
        for (int i = 0; i < p->count; i++)
            p->v[c][i] = -share[c] * rate * (p->x[c][i] - 0.5 * (sample->walls[2 * c].x + sample->walls[2 * c + 1].x));
    return STATUS_OK;
}

enum status peers_start_stage(struct sample *sample)
{
    struct wall_command command = {.n_steps = INT_MAX, .n_walls = sample->n_walls};
    for (int w = 0; w < sample->n_walls; w++)
        command.position_m[w] = sample->walls[w].x;
    return sample_command(sample, &command);
}

/* [3 count] by id, components that the sample lacks zero. */
static void positions_and_forces(const struct sample *sample, double *x, double *f)
{
    const struct particles *p = &sample->particles;
    for (int i = 0; i < p->count; i++)
        for (int c = 0; c < 3; c++) {
            x[3 * p->id[i] + c] = c < p->dimension ? p->x[c][i] : 0;
            f[3 * p->id[i] + c] = c < p->dimension ? p->a[c][i] * p->mass[i] : 0;
        }
}

enum status peers_measure_scale(struct sample *sample, struct peers_scale *scale)
{
    const struct particles *p = &sample->particles;
    const int n = measure_contacts(sample_complete(sample), NULL);
    struct contact_measurement *contact = malloc(sizeof *contact * (size_t)(n + 1));
    if (!contact)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    *scale = (struct peers_scale){.diameter_m = 2 * peers_mean_radius(sample)};
    (void)measure_contacts(sample_complete(sample), contact);
    for (int k = 0; k < n; k++) {
        scale->force_n += fabs(contact[k].normal_force_n) / n;
        scale->overlap_m += contact[k].overlap_m / n;
    }
    for (int i = 0; i < p->count; i++)
        scale->mass_kg += p->mass[i] / p->count;
    free(contact);
    return STATUS_OK;
}

struct states {
    double *start, *ours, *ours_force, *theirs, *theirs_force; /* [3 count] */
    struct peers_scale scale;                                  /* of the prepared state */
};

static enum status states_init(struct states *states, int count)
{
    double **member[] = {&states->start, &states->ours, &states->ours_force, &states->theirs, &states->theirs_force};
    for (size_t k = 0; k < sizeof member / sizeof *member; k++) {
        *member[k] = calloc(3 * (size_t)count, sizeof(double));
        if (!*member[k])
            return status_fail(STATUS_NO_MEMORY, "out of memory");
    }
    return STATUS_OK;
}

static void states_free(struct states *states)
{
    free(states->start);
    free(states->ours);
    free(states->ours_force);
    free(states->theirs);
    free(states->theirs_force);
}

static enum status run_peer(const struct trial *trial, const struct scene *scene, const struct sample *sample,
                            const char *folder, struct states *states)
{
    char dump[1024], *text;
    struct peer_input input = peers_input_of(scene, sample);
    snprintf(dump, sizeof dump, "%s/dump", folder);
    input.peer = trial->peer;
    input.law = trial->law;
    input.dump = "dump";
    input.gamma_b = 0;
    input.steps = trial->steps;
    TRY(peers_run(&input, sample, folder, "physics"));
    TRY(file_read(dump, &text));
    enum status status = peers_read_dump(text, sample->particles.count, states->theirs, states->theirs_force);
    free(text);
    return status;
}

static enum status both(const struct trial *trial, const struct scene *scene, struct sample *sample, const char *folder,
                        struct states *states)
{
    const struct scene_material *m = &scene->stage[0].material;
    TRY(states_init(states, sample->particles.count));
    TRY(peers_start_stage(sample));
    TRY(peers_measure_scale(sample, &states->scale));
    bool moves = trial->steps == 0 && m->gamma_n_kg_per_s > 0; /* damping adds about a tenth to the forces */
    TRY(set_state(sample, moves ? 0.1 * states->scale.force_n / m->gamma_n_kg_per_s : 0));
    TRY(run_peer(trial, scene, sample, folder, states));
    time_step_forces_anew(sample);
    positions_and_forces(sample, states->start, states->ours_force);
    for (long k = 0; k < trial->steps; k++)
        TRY(sample_step(sample));
    positions_and_forces(sample, states->ours, states->ours_force);
    return STATUS_OK;
}

/* Forces over the mean contact force; positions over the rms displacement. */
static void report_trial(const struct trial *trial, const struct states *states, int count, json_t *rows)
{
    const char *peer = trial->peer == PEER_LAMMPS ? "LAMMPS" : "LIGGGHTS";
    struct peers_difference d;
    double scale = states->scale.force_n;
    if (trial->steps == 0) {
        d = peers_compare(states->ours_force, states->theirs_force, count);
    } else {
        scale = peers_compare(states->ours, states->start, count).rms;
        d = peers_compare(states->ours, states->theirs, count);
    }
    printf("  %-32s %-9s largest %8.1e   rms %8.1e   of %s %.3g %s\n", trial->name, peer, d.largest / scale,
           d.rms / scale, trial->steps ? "the rms displacement" : "the mean contact force", scale,
           trial->steps ? "m" : "N");
    json_array_append_new(rows, json_pack("{s:s, s:s, s:f, s:f, s:f}", "what", trial->name, "peer", peer, "largest",
                                          d.largest / scale, "rms", d.rms / scale, "scale", scale));
}

static enum status run_trial(const struct trial *trial, const struct scene *original, const char *folder, json_t *rows)
{
    struct states states = {0};
    struct sample *sample = NULL;
    struct scene *scene = prepare_scene_copy(original);
    if (!scene)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    set_law(scene, trial, scene_is_hysteretic(original));
    enum status status = sample_from_scene(&sample, scene);
    if (status == STATUS_OK)
        status = both(trial, scene, sample, folder, &states);
    if (status == STATUS_OK)
        report_trial(trial, &states, sample->particles.count, rows);
    states_free(&states);
    sample_free(sample);
    prepare_scene_free(scene);
    return status;
}

static bool is_of(const struct trial *trial, const struct scene *scene)
{
    return (trial->law == PEER_HERTZ) == (scene->stage[0].material.law == LAW_HERTZ) &&
           (!trial->friction || scene_is_frictional(scene)) && (!trial->hysteretic || scene_is_hysteretic(scene));
}

enum status peers_physics(const struct peers_work *work)
{
    json_t *rows = json_array();
    json_object_set_new(work->report, "physics", rows);
    printf("difference to ours, \"paths\" after %d steps:\n", PATH_STEPS);
    for (size_t k = 0; k < sizeof TRIALS / sizeof *TRIALS; k++)
        if (is_of(&TRIALS[k], work->last))
            TRY(run_trial(&TRIALS[k], work->last, work->folder, rows));
    return STATUS_OK;
}
