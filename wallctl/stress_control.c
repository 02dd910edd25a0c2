#include "wallctl/stress_control.h"

#include <float.h>
#include <math.h>

#include "common/coupling.h"

/* compensated: the lag of the added mass's acceleration behind the wall's, in units of added mass over damping. With a
 * lag of 1 it gives back at most the energy that the wall's damping takes, at any frequency; sampled once an interval,
 * contacts as stiff as the bound need 1.3. Asked for ahead, by up to half an interval, particles that answer late make
 * it need more mass as well, for their stiffness and above all for their damping (docs/coupling.md,
 * test_sim_coupling). */
static const double LAG = 1.5, LAG_AHEAD = 2.25, STIFF_AHEAD = 3, DAMPED_AHEAD = 4;

/* The force that the sample answers a change of velocity with over half an interval acts like a mass on the wall. With
 * the stiffness as an upper bound this is stable for any interval: K H/gamma < 2 coth(gamma H/2m) holds for
 * m >= K H^2/4. A delayed answer needs more: eight times that was the least without oscillations in scene A
 * (docs/coupling.md). */
static double added_mass_kg(int scheme, const struct stress_loop *loop, double apart_s)
{
    const bool ahead = loop->ahead_s > 0;
    const double stiff = scheme == SCHEME_PIPELINED ? 2 : ahead ? 0.25 * STIFF_AHEAD : 0.25;
    const double damped = ahead ? 0.5 * DAMPED_AHEAD : 0.5;
    if (scheme == SCHEME_HOLD)
        return 0;
    return apart_s * (stiff * loop->stiffness_n_per_m * apart_s + damped * loop->contact_damping_kg_per_s);
}

/* The mass M of v+ = v- + (F - p A - gamma v-) T/M when the damping is exactly integrated. */
static double inertia_kg(double mass_kg, double damping_kg_per_s, double t_s)
{
    const double x = damping_kg_per_s * t_s / mass_kg;
    if (x < 0.25 * DBL_EPSILON)
        return mass_kg;
    return damping_kg_per_s * t_s / -expm1(-x);
}

/* jacobian, with the added mass moving along: only what the wall's acceleration differs from that of the added mass
 * meets resistance. That acceleration follows the wall's with a lag; it is the slope of the velocity within the
 * intervals, and so what sim says about the last one. Added is all that is beyond m + gamma T/2, the inertia of the
 * midpoint rule, which is centred where the force is. */
static struct stress_motion motion_compensated(const struct stress_loop *loop, double apart_s)
{
    const double damping = loop->damping_kg_per_s, last = loop->velocity_m_per_s;
    const double before = loop->acceleration_m_per_s2;
    const double net_n = loop->force_n - loop->target_n - damping * last;
    const double bound_kg = loop->mass_kg + added_mass_kg(SCHEME_COMPENSATED, loop, apart_s);
    const double total_kg = inertia_kg(bound_kg, damping, apart_s);
    const double added_kg = fmax(0, total_kg - loop->mass_kg - 0.5 * damping * apart_s);
    const double acceleration = (net_n + added_kg * before) / total_kg;
    const double lag = loop->ahead_s > 0 ? LAG_AHEAD : LAG;
    const double follows = added_kg > 0 ? -expm1(-damping * apart_s / (lag * added_kg)) : 1;
    const double slope = before + follows * (acceleration - before);
    const double velocity = last + apart_s * acceleration;
    return (struct stress_motion){.motion = {velocity - 0.5 * slope * loop->interval_s, slope},
                                  .force_n = loop->force_n - added_kg * (acceleration - before)};
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
    if (scheme == SCHEME_COMPENSATED)
        return motion_compensated(loop, apart_s);
    double added_kg = added_mass_kg(scheme, loop, apart_s);
    double velocity = wall_velocity_after(loop->mass_kg + added_kg, loop->damping_kg_per_s, apart_s, last, net_n);
    result.motion.velocity_m_per_s = velocity;
    result.force_n -= added_kg * (velocity - last) / apart_s;
    return result;
}

double stress_force_ahead_n(double before_n, double now_n, double part)
{
    return now_n + part * (now_n - before_n);
}

/* A wall on a spring and a damper, in intervals of h. */
struct spring_trial {
    double h, ahead_s; /* a command is asked for so long before its interval */
    double x, velocity, acceleration;
    double force_before; /* at the start of the interval */
};

/* The force at t in the interval that began at trial->x. */
static double spring_force(const struct spring_trial *trial, const struct stress_loop *bounds, double t)
{
    const double v = trial->velocity + (t - 0.5 * trial->h) * trial->acceleration;
    const double x = trial->x + t * (trial->velocity + 0.5 * (t - trial->h) * trial->acceleration);
    return -bounds->stiffness_n_per_m * x - bounds->contact_damping_kg_per_s * v;
}

/* The force that is expected for the end of the interval, from those where it began and where the command was asked
 * for; pipelined: from those where this one and the last began. */
static double force_expected(struct spring_trial *trial, const struct stress_loop *bounds)
{
    const double before = trial->force_before, asked_s = trial->h - trial->ahead_s;
    const double start = spring_force(trial, bounds, 0), asked = spring_force(trial, bounds, asked_s);
    trial->force_before = start;
    if (asked_s <= 0)
        return stress_force_ahead_n(before, start, 1);
    return stress_force_ahead_n(start, asked, trial->ahead_s / asked_s);
}

/* Whether a disturbance of a wall on the spring and damper does not grow, n steps per interval: its largest energy over
 * the last intervals against the first. */
static bool is_stable(const struct scene_coupling *coupling, const struct stress_loop *bounds, double dt_s, int n)
{
    enum { INTERVALS = 400, WINDOW = 100 };
    const double h = n * dt_s, ahead_s = coupling_ahead_steps(coupling, n) * dt_s;
    struct spring_trial trial = {.h = h, .ahead_s = ahead_s, .velocity = 1};
    struct stress_loop loop = *bounds;
    double first = 0, last = 0;
    loop.last_interval_s = loop.interval_s = h;
    loop.ahead_s = ahead_s;
    loop.one_step = n == 1;
    loop.target_n = 0;
    for (int i = 0; i < INTERVALS; i++) {
        loop.force_n = force_expected(&trial, bounds);
        loop.velocity_m_per_s = trial.velocity;
        loop.acceleration_m_per_s2 = trial.acceleration;
        const struct wall_motion motion = stress_motion(coupling->scheme, &loop).motion;
        trial.x += h * trial.velocity;
        trial.velocity = motion.velocity_m_per_s + 0.5 * h * motion.acceleration_m_per_s2;
        trial.acceleration = motion.acceleration_m_per_s2;
        double energy =
            bounds->stiffness_n_per_m * trial.x * trial.x + bounds->mass_kg * trial.velocity * trial.velocity;
        if (i < WINDOW)
            first = fmax(first, energy);
        else if (i >= INTERVALS - WINDOW)
            last = fmax(last, energy);
        if (!isfinite(energy))
            return false;
    }
    return last <= 1.1 * first;
}

int stress_stable_steps(const struct scene_coupling *coupling, const struct stress_loop *loop, double dt_s, int limit)
{
    int stable = 0, beyond = limit + 1;
    for (int n = 1; n <= limit && stable == n / 2; n *= 2)
        if (is_stable(coupling, loop, dt_s, n))
            stable = n;
        else
            beyond = n;
    if (stable == 0)
        return 0;
    while (beyond - stable > 1) {
        int n = stable + (beyond - stable) / 2;
        if (is_stable(coupling, loop, dt_s, n))
            stable = n;
        else
            beyond = n;
    }
    return stable;
}
