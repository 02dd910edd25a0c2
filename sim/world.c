#include "sim/world.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim/checkpoint.h"
#include "sim/drive.h"
#include "sim/integrate.h"
#include "sim/measure.h"
#include "sim/renumber.h"

double world_box_length_m(const struct world *world, int c)
{
    return world->walls[2 * c + 1].x - world->walls[2 * c].x;
}

enum axis world_axis(const struct world *world, int c)
{
    return scene_pair_axis(world->scene, c);
}

static void name_walls(struct world *world)
{
    for (int w = 0; w < world->n_walls; w++) {
        world->walls[w] = (struct wall){.axis = w / 2, .inward = w % 2 ? -1 : 1};
        world->walls[w].contacts.hysteretic = world->pairs.hysteretic;
        world->walls[w].contacts.n_springs = world->pairs.n_springs;
        world->walls[w].contacts.single = world->pairs.single;
    }
}

static void place_walls(struct world *world, const double *lo, const double *hi)
{
    for (int w = 0; w < world->n_walls; w++)
        world->walls[w].x = w % 2 ? hi[w / 2] : lo[w / 2];
}

/* Everything that does not need a state. */
static enum status model(struct world *world, const struct scene *scene)
{
    bool frictional = scene_is_frictional(scene), hysteretic = scene_is_hysteretic(scene);
    bool single = scene->precision == PRECISION_MIXED;
    int dimension = (int)scene->dimension;
    world->scene = scene;
    world->stage = -1;
    world->n_walls = scene_wall_count(scene);
    for (int c = 0; c < dimension && scene->gravity_m_per_s2.count; c++)
        world->gravity[c] = scene->gravity_m_per_s2.value[world_axis(world, c)];
    TRY(kernel_isa_select(&world->isa));
    world->kernels = kernels_select(world->isa, dimension, hysteretic, frictional, single);
    TRY(particles_init(&world->particles, (int)scene->sample.count, dimension, frictional, single));
    world->pairs.hysteretic = hysteretic;
    world->pairs.single = single;
    world->pairs.n_springs = world->particles.n_rotations;
    name_walls(world);
    return STATUS_OK;
}

static enum status create_and(struct world **world, const struct scene *scene, enum status (*fill)(struct world *world))
{
    *world = calloc(1, sizeof **world);
    if (!*world)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = model(*world, scene);
    if (status == STATUS_OK && fill)
        status = fill(*world);
    if (status != STATUS_OK) {
        world_free(*world);
        *world = NULL;
    }
    return status;
}

enum status world_init_lists(struct world *world)
{
    TRY(neighbor_init(&world->neighbor, &world->particles, world->scene->neighbor.skin_ratio, world->pairs.hysteretic,
                      world->isa));
    TRY(threads_init(&world->threads, &world->particles, world->scene->threads));
    threads_cut(&world->threads, &world->particles, &world->pairs);
    world->neighbor.renumber_steps = renumber_interval(world->scene->neighbor.renumber_steps, world->particles.count);
    return STATUS_OK;
}

enum status world_build_lists(struct world *world)
{
    TRY(neighbor_build(&world->neighbor, &world->particles, &world->pairs, world->walls, world->n_walls));
    threads_cut(&world->threads, &world->particles, &world->pairs);
    return STATUS_OK;
}

enum status world_close_lists(struct world *world)
{
    TRY(contact_list_close(&world->pairs, &world->particles, NULL));
    for (int w = 0; w < world->n_walls; w++)
        TRY(contact_list_close(&world->walls[w].contacts, &world->particles, &world->walls[w]));
    return STATUS_OK;
}

static enum status fill_sample(struct world *world)
{
    double lo[3], hi[3];
    if (world->scene->sample.initial == INITIAL_CHECKPOINT) {
        TRY(checkpoint_start(world->scene->sample.checkpoint, world));
    } else {
        TRY(particles_place(&world->particles, world->scene, lo, hi));
        place_walls(world, lo, hi);
    }
    for (int w = 0; w < world->n_walls; w++)
        world->path.x0[w] = world->walls[w].x;
    TRY(world_init_lists(world));
    return world_build_lists(world);
}

enum status world_create_empty(struct world **world, const struct scene *scene)
{
    return create_and(world, scene, NULL);
}

enum status world_create(struct world **world, const struct scene *scene)
{
    return create_and(world, scene, fill_sample);
}

void world_free(struct world *world)
{
    if (!world)
        return;
    particles_free(&world->particles);
    contact_list_free(&world->pairs);
    for (int w = 0; w < world->n_walls; w++)
        contact_list_free(&world->walls[w].contacts);
    neighbor_free(&world->neighbor);
    threads_free(&world->threads);
    free(world);
}

