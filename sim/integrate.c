/* Velocity Verlet with predicted velocities. With x, v, a at step k:
 *   drift  x(k+1) = x + v dt + a dt^2/2,   v* = v + a dt
 *   forces from x(k+1), v*  ->  a(k+1)
 *   kick   v(k+1) = v* + (a(k+1) - a) dt/2 = v + (a + a(k+1)) dt/2
 * v* is second order accurate, so forces that depend on velocity keep the scheme at second order, and positions,
 * velocities, rotations and tangential springs are all taken at the same time. */
#include "sim/integrate.h"

#include <math.h>

static void drift(struct particles *p, double dt)
{
    const int count = p->count;
    const double half = 0.5 * dt;
    for (int c = 0; c < p->dimension; c++) {
        double *restrict x = p->x[c], *restrict v = p->v[c];
        const double *restrict a = p->a[c];
        for (int i = 0; i < count; i++) {
            x[i] += dt * (v[i] + half * a[i]);
            v[i] += dt * a[i];
        }
    }
    for (int c = 0; c < p->n_rotations; c++) {
        double *restrict omega = p->omega[c];
        const double *restrict alpha = p->alpha[c];
        for (int i = 0; i < count; i++)
            omega[i] += dt * alpha[i];
    }
}

/* Adds background damping and gravity, turns forces into accelerations, corrects the velocities, and returns the
 * energy that the background took in the step [J]. */
static double kick(struct world *world, double dt)
{
    struct particles *p = &world->particles;
    const double half = 0.5 * dt, gamma_b = world->material->gamma_b_kg_per_s;
    const double gamma_br = world->material->gamma_br_kg_per_s;
    const int count = p->count;
    double background = 0;
    for (int c = 0; c < p->dimension; c++) {
        double *restrict v = p->v[c], *restrict a = p->a[c];
        const double *restrict force = p->force[c], *restrict inv_mass = p->inv_mass;
        const double g = world->gravity[c];
        double sum = 0;
        for (int i = 0; i < count; i++) {
            double now = (force[i] - gamma_b * v[i]) * inv_mass[i] + g;
            sum += v[i] * v[i];
            v[i] += half * (now - a[i]);
            a[i] = now;
        }
        background += gamma_b * sum;
    }
    for (int c = 0; c < p->n_rotations; c++) {
        double *restrict omega = p->omega[c], *restrict alpha = p->alpha[c];
        const double *restrict torque = p->torque[c], *restrict inv_inertia = p->inv_inertia, *restrict a = p->radius;
        double sum = 0;
        for (int i = 0; i < count; i++) {
            double damping = gamma_br * a[i] * a[i];
            double now = (torque[i] - damping * omega[i]) * inv_inertia[i];
            sum += damping * omega[i] * omega[i];
            omega[i] += half * (now - alpha[i]);
            alpha[i] = now;
        }
        background += sum;
    }
    return background * dt;
}

static void forces(struct world *world, double dt)
{
    struct contact_losses lost = {0};
    world->law.dt = dt;
    world->kernels.pair(&world->particles, &world->pairs, &world->law, &lost);
    for (int w = 0; w < world->n_walls; w++)
        world->kernels.wall(&world->particles, &world->walls[w], &world->law, &lost);
    contact_losses_add(&world->ledger.contacts, &lost);
    neighbor_sum_forces(&world->particles, &world->pairs, world->walls, world->n_walls);
}

void integrate_forces_anew(struct world *world)
{
    forces(world, 0);
    kick(world, 0);
}

/* Moves the walls along their path to the current step. */
static void move_walls(struct world *world)
{
    const struct wall_path *path = &world->path;
    double t = (double)(world->step - path->from_step) * path->dt;
    for (int w = 0; w < world->n_walls; w++) {
        world->walls[w].x = path->x0[w] + t * (path->v0[w] + 0.5 * t * path->a0[w]);
        world->walls[w].v = path->v0[w] + t * path->a0[w];
    }
}

/* Finds what the lists could not cope with; walls and particles may overlap, but not pass each other. */
static enum status check_inside(const struct world *world)
{
    const struct particles *p = &world->particles;
    for (int c = 0; c < p->dimension; c++) {
        double lo = world->walls[2 * c].x, hi = world->walls[2 * c + 1].x;
        if (!(hi > lo))
            return status_fail(STATUS_UNSTABLE, "step %lld (t = %g s): the walls in %c have passed each other",
                               (long long)world->step, world->time_s, "xyz"[world_axis(world, c)]);
        for (int i = 0; i < p->count; i++)
            if (!(p->x[c][i] > lo - p->radius[i] && p->x[c][i] < hi + p->radius[i]))
                return status_fail(STATUS_UNSTABLE,
                                   "step %lld (t = %g s): particle %d left the box in %c (at %g m, walls at %g and %g m); "
                                   "a smaller dt_s or exchange interval, or a heavier wall, would help",
                                   (long long)world->step, world->time_s, i, "xyz"[world_axis(world, c)], p->x[c][i],
                                   lo, hi);
    }
    return STATUS_OK;
}

static enum status renew_lists(struct world *world)
{
    TRY(check_inside(world));
    return neighbor_build(&world->neighbor, &world->particles, &world->pairs, world->walls, world->n_walls);
}

enum status world_step(struct world *world)
{
    double force_before[SCENE_WALLS_MAX], x_before[SCENE_WALLS_MAX];
    for (int w = 0; w < world->n_walls; w++) {
        force_before[w] = world->walls[w].force;
        x_before[w] = world->walls[w].x;
    }
    world->step++;
    world->stage_step++;
    world->time_s = world->stage_time_start_s + (double)world->stage_step * world->dt;
    drift(&world->particles, world->dt);
    move_walls(world);
    if (neighbor_is_stale(&world->neighbor, &world->particles, world->walls, world->n_walls))
        TRY(renew_lists(world));
    forces(world, world->dt);
    world->ledger.background += kick(world, world->dt);
    /* trapezoidal rule; `inward` points into the box, the force outward */
    for (int w = 0; w < world->n_walls; w++)
        world->ledger.work_walls += 0.5 * (force_before[w] + world->walls[w].force) * world->walls[w].inward *
                                    (world->walls[w].x - x_before[w]);
    return STATUS_OK;
}
