/* Velocity Verlet with predicted velocities. With x, v, a at step k:
 *   drift  v(k+1/2) = v + a dt/2,   x(k+1) = x + v(k+1/2) dt,   v* = v(k+1/2) + a dt/2
 *   forces from x(k+1), v*  ->  a(k+1)
 *   kick   v(k+1) = v(k+1/2) + a(k+1) dt/2
 * v* is second order accurate, so forces that depend on velocity keep the scheme at second order, and positions,
 * velocities, rotations and tangential springs are all taken at the same time. */
#include "sim/integrate.h"

#include <math.h>
#include <string.h>

#include "sim/drive.h"
#include "sim/renumber.h"

/* The walls' forces, which the loops of the walls wait for. Rows of the sums start with them. */
static void wall_forces(struct world *world, double dt)
{
    struct contact_losses lost = {0};
    world->law.dt = dt;
    struct contact_law_constants of_walls = world->law;
    of_walls.mu_s *= world->material->wall_friction;
    of_walls.mu_d *= world->material->wall_friction;
    for (int w = 0; w < world->n_walls; w++)
        world->kernels.wall(&world->particles, &world->walls[w], &of_walls, &lost);
    contact_losses_add(&world->ledger.contacts, &lost);
}

static void pair_forces(struct world *world)
{
    struct contact_losses lost = {0};
    threads_pair(&world->threads, &world->kernels, &world->particles, &world->pairs, &world->law, &lost);
    contact_losses_add(&world->ledger.contacts, &lost);
}

static struct kick_constants kick_constants_of(const struct world *world, double dt)
{
    struct kick_constants constants = {
        .dt = dt, .gamma_b = world->material->gamma_b_kg_per_s, .gamma_br = world->material->gamma_br_kg_per_s};
    memcpy(constants.gravity, world->gravity, sizeof constants.gravity);
    return constants;
}

static void kick(struct world *world, double dt)
{
    struct kick_constants constants = kick_constants_of(world, dt);
    world->ledger.background += dt * threads_kick(&world->threads, &world->kernels, &world->particles, &constants);
}

void world_settle(const struct world *world)
{
    struct world *changed = (struct world *)(uintptr_t)world; /* how far a step is, is no part of the state */
    if (!world->open)
        return;
    changed->open = false;
    pair_forces(changed);
    kick(changed, world->dt);
    particles_locate(&changed->particles);
}

/* What is left of the last step, and the drift of this one. */
static bool drift(struct world *world)
{
    const double reach = 0.5 * world->neighbor.skin;
    if (!world->open)
        return threads_drift(&world->threads, &world->kernels, &world->particles, world->dt, world->kicked_s, reach);
    struct kick_constants constants = kick_constants_of(world, world->dt);
    const struct threads_sweep sweep = {.law = &world->law, .kick = &constants, .dt_s = world->dt, .reach_m = reach};
    struct contact_losses lost = {0};
    double background_w;
    bool far =
        threads_sweep(&world->threads, &world->kernels, &world->particles, &world->pairs, &sweep, &lost, &background_w);
    world->open = false;
    contact_losses_add(&world->ledger.contacts, &lost);
    world->ledger.background += world->dt * background_w;
    return far;
}

void integrate_forces_anew(struct world *world)
{
    particles_enter(&world->particles);
    world->kicked_s = 0;
    (void)threads_drift(&world->threads, &world->kernels, &world->particles, 0, 0, INFINITY);
    wall_forces(world, 0);
    pair_forces(world);
    kick(world, 0);
}

/* Finds what the lists could not cope with; walls and particles may overlap, but not pass each other. */
static enum status check_inside(const struct world *world)
{
    const struct particles *particles = &world->particles;
    const long long step = world->step;
    for (int c = 0; c < particles->dimension; c++) {
        const double lo = world->walls[2 * c].x, hi = world->walls[2 * c + 1].x, *x = particles->x[c];
        const char axis = "xyz"[world_axis(world, c)];
        if (!(hi > lo))
            return status_fail(STATUS_UNSTABLE, "step %lld (t = %g s): the walls in %c have passed each other", step,
                               world->time_s, axis);
        for (int i = 0; i < particles->count; i++) {
            if (x[i] > lo - particles->radius[i] && x[i] < hi + particles->radius[i])
                continue;
            return status_fail(
                STATUS_UNSTABLE,
                "step %lld (t = %g s): particle %d left the box in %c (at %g m, walls at %g and %g m); a "
                "smaller dt_s or exchange interval, or a heavier wall, would help",
                step, world->time_s, particles->id[i], axis, x[i], lo, hi);
        }
    }
    return STATUS_OK;
}

static enum status renew_lists(struct world *world)
{
    struct neighbor *neighbor = &world->neighbor;
    particles_locate(&world->particles);
    TRY(check_inside(world));
    neighbor_tune(neighbor, &world->particles, world->walls, world->n_walls, world->step);
    world->pairs.search_max = neighbor_search_max(neighbor, world->step);
    neighbor->built_step = world->step;
    return world_build_lists(world);
}

/* Puts the particles into a new order when it is due. The state is complete: nothing of the step has been done. */
static enum status renew_order(struct world *world)
{
    const int64_t every = world->neighbor.renumber_steps;
    if (every == 0 || world->step % every != 0)
        return STATUS_OK;
    world_settle(world);
    TRY(renumber(&world->particles, &world->pairs, world->walls, world->n_walls));
    return renew_lists(world);
}

enum status world_step(struct world *world)
{
    TRY(world_step_open(world));
    world_settle(world);
    return STATUS_OK;
}

enum status world_step_open(struct world *world)
{
    double force_before[SCENE_WALLS_MAX], x_before[SCENE_WALLS_MAX];
    for (int w = 0; w < world->n_walls; w++) {
        force_before[w] = world->walls[w].force;
        x_before[w] = world->walls[w].x;
    }
    TRY(renew_order(world));
    world->step++;
    world->stage_step++;
    world->time_s = world->stage_time_start_s + (double)world->stage_step * world->dt;
    bool stale = drift(world);
    stale = drive_walls(world) || stale;
    stale = stale || neighbor_is_wide(&world->neighbor, &world->particles, world->walls, world->n_walls, world->step);
    if (stale)
        TRY(renew_lists(world));
    wall_forces(world, world->dt);
    world->open = true;
    world->kicked_s = world->dt;
    return interface_step(world, x_before, force_before);
}
