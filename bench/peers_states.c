/* The same states given to all, one after the other, so that contacts load, shear, unload and slide with the history
 * that they have by then. Nothing moves by itself: a state is positions and velocities, and all evaluate forces in it
 * once. Springs move in states with a velocity, and forces are compared in the next one, at rest: the three take
 * springs at different times within a step. Distances change alike in all directions, so that normals do not turn, and
 * what slides does not approach, so that no contact begins within a step: there too the three differ, by what is of
 * higher order in the time step. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/child.h"
#include "bench/peers_bench.h"
#include "bench/peers_output.h"
#include "bench/prepared_sample.h"
#include "sim/measure/measure.h"
#include "sim/run/sample_source.h"
#include "sim/sample/step_completion.h"

enum { COLUMNS_MAX = 4 };

/* A state against the one before. In units of the mean overlap over the mean diameter, the strain of a contact. */
struct step {
    const char *name;
    double strain; /* of all distances, > 0: apart */
    double slide;  /* shear in the time step, in the plane of components `plane` and the next */
    int plane;
    bool damped; /* approach, unlike along the axes, by which dashpots add about a tenth; no time passes */
    double mu;
};

/* Friction that nothing overcomes, where springs or dashpots move. */
#define STICKS 1e6

/* So long that dashpots give nothing where springs move [s]. */
static const double STEP_S = 1e3;

static const struct step MINDLIN[] = {
    {"as prepared", 0, 0, 0, false, STICKS},
    {NULL, 0, 0.3, 0, false, STICKS},
    {"sheared", 0, 0, 0, false, STICKS},
    {"unloaded", 0.3, 0, 0, false, STICKS},
    {NULL, 0, -0.2, 1, false, STICKS},
    {"sheared, unloaded, sheared", 0, 0, 0, false, STICKS},
    {"loaded beyond", -0.6, 0, 0, false, STICKS},
    {NULL, 0, 0.2, 2, false, STICKS},
    {"and sheared", 0, 0, 0, false, STICKS},
    {"unloaded again", 0.4, 0, 0, false, STICKS},
    {"the same, with dashpots", 0, 0, 0, true, STICKS},
    {"mu = 0.1: many slide", 0, 0, 0, false, 0.1},
    {"loaded after that", -0.3, 0, 0, false, 0.1},
    {"unloaded after that", 0.5, 0, 0, false, 0.1},
};

static const struct step LUDING[] = {
    {"first loading", 0, 0, 0, false, 0},
    {"loaded further", -0.5, 0, 0, false, 0},
    {"unloaded, some adhere", 0.4, 0, 0, false, 0},
    {"loaded again, below the most", -0.2, 0, 0, false, 0},
    {"loaded beyond the most", -0.6, 0, 0, false, 0},
    {"unloaded, most adhere", 0.8, 0, 0, false, 0},
};

struct column {
    const char *name, *note;
    enum peer peer;
    enum peer_law law;
    const char *tangential;
    int precision; /* ours */
};

static const struct column MINDLINS[] = {
    {"LAMMPS", "rescale/force", PEER_LAMMPS, PEER_HERTZ, "mindlin_rescale/force", PRECISION_DOUBLE},
    {"LAMMPS", "rescale", PEER_LAMMPS, PEER_HERTZ, "mindlin_rescale", PRECISION_DOUBLE},
    {"LIGGGHTS", "hertz", PEER_LIGGGHTS, PEER_HERTZ, NULL, PRECISION_DOUBLE},
    {"LAMMPS", "ours mixed", PEER_LAMMPS, PEER_HERTZ, "mindlin_rescale/force", PRECISION_MIXED},
};

static const struct column LUDINGS[] = {
    {"LIGGGHTS", "luding", PEER_LIGGGHTS, PEER_LUDING, NULL, PRECISION_DOUBLE},
};

struct course {
    const char *title;
    const struct step *step;
    int n;
    const struct column *column;
    int n_columns;
    struct peers_difference difference[PEER_STATES_MAX][COLUMNS_MAX]; /* over the mean contact force */
    int left_out[PEER_STATES_MAX];                                    /* particles */
};

