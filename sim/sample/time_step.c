/* Velocity Verlet with predicted velocities. With x, v, a at step k:
 *   drift  v(k+1/2) = v + a dt/2,   x(k+1) = x + v(k+1/2) dt,   v* = v(k+1/2) + a dt/2
 *   forces from x(k+1), v*  ->  a(k+1)
 *   kick   v(k+1) = v(k+1/2) + a(k+1) dt/2
 * v* is second order accurate, so forces that depend on velocity keep the scheme at second order, and positions,
 * velocities, rotations and tangential springs are all taken at the same time. */
#include "sim/sample/time_step.h"

#include <math.h>

#include "sim/neighbours/locality_order.h"
#include "sim/sample/coupling_audit.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/wall_motion.h"

/* The walls' forces, which the loops of the walls wait for. Rows of the sums start with them. */
static void wall_forces(struct sample *sample, double dt)
{
    struct contact_losses lost = {0};
    threads_walls(&sample->threads, &sample->kernels, &sample->particles, sample->walls, sample->n_walls,
                  sample->wall_law, dt, &lost);
    contact_losses_add(&sample->ledger.contacts, &lost);
}

/* What is left of the last step, and the drift of this one. */
static bool drift(struct sample *sample)
{
    const double reach = 0.5 * sample->verlet.skin;
    if (!sample->open)
        return threads_drift(&sample->threads, &sample->kernels, &sample->particles, sample->dt, sample->kicked_s,
                             reach);
    struct kick_constants constants = step_kick_constants(sample, sample->dt);
    const struct threads_sweep sweep = {.law = &sample->law, .kick = &constants, .dt_s = sample->dt, .reach_m = reach};
    struct contact_losses lost = {0};
    double background_w;
    bool far = threads_sweep(&sample->threads, &sample->kernels, &sample->particles, &sample->pairs, &sweep, &lost,
                             &background_w);
    sample->open = false;
    contact_losses_add(&sample->ledger.contacts, &lost);
    sample->ledger.background += sample->dt * background_w;
    return far;
}

void time_step_forces_anew(struct sample *sample)
{
    particles_import_state(&sample->particles);
    sample->kicked_s = 0;
    (void)threads_drift(&sample->threads, &sample->kernels, &sample->particles, 0, 0, INFINITY);
    wall_forces(sample, 0);
    step_pair_forces(sample, 0);
    step_kick(sample, 0);
}

/* Finds what the lists could not cope with; walls and particles may overlap, but not pass each other. */
static enum status check_inside(const struct sample *sample)
{
    const struct particles *particles = &sample->particles;
    const long long step = sample->step;
    for (int c = 0; c < particles->dimension; c++) {
        const double lo = sample->walls[2 * c].x, hi = sample->walls[2 * c + 1].x, *x = particles->x[c];
        const char axis = "xyz"[sample_axis(sample, c)];
        if (!(hi > lo))
            return status_fail(STATUS_UNSTABLE, "step %lld (t = %g s): the walls in %c have passed each other", step,
                               sample->time_s, axis);
        for (int i = 0; i < particles->count; i++) {
            if (x[i] > lo - particles->radius[i] && x[i] < hi + particles->radius[i])
                continue;
            return status_fail(
                STATUS_UNSTABLE,
                "step %lld (t = %g s): particle %d left the box in %c (at %g m, walls at %g and %g m); a "
                "smaller dt_s or exchange interval, less pressure, or a heavier wall, would help",
                step, sample->time_s, particles->id[i], axis, x[i], lo, hi);
        }
    }
    return STATUS_OK;
}

/* Mixed precision: positions are integers that hold a few skins (particles.h). STATUS_LIMIT if a step may take a
 * particle beyond them. */
static enum status check_integers(const struct sample *sample)
{
    const struct particles *p = &sample->particles;
    const double holds = sample->verlet.skin / sample->dt;
    for (int c = 0; p->mixed && c < p->dimension; c++)
        for (int i = 0; i < p->count; i++)
            if (!(fabs(particles_velocity(p, c, i)) <= holds))
                return status_fail(STATUS_LIMIT,
                                   "step %lld (t = %g s): precision \"mixed\" holds steps of at most the skin of the "
                                   "lists, %.2g m; particle %d moves %.2g m in one. neighbor.skin_ratio = 0 (tuned) or "
                                   "a smaller dt_s would help, and so would precision \"double\"",
                                   (long long)sample->step, sample->time_s, sample->verlet.skin, p->id[i],
                                   fabs(particles_velocity(p, c, i)) * sample->dt);
    return STATUS_OK;
}

static enum status renew_lists(struct sample *sample)
{
    struct verlet_list *verlet = &sample->verlet;
    particles_export_positions(&sample->particles);
    TRY(check_inside(sample));
    TRY(check_integers(sample));
    verlet_list_tune(verlet, &sample->particles, sample->walls, sample->n_walls, sample->step);
    sample->pairs.search_max = verlet_list_search_max(verlet, sample->step);
    verlet->built_step = sample->step;
    return sample_build_lists(sample);
}

/* Puts the particles into a new order when it is due. The state is complete: nothing of the step has been done. */
static enum status renew_order(struct sample *sample)
{
    const int64_t every = sample->verlet.renumber_steps;
    if (every == 0 || sample->step % every != 0)
        return STATUS_OK;
    (void)sample_complete(sample);
    TRY(locality_order_apply(&sample->particles, &sample->pairs, sample->walls, sample->n_walls));
    return renew_lists(sample);
}

enum status sample_step(struct sample *sample)
{
    TRY(sample_step_open(sample));
    (void)sample_complete(sample);
    return STATUS_OK;
}

enum status sample_step_open(struct sample *sample)
{
    double force_before[SCENE_WALLS_MAX], x_before[SCENE_WALLS_MAX];
    for (int w = 0; w < sample->n_walls; w++) {
        force_before[w] = sample->walls[w].force;
        x_before[w] = sample->walls[w].x;
    }
    if (sample->stage_step == 0)
        TRY(check_integers(sample));
    TRY(renew_order(sample));
    sample->step++;
    sample->stage_step++;
    sample->time_s = sample->stage_time_start_s + (double)sample->stage_step * sample->dt;
    bool stale = drift(sample);
    stale = walls_move(sample) || stale;
    stale =
        stale || verlet_list_is_wide(&sample->verlet, &sample->particles, sample->walls, sample->n_walls, sample->step);
    if (stale)
        TRY(renew_lists(sample));
    wall_forces(sample, sample->dt);
    sample->open = true;
    sample->kicked_s = sample->dt;
    return coupling_audit_step(sample, x_before, force_before);
}
