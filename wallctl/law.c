#include "wallctl/law.h"

#include <float.h>
#include <inttypes.h>
#include <limits.h>
#include <math.h>

#include "wallctl/protocol.h"

static const double PI = 3.14159265358979323846;

/* What the motion of one pair of walls over the coming interval is computed from. */
struct pair_control {
    const struct scene *scene;
    const struct wall_state *state;
    const struct moment *moment;
    const struct scene_axis *axis;
    int lo, hi;             /* indices of its walls */
    double start_s, end_s;  /* the interval, in the time of the stage */
    double interval_s;      /* H */
    double last_interval_s; /* of the interval that ended here; 0: none */
};

/* v(t) = velocity + acceleration t */
struct motion {
    double velocity_m_per_s, acceleration_m_per_s2;
};

double wallctl_target_pressure_pa(const struct scene_axis *axis, double t_s)
{
    switch (axis->target) {
    case TARGET_RAMP:
        if (t_s >= axis->ramp_s)
            return axis->pressure_end_pa;
        return axis->pressure_pa + (axis->pressure_end_pa - axis->pressure_pa) * (t_s / axis->ramp_s);
    case TARGET_COSINE:
        return axis->pressure_pa + 0.5 * axis->amplitude_pa * (1 - cos(2 * PI * t_s / axis->period_s));
    default:
        return axis->pressure_pa;
    }
}

/* Phase omega t of the strain path; pi from its end on. */
static double strain_phase(const struct scene_axis *axis, double t_s)
{
    return fmin(PI, 2 * PI * axis->frequency_hz * t_s);
}

double wallctl_strain_length_m(const struct scene_axis *axis, double z0_m, double t_s)
{
    double zf_m = z0_m * (1 - axis->strain);
    double phase = strain_phase(axis, t_s);
    if (phase >= PI)
        return zf_m;
    return zf_m + 0.5 * (z0_m - zf_m) * (1 + cos(phase));
}

double wallctl_strain_rate_m_per_s(const struct scene_axis *axis, double z0_m, double t_s)
{
    double phase = strain_phase(axis, t_s);
    if (phase >= PI)
        return 0;
    return -0.5 * z0_m * axis->strain * (2 * PI * axis->frequency_hz) * sin(phase);
}

/* Strain control of one wall that takes `share` of the change in length (signed: +1 the upper wall, -1 the lower).
 * Quadratic: the path's rate at the start, its position at the end, so that no error adds up. */
static struct motion strain_motion(const struct pair_control *c, int wall, double share)
{
    const double *start_m = c->moment->stage_position_m;
    double z0_m = start_m[c->hi] - start_m[c->lo];
    if (strain_phase(c->axis, c->start_s) >= PI) /* there: at rest, not chasing the last bit */
        return (struct motion){0, 0};
    double rate = share * wallctl_strain_rate_m_per_s(c->axis, z0_m, c->start_s);
    double end_m = start_m[wall] + share * (wallctl_strain_length_m(c->axis, z0_m, c->end_s) - z0_m);
    double way_m = end_m - c->state->position_m[wall];
    double h = c->interval_s;
    return (struct motion){rate, 2 * (way_m - rate * h) / (h * h)};
}

/* m dv/dt = net - gamma v over the time T, net constant: exact, and so right for m -> 0 and gamma -> 0 as well. */
static double velocity_after(const struct scene_axis *axis, double t_s, double velocity_m_per_s, double net_n)
{
    double mass_kg = axis->mass_kg, gamma_kg_per_s = axis->damping_kg_per_s;
    if (!(mass_kg > 0))
        return net_n / gamma_kg_per_s;
    double x = gamma_kg_per_s * t_s / mass_kg;
    if (x < 0.25 * DBL_EPSILON) /* the limit, to the last bit; below, gamma may be too small to divide by */
        return velocity_m_per_s + net_n * t_s / mass_kg;
    return exp(-x) * velocity_m_per_s - expm1(-x) / gamma_kg_per_s * net_n;
}

/* Stress control [LH eq. 1.2], outward. Staggered leapfrog: mean velocities belong to the middles of the intervals,
 * the force to the moment between them. Over one step the velocity is the straight line through both middles, so that
 * contacts see the wall's velocity with second order; over longer intervals the new mean velocity is held. */
static struct motion stress_motion(const struct pair_control *c, double last_velocity_m_per_s, double force_n,
                                   double pressure_pa)
{
    double apart_s = 0.5 * (c->last_interval_s + c->interval_s);
    double net_n = force_n - pressure_pa * walls_area_m2(c->state, c->hi / 2);
    double velocity = velocity_after(c->axis, apart_s, last_velocity_m_per_s, net_n);
    if (c->scene->coupling.interval_steps != 1)
        return (struct motion){velocity, 0};
    double acceleration = (velocity - last_velocity_m_per_s) / apart_s;
    return (struct motion){velocity - 0.5 * acceleration * c->interval_s, acceleration};
}

static void motion_set(struct wall_command *command, int wall, double sign, struct motion motion)
{
    command->velocity_m_per_s[wall] = sign * motion.velocity_m_per_s;
    command->acceleration_m_per_s2[wall] = sign * motion.acceleration_m_per_s2;
}