/* One column: the sample and what the peer said of it. */
struct session {
    struct sample *sample;
    struct peers_scale scale;
    char *dump;                       /* text */
    double *x, *v, *ours, *theirs;    /* [3 count] by id */
    double *most[1 + 2 * SCENE_AXES]; /* largest overlaps of the lists' members in the state before */
    bool *apart;                      /* [count] by id: the peer's histories are not ours any more */
};

static struct peer_state state_of(const struct step *step, const struct peers_scale *scale, int dimension)
{
    static const double share[3] = {1, 0.6, 0.3};
    const double strain = scale->overlap_m / scale->diameter_m, shear = step->slide * strain / STEP_S;
    /* gamma u/f of Hertz' dashpot is about 2.7 beta u/sqrt(f overlap/m), beta about 0.1 */
    const double speed = 0.4 * sqrt(scale->force_n * scale->overlap_m / scale->mass_kg);
    struct peer_state state = {
        .name = step->name, .strain = step->strain * strain, .instant = step->damped, .mu = step->mu};
    for (int c = 0; c < dimension; c++)
        state.velocity_per_s[c][c] = step->damped ? -share[c] * speed / scale->diameter_m : 0.5 * fabs(shear);
    state.velocity_per_s[step->plane % dimension][(step->plane + 1) % dimension] = shear;
    return state;
}

/* Luding's law on the same packing: k1 from the mean force and overlap, k2 growing with the overlap beyond all that
 * there are, to 5 k1 at 12 mean ones: when it has grown LIGGGHTS' contacts are elastic, ours go on yielding. */
static void make_luding(struct scene *scene, const struct peers_scale *scale)
{
    struct scene_material *m = &scene->stage[0].material;
    const double k1 = scale->force_n / scale->overlap_m, ratio = 5;
    *m = (struct scene_material){.law = LAW_ELASTOPLASTIC,
                                 .k1_n_per_m = k1,
                                 .k2_n_per_m = ratio * k1,
                                 .kp_n_per_m = ratio * k1,
                                 .kc_n_per_m = ratio * k1,
                                 .restitution = 1,
                                 .phi_f = 12 * scale->overlap_m * (ratio - 1) / ratio / (0.5 * scale->diameter_m)};
}

static enum status set_scene(struct scene *scene, const struct column *column)
{
    struct sample *sample = NULL;
    struct peers_scale scale;
    scene->precision = column->precision;
    scene->stage[0].material.gamma_b_kg_per_s = scene->stage[0].material.gamma_br_kg_per_s = 0;
    for (int k = 0; k < SCENE_AXES; k++)
        scene->stage[0].axis[k].mode = WALL_FIXED;
    if (column->law != PEER_LUDING)
        return STATUS_OK;
    enum status status = sample_from_scene(&sample, scene);
    if (status == STATUS_OK)
        status = peers_start_stage(sample);
    if (status == STATUS_OK)
        status = peers_measure_scale(sample, &scale);
    if (status == STATUS_OK)
        make_luding(scene, &scale);
    sample_free(sample);
    return status;
}

/* At rest and without history. */
static enum status start(struct session *session, const struct scene *scene)
{
    TRY(sample_from_scene(&session->sample, scene));
    struct particles *p = &session->sample->particles;
    double **array[] = {&session->x, &session->v, &session->ours, &session->theirs};
    for (size_t k = 0; k < sizeof array / sizeof *array; k++)
        if (!(*array[k] = calloc(3 * (size_t)p->count, sizeof(double))))
            return status_fail(STATUS_NO_MEMORY, "out of memory");
    for (int l = 0; l <= session->sample->n_walls; l++)
        if (!(session->most[l] = calloc((size_t)sample_list(session->sample, l)->count + 1, sizeof(double))))
            return status_fail(STATUS_NO_MEMORY, "out of memory");
    if (!(session->apart = calloc((size_t)p->count, sizeof *session->apart)))
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    TRY(peers_start_stage(session->sample));
    TRY(peers_measure_scale(session->sample, &session->scale));
    TRY(prepare_forget(session->sample));
    for (int c = 0; c < p->dimension; c++)
        memset(p->v[c], 0, (size_t)p->count * sizeof(double));
    for (int c = 0; c < p->n_rotations; c++)
        memset(p->omega[c], 0, (size_t)p->count * sizeof(double));
    return STATUS_OK;
}

