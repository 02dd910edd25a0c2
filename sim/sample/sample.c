#include "sim/sample/sample.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim/look/measure.h"
#include "sim/neighbours/locality_order.h"
#include "sim/run/checkpoint.h"
#include "sim/sample/time_step.h"
#include "sim/sample/wall_motion.h"

double sample_box_length_m(const struct sample *sample, int c)
{
    return sample->walls[2 * c + 1].x - sample->walls[2 * c].x;
}

enum axis sample_axis(const struct sample *sample, int c)
{
    return scene_pair_axis(sample->scene, c);
}

static void name_walls(struct sample *sample)
{
    for (int w = 0; w < sample->n_walls; w++) {
        sample->walls[w] = (struct wall){.axis = w / 2, .inward = w % 2 ? -1 : 1};
        sample->walls[w].contacts.hysteretic = sample->pairs.hysteretic;
        sample->walls[w].contacts.n_springs = sample->pairs.n_springs;
        sample->walls[w].contacts.single = sample->pairs.single;
    }
}

static void place_walls(struct sample *sample, const double *lo, const double *hi)
{
    for (int w = 0; w < sample->n_walls; w++)
        sample->walls[w].x = w % 2 ? hi[w / 2] : lo[w / 2];
}

/* Everything that does not need a state. */
static enum status model(struct sample *sample, const struct scene *scene)
{
    bool frictional = scene_is_frictional(scene), hysteretic = scene_is_hysteretic(scene);
    bool single = scene->precision == PRECISION_MIXED;
    int dimension = (int)scene->dimension;
    sample->scene = scene;
    sample->stage = -1;
    sample->n_walls = scene_wall_count(scene);
    for (int c = 0; c < dimension && scene->gravity_m_per_s2.count; c++)
        sample->gravity[c] = scene->gravity_m_per_s2.value[sample_axis(sample, c)];
    TRY(instruction_set_select(&sample->isa));
    sample->kernels = kernels_select(sample->isa, dimension, hysteretic, frictional, single);
    TRY(particles_init(&sample->particles, (int)scene->sample.count, dimension, frictional, single));
    sample->pairs.hysteretic = hysteretic;
    sample->pairs.single = single;
    sample->pairs.n_springs = sample->particles.n_rotations;
    name_walls(sample);
    return STATUS_OK;
}

static enum status create_and(struct sample **sample, const struct scene *scene,
                              enum status (*fill)(struct sample *sample))
{
    *sample = calloc(1, sizeof **sample);
    if (!*sample)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = model(*sample, scene);
    if (status == STATUS_OK && fill)
        status = fill(*sample);
    if (status != STATUS_OK) {
        sample_free(*sample);
        *sample = NULL;
    }
    return status;
}

enum status sample_init_lists(struct sample *sample)
{
    TRY(verlet_list_init(&sample->verlet, &sample->particles, sample->scene->neighbor.skin_ratio,
                         sample->pairs.hysteretic, sample->isa));
    TRY(threads_init(&sample->threads, &sample->particles, sample->scene->threads));
    threads_cut(&sample->threads, &sample->particles, &sample->pairs);
    sample->verlet.renumber_steps =
        locality_order_interval(sample->scene->neighbor.renumber_steps, sample->particles.count);
    return STATUS_OK;
}

enum status sample_build_lists(struct sample *sample)
{
    TRY(verlet_list_build(&sample->verlet, &sample->particles, &sample->pairs, sample->walls, sample->n_walls));
    threads_cut(&sample->threads, &sample->particles, &sample->pairs);
    return STATUS_OK;
}

enum status sample_close_lists(struct sample *sample)
{
    TRY(contact_list_close(&sample->pairs, &sample->particles, NULL));
    for (int w = 0; w < sample->n_walls; w++)
        TRY(contact_list_close(&sample->walls[w].contacts, &sample->particles, &sample->walls[w]));
    return STATUS_OK;
}

static enum status fill_sample(struct sample *sample)
{
    double lo[3], hi[3];
    if (sample->scene->sample.initial == INITIAL_CHECKPOINT) {
        TRY(checkpoint_start(sample->scene->sample.checkpoint, sample));
    } else {
        TRY(initial_packing_make(&sample->particles, sample->scene, lo, hi));
        place_walls(sample, lo, hi);
    }
    for (int w = 0; w < sample->n_walls; w++)
        sample->trajectory.x0[w] = sample->walls[w].x;
    TRY(sample_init_lists(sample));
    return sample_build_lists(sample);
}

enum status sample_create_empty(struct sample **sample, const struct scene *scene)
{
    return create_and(sample, scene, NULL);
}

enum status sample_create(struct sample **sample, const struct scene *scene)
{
    return create_and(sample, scene, fill_sample);
}

void sample_free(struct sample *sample)
{
    if (!sample)
        return;
    particles_free(&sample->particles);
    contact_list_free(&sample->pairs);
    for (int w = 0; w < sample->n_walls; w++)
        contact_list_free(&sample->walls[w].contacts);
    verlet_list_free(&sample->verlet);
    threads_free(&sample->threads);
    free(sample);
}