static void ledger_start(struct world *world)
{
    memset(&world->ledger, 0, sizeof world->ledger);
    struct held_energy held = measure_held_energy(world);
    world->ledger.kinetic_start = held.kinetic_j;
    world->ledger.elastic_start = held.elastic_j;
    world->ledger.potential_start = measure_potential_energy_j(world);
}

void world_set_law(struct world *world)
{
    world->material = world->stage < 0 ? NULL : &world->scene->stage[world->stage].material;
    if (world->material) {
        world->law = contact_law_constants_of(world->material);
        interface_set_law(world);
    }
}

static void stage_start(struct world *world, int stage)
{
    world_settle(world);
    const struct scene_stage *next = &world->scene->stage[stage];
    world->stage = stage;
    world->stage_step = 0;
    world->stage_time_start_s = world->time_s;
    world->dt = next->dt_s;
    world_set_law(world);
    for (int w = 0; w < world->n_walls; w++)
        world->stage_position_m[w] = world->walls[w].x;
    integrate_forces_anew(world);
    ledger_start(world);
    interface_stage_start(world);
}

enum status world_command(struct world *world, const struct wall_command *command)
{
    if (command->step != world->step || command->n_walls != world->n_walls || command->n_steps < 1)
        return status_fail(STATUS_FORMAT, "step %lld: a command for step %lld, %d walls, %d steps does not fit",
                           (long long)world->step, (long long)command->step, command->n_walls, command->n_steps);
    if (command->stage < 0 || command->stage >= world->scene->n_stages || command->stage < world->stage)
        return status_fail(STATUS_FORMAT, "step %lld: a command for stage %d does not fit stage %d",
                           (long long)world->step, command->stage, world->stage);
    interface_close(world, command);
    if (command->stage != world->stage)
        stage_start(world, command->stage);
    interface_open(world);
    drive_command(world, command);
    return STATUS_OK;
}

void world_wall_state(const struct world *world, struct wall_state *state)
{
    const struct wall_path *path = &world->path;
    const struct interface *face = &world->interface;
    memset(state, 0, sizeof *state);
    state->step = world->step;
    state->time_s = world->time_s;
    state->stage = world->stage;
    state->stage_step = world->stage_step;
    state->stage_time_s = world->stage < 0 ? 0 : (double)world->stage_step * world->dt;
    state->interval_s = path->n_steps * path->dt;
    state->command_step = world->step;
    state->interface_residual_j = face->residual_j;
    state->interface_error = face->error;
    state->interface_error_before = face->error_before;
    state->n_walls = world->n_walls;
    for (int w = 0; w < world->n_walls; w++) {
        const struct wall *wall = &world->walls[w];
        state->position_m[w] = wall->x;
        state->velocity_m_per_s[w] = drive_mean_velocity_m_per_s(world, w);
        state->force_before_n[w] = face->force_start[w];
        state->force_n[w] = wall->force;
        state->stage_position_m[w] = world->stage_position_m[w];
    }
    memcpy(state->ahead_position_m, state->position_m, sizeof state->ahead_position_m);
    memcpy(state->ahead_velocity_m_per_s, state->velocity_m_per_s, sizeof state->ahead_velocity_m_per_s);
    measure_wall_stiffness(world, state->stiffness_n_per_m, state->damping_kg_per_s);
}

void world_wall_state_ahead(const struct world *world, struct wall_state *state)
{
    if (world->stage_step == 0) /* the stage began meanwhile */
        world_wall_state(world, state);
    state->command_step = world->path.from_step + world->path.n_steps;
    for (int w = 0; w < world->n_walls; w++) {
        state->ahead_position_m[w] = drive_end_position_m(world, w);
        state->ahead_velocity_m_per_s[w] = drive_mean_velocity_m_per_s(world, w);
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

uint64_t world_hash(const struct world *world)
{
    world_settle(world);
    const struct particles *p = &world->particles;
    uint64_t hash = 0xcbf29ce484222325u;
    for (int c = 0; c < p->dimension; c++) {
        hash = hash_values(hash, p, p->x[c]);
        hash = hash_values(hash, p, p->v[c]);
    }
    for (int c = 0; c < p->n_rotations; c++)
        hash = hash_values(hash, p, p->omega[c]);
    for (int w = 0; w < world->n_walls; w++) {
        hash = hash_bytes(hash, &world->walls[w].x, sizeof(double));
        hash = hash_bytes(hash, &world->walls[w].v, sizeof(double));
    }
    return hash;
}