static void stop(struct session *session)
{
    for (int l = 0; session->sample && l <= session->sample->n_walls; l++)
        free(session->most[l]);
    free(session->dump);
    free(session->x);
    free(session->v);
    free(session->ours);
    free(session->theirs);
    free(session->apart);
    sample_free(session->sample);
}

static enum status run_peer(struct session *session, const struct scene *scene, const struct course *course,
                            const struct column *column, const char *folder)
{
    char path[1100];
    struct peer_state state[PEER_STATES_MAX];
    struct peer_input input = peers_input_of(scene, session->sample);
    for (int k = 0; k < course->n; k++)
        state[k] = state_of(&course->step[k], &session->scale, input.dimension);
    input.dt_s = STEP_S;
    input.peer = column->peer;
    input.law = column->law;
    input.tangential = column->tangential;
    input.frictional = column->law == PEER_HERTZ;
    input.plasticity_depth = scene->stage[0].material.phi_f;
    input.mu = state[0].mu;
    input.dump = "states.dump";
    input.state = state;
    input.n_states = course->n;
    snprintf(path, sizeof path, "%s/%s", folder, input.dump);
    TRY(peers_run(&input, session->sample, folder, "states"));
    return file_read(path, &session->dump);
}

/* Forces where the particles are, histories moved on by dt_s. Walls are smooth. */
static void evaluate(struct sample *sample, double dt_s)
{
    struct contact_losses lost = {0};
    struct contact_law_constants of_walls = sample->law;
    of_walls.mu_s = of_walls.mu_d = 0;
    particles_import_state(&sample->particles);
    (void)threads_drift(&sample->threads, &sample->kernels, &sample->particles, 0, 0, INFINITY);
    /* again, as if a step had gone before at the same velocities: contacts go by v dt, without a lag (particles.h) */
    (void)threads_drift(&sample->threads, &sample->kernels, &sample->particles, 0, DBL_MIN, INFINITY);
    for (int w = 0; w < sample->n_walls; w++)
        sample->kernels.wall(&sample->particles, &sample->walls[w], &of_walls, dt_s, &lost);
    step_pair_forces(sample, dt_s);
    step_kick(sample, 0);
}

/* Contacts whose largest overlap falls. One that adheres forgets a part of it: LIGGGHTS takes what it keeps from the k2
 * of before, so that the next force is off the branch of adhesion. A pair that opens forgets all: LIGGGHTS does when it
 * builds its lists. Their particles count no more from then on. Returns how many have dropped out before. */
static int find_apart(struct session *session, bool *apart_then)
{
    struct sample *sample = session->sample;
    const struct particles *p = &sample->particles;
    int n = 0;
    memcpy(apart_then, session->apart, (size_t)p->count * sizeof *apart_then);
    for (int l = 0; sample->pairs.model.traits & NORMAL_REMEMBERS_OVERLAP && l <= sample->n_walls; l++) {
        const struct contact_list *list = sample_list(sample, l);
        for (int k = 0; k < list->count; k++) {
            const double most = contact_list_value(list, HISTORY_MAX_OVERLAP, k);
            if (most < session->most[l][k] && (l == 0 || most > 0)) {
                session->apart[p->id[list->i[k]]] = true;
                if (l == 0)
                    session->apart[p->id[list->j[k]]] = true;
            }
            session->most[l][k] = most;
        }
    }
    for (int i = 0; i < p->count; i++)
        n += apart_then[i];
    return n;
}