static void strain_pair(const struct pair_control *c, struct wall_command *command)
{
    if (c->axis->opposite == OPPOSITE_MIRROR) {
        motion_set(command, c->hi, 1, strain_motion(c, c->hi, 0.5));
        motion_set(command, c->lo, 1, strain_motion(c, c->lo, -0.5));
    } else {
        motion_set(command, c->hi, 1, strain_motion(c, c->hi, 1));
    }
}

static void stress_pair(const struct pair_control *c, struct wall_command *command)
{
    double hi_n = c->state->force_n[c->hi], lo_n = c->state->force_n[c->lo];
    double hi_velocity = c->state->velocity_m_per_s[c->hi], lo_velocity = -c->state->velocity_m_per_s[c->lo];
    double target_pa = wallctl_target_pressure_pa(c->axis, c->start_s);
    if (c->axis->opposite == OPPOSITE_MIRROR) { /* one degree of freedom */
        struct motion motion = stress_motion(c, 0.5 * (hi_velocity + lo_velocity), 0.5 * (hi_n + lo_n), target_pa);
        motion_set(command, c->hi, 1, motion);
        motion_set(command, c->lo, -1, motion);
        return;
    }
    motion_set(command, c->hi, 1, stress_motion(c, hi_velocity, hi_n, target_pa));
    if (c->axis->opposite == OPPOSITE_CONSTANT)
        motion_set(command, c->lo, -1, stress_motion(c, lo_velocity, lo_n, c->axis->pressure_pa));
}

static bool all_finite(const double *values, int count)
{
    for (int k = 0; k < count; k++)
        if (!isfinite(values[k]))
            return false;
    return true;
}

/* Stiffness and damping of the contacts are not used by this law and not checked. */
static bool state_is_finite(const struct wall_state *s)
{
    const double scalars[] = {s->time_s, s->stage_time_s, s->interval_s, s->kinetic_energy_j, s->elastic_energy_j};
    return all_finite(scalars, sizeof scalars / sizeof scalars[0]) && all_finite(s->position_m, s->n_walls) &&
           all_finite(s->velocity_m_per_s, s->n_walls) && all_finite(s->force_n, s->n_walls) &&
           all_finite(s->stage_position_m, s->n_walls);
}

static enum status state_check(const struct scene *scene, const struct wall_state *state)
{
    if (state->n_walls != scene_wall_count(scene))
        return status_fail(STATUS_FORMAT, "the wall state of step %" PRId64 " has %d walls, the scene %d", state->step,
                           state->n_walls, scene_wall_count(scene));
    if (state->stage < -1 || state->stage >= scene->n_stages || state->stage_step < 0)
        return status_fail(STATUS_FORMAT,
                           "the wall state of step %" PRId64 " is in stage %d, step %" PRId64 "; the scene has %" PRId64
                           " stages",
                           state->step, state->stage, state->stage_step, scene->n_stages);
    if (!state_is_finite(state) || state->interval_s < 0)
        return status_fail(STATUS_FORMAT,
                           "the wall state of step %" PRId64 " holds a number that is not finite, or "
                           "a negative interval",
                           state->step);
    for (int pair = 0; pair < state->n_walls / 2; pair++)
        if (!(state->position_m[2 * pair + 1] > state->position_m[2 * pair]))
            return status_fail(STATUS_FORMAT, "at step %" PRId64 " the walls of axis %c have met", state->step,
                               "xyz"[scene_pair_axis(scene, pair)]);
    return STATUS_OK;
}

/* Fills in everything but the motion; walls rest where they are. */
static void command_start(const struct scene *scene, const struct wall_state *state, const struct moment *moment,
                          struct wall_command *command)
{
    int64_t n_steps = moment->steps_left;
    if (n_steps > scene->coupling.interval_steps)
        n_steps = scene->coupling.interval_steps;
    *command = (struct wall_command){.step = state->step,
                                     .stage = moment->stage_index,
                                     .finished = n_steps == 0,
                                     .n_steps = n_steps > INT_MAX ? INT_MAX : (int)n_steps,
                                     .fraction_done = moment->fraction_done,
                                     .n_walls = state->n_walls};
    for (int wall = 0; wall < state->n_walls; wall++)
        command->position_m[wall] = state->position_m[wall];
}

enum status wallctl_law(const struct scene *scene, const struct wall_state *state, struct wall_command *command)
{
    TRY(state_check(scene, state));
    struct moment moment = protocol_moment(scene, state);
    command_start(scene, state, &moment, command);
    if (command->finished)
        return STATUS_OK;
    struct pair_control c = {.scene = scene,
                             .state = state,
                             .moment = &moment,
                             .start_s = (double)moment.stage_step * moment.stage->dt_s,
                             .end_s = (double)(moment.stage_step + command->n_steps) * moment.stage->dt_s,
                             .interval_s = command->n_steps * moment.stage->dt_s,
                             .last_interval_s = state->interval_s};
    for (int pair = 0; pair < state->n_walls / 2; pair++) {
        c.axis = &moment.stage->axis[scene_pair_axis(scene, pair)];
        c.lo = 2 * pair;
        c.hi = 2 * pair + 1;
        if (c.axis->mode == WALL_STRAIN)
            strain_pair(&c, command);
        else if (c.axis->mode == WALL_STRESS)
            stress_pair(&c, command);
    }
    if (!all_finite(command->velocity_m_per_s, command->n_walls) ||
        !all_finite(command->acceleration_m_per_s2, command->n_walls))
        return status_fail(STATUS_UNSTABLE, "at step %" PRId64 " the command of a wall is not finite", state->step);
    return STATUS_OK;
}