static void ledger_start(struct sample *sample)
{
    memset(&sample->ledger, 0, sizeof sample->ledger);
    struct held_energy held = measure_held_energy(sample);
    sample->ledger.kinetic_start = held.kinetic_j;
    sample->ledger.elastic_start = held.elastic_j;
    sample->ledger.potential_start = measure_potential_energy_j(sample);
}

void sample_set_law(struct sample *sample)
{
    sample->material = sample->stage < 0 ? NULL : &sample->scene->stage[sample->stage].material;
    if (sample->material) {
        sample->law = contact_law_constants_of(sample->material);
        coupling_audit_set_law(sample);
    }
}

static void stage_start(struct sample *sample, int stage)
{
    sample_complete(sample);
    const struct scene_stage *next = &sample->scene->stage[stage];
    sample->stage = stage;
    sample->stage_step = 0;
    sample->stage_time_start_s = sample->time_s;
    sample->dt = next->dt_s;
    sample_set_law(sample);
    for (int w = 0; w < sample->n_walls; w++)
        sample->stage_position_m[w] = sample->walls[w].x;
    time_step_forces_anew(sample);
    ledger_start(sample);
    coupling_audit_stage_start(sample);
}

enum status sample_command(struct sample *sample, const struct wall_command *command)
{
    if (command->step != sample->step || command->n_walls != sample->n_walls || command->n_steps < 1)
        return status_fail(STATUS_FORMAT, "step %lld: a command for step %lld, %d walls, %d steps does not fit",
                           (long long)sample->step, (long long)command->step, command->n_walls, command->n_steps);
    if (command->stage < 0 || command->stage >= sample->scene->n_stages || command->stage < sample->stage)
        return status_fail(STATUS_FORMAT, "step %lld: a command for stage %d does not fit stage %d",
                           (long long)sample->step, command->stage, sample->stage);
    coupling_audit_close(sample, command);
    if (command->stage != sample->stage)
        stage_start(sample, command->stage);
    coupling_audit_open(sample);
    walls_take_command(sample, command);
    return STATUS_OK;
}

void sample_wall_state(const struct sample *sample, struct wall_state *state)
{
    const struct wall_trajectory *path = &sample->trajectory;
    const struct coupling_audit *audit = &sample->audit;
    memset(state, 0, sizeof *state);
    state->step = sample->step;
    state->time_s = sample->time_s;
    state->stage = sample->stage;
    state->stage_step = sample->stage_step;
    state->stage_time_s = sample->stage < 0 ? 0 : (double)sample->stage_step * sample->dt;
    state->interval_s = path->n_steps * path->dt;
    state->command_step = sample->step;
    state->interface_residual_j = audit->residual_j;
    state->interface_error = audit->error;
    state->interface_error_before = audit->error_before;
    state->n_walls = sample->n_walls;
    for (int w = 0; w < sample->n_walls; w++) {
        const struct wall *wall = &sample->walls[w];
        state->position_m[w] = wall->x;
        state->velocity_m_per_s[w] = walls_mean_velocity_m_per_s(sample, w);
        state->force_before_n[w] = audit->force_start[w];
        state->force_n[w] = wall->force;
        state->stage_position_m[w] = sample->stage_position_m[w];
    }
    memcpy(state->ahead_position_m, state->position_m, sizeof state->ahead_position_m);
    memcpy(state->ahead_velocity_m_per_s, state->velocity_m_per_s, sizeof state->ahead_velocity_m_per_s);
    measure_wall_stiffness(sample, state->stiffness_n_per_m, state->damping_kg_per_s);
}

void sample_wall_state_ahead(const struct sample *sample, struct wall_state *state)
{
    if (sample->stage_step == 0) /* the stage began meanwhile */
        sample_wall_state(sample, state);
    state->command_step = sample->trajectory.from_step + sample->trajectory.n_steps;
    for (int w = 0; w < sample->n_walls; w++) {
        state->ahead_position_m[w] = walls_end_position_m(sample, w);
        state->ahead_velocity_m_per_s[w] = walls_mean_velocity_m_per_s(sample, w);
    }
}

/* FNV-1a */
static uint64_t hash_bytes(uint64_t hash, const void *data, size_t size)
{
    const unsigned char *bytes = data;
    for (size_t k = 0; k < size; k++)
        hash = (hash ^ bytes[k]) * 0x100000001b3u;
    return hash;
}

/* In the order of ids. */
static uint64_t hash_values(uint64_t hash, const struct particles *p, const double *values)
{
    for (int i = 0; i < p->count; i++)
        hash = hash_bytes(hash, &values[p->slot[i]], sizeof *values);
    return hash;
}

uint64_t sample_hash(const struct sample *sample)
{
    sample_complete(sample);
    const struct particles *p = &sample->particles;
    uint64_t hash = 0xcbf29ce484222325u;
    for (int c = 0; c < p->dimension; c++) {
        hash = hash_values(hash, p, p->x[c]);
        hash = hash_values(hash, p, p->v[c]);
    }
    for (int c = 0; c < p->n_rotations; c++)
        hash = hash_values(hash, p, p->omega[c]);
    for (int w = 0; w < sample->n_walls; w++) {
        hash = hash_bytes(hash, &sample->walls[w].x, sizeof(double));
        hash = hash_bytes(hash, &sample->walls[w].v, sizeof(double));
    }
    return hash;
}