static enum status compare_state(struct session *session, struct course *course, int k, int column)
{
    struct sample *sample = session->sample;
    struct particles *p = &sample->particles;
    const struct step *step = &course->step[k];
    TRY(peers_read_snapshot(session->dump, k + 1, p->count, session->x, session->v, session->theirs));
    for (int i = 0; i < p->count; i++)
        for (int c = 0; c < p->dimension; c++) {
            p->x[c][i] = session->x[3 * p->id[i] + c];
            p->v[c][i] = session->v[3 * p->id[i] + c];
        }
    sample->law.mu_s = sample->law.mu_d = step->mu;
    evaluate(sample, step->damped ? 1e-30 : STEP_S);
    for (int i = 0; i < p->count; i++)
        for (int c = 0; c < p->dimension; c++)
            session->ours[3 * p->id[i] + c] = p->a[c][i] * p->mass[i];
    bool *apart = malloc((size_t)p->count * sizeof *apart);
    if (!apart)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    course->left_out[k] = find_apart(session, apart);
    for (int i = 0; i < p->count; i++)
        for (int c = 0; apart[i] && c < 3; c++)
            session->ours[3 * i + c] = session->theirs[3 * i + c] = 0;
    free(apart);
    struct peers_difference d = peers_compare(session->ours, session->theirs, p->count);
    course->difference[k][column].largest = d.largest / session->scale.force_n;
    course->difference[k][column].rms = d.rms / session->scale.force_n;
    return STATUS_OK;
}

static enum status run_column(const struct peers_work *work, struct course *course, int column)
{
    struct session session = {0};
    struct scene *scene = prepare_scene_copy(work->last);
    if (!scene)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = set_scene(scene, &course->column[column]);
    if (status == STATUS_OK)
        status = start(&session, scene);
    if (status == STATUS_OK)
        status = run_peer(&session, scene, course, &course->column[column], work->folder);
    for (int k = 0; status == STATUS_OK && k < course->n; k++)
        status = compare_state(&session, course, k, column);
    stop(&session);
    prepare_scene_free(scene);
    return status;
}

static void report(const struct course *course, int count, json_t *rows)
{
    printf("%s: largest difference to ours over the mean contact force\n  %-30s", course->title, "");
    for (int c = 0; c < course->n_columns; c++)
        printf(" %8s %-13s", course->column[c].name, course->column[c].note);
    printf("\n");
    for (int k = 0; k < course->n; k++) {
        if (!course->step[k].name)
            continue;
        printf("  %-30s", course->step[k].name);
        for (int c = 0; c < course->n_columns; c++) {
            const struct peers_difference *d = &course->difference[k][c];
            printf(" %8.1e %-13s", d->largest, "");
            json_array_append_new(rows, json_pack("{s:s, s:s, s:s, s:s, s:f, s:f, s:i}", "law", course->title, "state",
                                                  course->step[k].name, "peer", course->column[c].name, "form",
                                                  course->column[c].note, "largest", d->largest, "rms", d->rms,
                                                  "left_out", course->left_out[k]));
        }
        if (course->left_out[k])
            printf(" without %d of %d particles: a contact adhered or opened before", course->left_out[k], count);
        printf("\n");
    }
}

enum status peers_states(const struct peers_work *work)
{
    struct course course[] = {{.title = "Hertz-Mindlin",
                               .step = MINDLIN,
                               .n = sizeof MINDLIN / sizeof *MINDLIN,
                               .column = MINDLINS,
                               .n_columns = sizeof MINDLINS / sizeof *MINDLINS},
                              {.title = "Luding, k2 grows",
                               .step = LUDING,
                               .n = sizeof LUDING / sizeof *LUDING,
                               .column = LUDINGS,
                               .n_columns = sizeof LUDINGS / sizeof *LUDINGS}};
    json_t *rows = json_array();
    json_object_set_new(work->report, "states", rows);
    for (size_t k = 0; k < sizeof course / sizeof *course; k++) {
        for (int c = 0; c < course[k].n_columns; c++)
            TRY(run_column(work, &course[k], c));
        report(&course[k], (int)work->last->sample.count, rows);
    }
    return STATUS_OK;
}
