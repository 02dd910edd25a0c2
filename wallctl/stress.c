#include "wallctl/stress.h"

#include <math.h>

/* The force that the sample answers a change of velocity with over half an interval acts like a mass on the wall. With
 * the stiffness as an upper bound this is stable for any interval: K H/gamma < 2 coth(gamma H/2m) holds for
 * m >= K H^2/4. A delayed answer needs more: eight times that was the least without oscillations in scene A
 * (docs/coupling.md). */
static double added_mass_kg(int scheme, const struct stress_loop *loop, double apart_s)
{
    const double factor = scheme == SCHEME_PIPELINED ? 2 : 0.25;
    if (scheme == SCHEME_HOLD)
        return 0;
    return apart_s * (factor * loop->stiffness_n_per_m * apart_s + 0.5 * loop->contact_damping_kg_per_s);
}

struct stress_motion stress_motion(int scheme, const struct stress_loop *loop)
{
    const double net_n = loop->force_n - loop->target_n, last = loop->velocity_m_per_s;
    struct stress_motion result = {.force_n = loop->force_n};
    if (loop->one_step) {
        result.motion = wall_motion_step(loop->mass_kg, loop->damping_kg_per_s, loop->last_interval_s, loop->interval_s,
                                         last, net_n);
        return result;
    }
    double apart_s = 0.5 * (loop->last_interval_s + loop->interval_s);
    double added_kg = added_mass_kg(scheme, loop, apart_s);
    double velocity = wall_velocity_after(loop->mass_kg + added_kg, loop->damping_kg_per_s, apart_s, last, net_n);
    result.motion.velocity_m_per_s = velocity;
    result.force_n -= added_kg * (velocity - last) / apart_s;
    return result;
}

/* Whether a disturbance of a wall on the spring and damper does not grow, n steps per interval: its largest energy over
 * the last intervals against the first. */
static bool is_stable(int scheme, const struct stress_loop *bounds, double dt_s, int n)
{
    enum { INTERVALS = 400, WINDOW = 100 };
    const double h = n * dt_s, k = bounds->stiffness_n_per_m, g = bounds->contact_damping_kg_per_s;
    struct stress_loop loop = *bounds;
    double x = h, force_before = 0, first = 0, last = 0;
    loop.last_interval_s = loop.interval_s = h;
    loop.one_step = n == 1;
    loop.velocity_m_per_s = 1;
    loop.target_n = 0;
    for (int i = 0; i < INTERVALS; i++) {
        double force = -k * x - g * loop.velocity_m_per_s, next = loop.velocity_m_per_s;
        loop.force_n = scheme == SCHEME_PIPELINED ? 2 * force - force_before : force;
        if (scheme == SCHEME_PIPELINED) /* this interval runs on the command in hand */
            x += h * next;
        struct wall_motion motion = stress_motion(scheme, &loop).motion;
        next = motion.velocity_m_per_s + 0.5 * h * motion.acceleration_m_per_s2;
        if (scheme != SCHEME_PIPELINED)
            x += h * next;
        loop.velocity_m_per_s = next;
        force_before = force;
        double energy = k * x * x + bounds->mass_kg * next * next;
        if (i < WINDOW)
            first = fmax(first, energy);
        else if (i >= INTERVALS - WINDOW)
            last = fmax(last, energy);
        if (!isfinite(energy))
            return false;
    }
    return last <= 1.1 * first;
}

int stress_stable_steps(int scheme, const struct stress_loop *loop, double dt_s, int limit)
{
    int stable = 0, beyond = limit + 1;
    for (int n = 1; n <= limit && stable == n / 2; n *= 2)
        if (is_stable(scheme, loop, dt_s, n))
            stable = n;
        else
            beyond = n;
    if (stable == 0)
        return 0;
    while (beyond - stable > 1) {
        int n = stable + (beyond - stable) / 2;
        if (is_stable(scheme, loop, dt_s, n))
            stable = n;
        else
            beyond = n;
    }
    return stable;
}
