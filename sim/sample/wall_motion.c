#include "sim/sample/wall_motion.h"

#include <math.h>
#include <string.h>

#include "common/wall_dynamics.h"

double walls_driving_force_n(const struct wall_trajectory *path, int w, double tau_s)
{
    return path->force[w] + tau_s * (path->force_rate[w] + 0.5 * tau_s * path->force_rate2[w]);
}

static bool has_impedance(const struct wall_trajectory *path, int w)
{
    return path->drive[w] == DRIVE_IMPEDANCE || path->drive[w] == DRIVE_IMPEDANCE_MIRROR;
}

void walls_take_command(struct sample *sample, const struct wall_command *command)
{
    struct wall_trajectory *path = &sample->trajectory;
    const size_t bytes = (size_t)sample->n_walls * sizeof(double);
    const bool moved = path->n_steps > 0;
    for (int w = 0; w < sample->n_walls; w++) {
        double t = has_impedance(path, w) ? path->dt : path->n_steps * path->dt;
        path->v_last[w] = path->v0[w] + (t - 0.5 * path->dt) * path->a0[w];
        if (!moved)
            path->v_last[w] = 0;
        path->drive[w] = command->drive[w];
    }
    path->dt_last = moved ? path->dt : 0;
    path->from_step = sample->step;
    path->n_steps = command->n_steps;
    path->dt = sample->dt;
    memcpy(path->x0, command->position_m, bytes);
    memcpy(path->v0, command->velocity_m_per_s, bytes);
    memcpy(path->a0, command->acceleration_m_per_s2, bytes);
    memcpy(path->force, command->force_n, bytes);
    memcpy(path->force_rate, command->force_rate_n_per_s, bytes);
    memcpy(path->force_rate2, command->force_rate2_n_per_s2, bytes);
    memcpy(path->mass, command->mass_kg, bytes);
    memcpy(path->damping, command->damping_kg_per_s, bytes);
}

/* One step of wall w under its impedance; `sign`: of its outward direction. */
static void impedance_step(struct sample *sample, int w, double sign, struct wall_motion motion)
{
    struct wall_trajectory *path = &sample->trajectory;
    path->x0[w] = sample->walls[w].x;
    path->v0[w] = sign * motion.velocity_m_per_s;
    path->a0[w] = sign * motion.acceleration_m_per_s2;
    path->v_last[w] = path->v0[w] + 0.5 * path->dt * path->a0[w];
}

/* The motion over the coming step, outward; `tau` is the time since the command. */
static struct wall_motion impedance_motion(const struct wall_trajectory *path, int w, double dt_last, double tau,
                                           double last_m_per_s, double force_n)
{
    double net_n = force_n - walls_driving_force_n(path, w, tau);
    return wall_motion_step(path->mass[w], path->damping[w], dt_last, path->dt, last_m_per_s, net_n);
}

/* The walls of a pair that have an impedance, from the forces of the step before. */
static void impedance_pair(struct sample *sample, int lo, double dt_last, double tau)
{
    const struct wall_trajectory *path = &sample->trajectory;
    const int hi = lo + 1;
    /* at the start as told to the controller: before a new stage's material */
    const bool first = sample->step == path->from_step + 1;
    const double force_lo = first ? sample->audit.force_told[lo] : sample->walls[lo].force;
    const double force_hi = first ? sample->audit.force_told[hi] : sample->walls[hi].force;
    if (path->drive[hi] == DRIVE_IMPEDANCE_MIRROR) {
        double last = 0.5 * (path->v_last[hi] + -path->v_last[lo]), force = 0.5 * (force_hi + force_lo);
        struct wall_motion motion = impedance_motion(path, hi, dt_last, tau, last, force);
        impedance_step(sample, hi, 1, motion);
        impedance_step(sample, lo, -1, motion);
        return;
    }
    if (path->drive[hi] == DRIVE_IMPEDANCE)
        impedance_step(sample, hi, 1, impedance_motion(path, hi, dt_last, tau, path->v_last[hi], force_hi));
    if (path->drive[lo] == DRIVE_IMPEDANCE)
        impedance_step(sample, lo, -1, impedance_motion(path, lo, dt_last, tau, -path->v_last[lo], force_lo));
}

bool walls_move(struct sample *sample)
{
    struct wall_trajectory *path = &sample->trajectory;
    const int64_t steps = sample->step - path->from_step; /* since the command, with the one that begins here */
    const double dt_last = steps == 1 ? path->dt_last : path->dt;
    bool near = true;
    for (int lo = 0; lo < sample->n_walls; lo += 2)
        impedance_pair(sample, lo, dt_last, (double)(steps - 1) * path->dt);
    for (int w = 0; w < sample->n_walls; w++) {
        double t = has_impedance(path, w) ? path->dt : (double)steps * path->dt;
        sample->walls[w].x = path->x0[w] + t * (path->v0[w] + 0.5 * t * path->a0[w]);
        sample->walls[w].v = path->v0[w] + t * path->a0[w];
        near = near && fabs(sample->walls[w].x - sample->walls[w].x_list) <= 0.5 * sample->verlet.skin;
    }
    return !near;
}

double walls_end_position_m(const struct sample *sample, int w)
{
    const struct wall_trajectory *path = &sample->trajectory;
    const double t = (double)path->n_steps * path->dt;
    if (has_impedance(path, w))
        return sample->walls[w].x + t * sample->walls[w].v;
    return path->x0[w] + t * (path->v0[w] + 0.5 * t * path->a0[w]);
}

double walls_mean_velocity_m_per_s(const struct sample *sample, int w)
{
    const struct wall_trajectory *path = &sample->trajectory;
    if (has_impedance(path, w))
        return path->v_last[w];
    return path->v0[w] + 0.5 * (path->n_steps * path->dt) * path->a0[w];
}

void walls_stiffness(const struct sample *sample, double *stiffness_n_per_m, double *damping_kg_per_s)
{
    for (int w = 0; w < sample->n_walls; w++) {
        stiffness_n_per_m[w] = sample->walls[w].touching * sample->wall_law[w / 2].stiffness;
        damping_kg_per_s[w] = sample->walls[w].touching * sample->wall_law[w / 2].gamma_n;
    }
}
