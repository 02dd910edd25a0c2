#include "wallctl/control_law.h"

#include <inttypes.h>
#include <limits.h>
#include <math.h>

#include "common/pressure_target.h"
#include "common/strain_path.h"
#include "wallctl/coupled_axes.h"
#include "wallctl/stage_sequence.h"
#include "wallctl/stress_control.h"

/* What the motion of one pair of walls over the coming interval is computed from. */
struct pair_control {
    const struct scene *scene;
    const struct wall_state *state;
    struct wall_state foreseen[2]; /* positions in the middle and at the end of the interval: of strain control
                                          as commanded, of the others as they move now */
    const struct moment *moment;
    const double *target_pa; /* [pairs] at the start of the interval */
    int scheme;              /* that closes loops around forces */
    const struct scene_axis *axis;
    int lo, hi;            /* indices of its walls */
    double start_s, end_s; /* the interval, in the time of the stage */
    double interval_s;     /* H */
    int n_steps;
    double last_interval_s; /* of the interval that ended here; 0: none */
    double ahead_s;         /* the state was told so long before */
};

/* Strain control of one wall that takes `share` of the change in length (signed: +1 the upper wall, -1 the lower).
 * Quadratic: the path's rate at the start, its position at the end, so that no error adds up. */
static struct wall_motion strain_motion(const struct pair_control *c, int wall, double share)
{
    const double *start_m = c->moment->stage_position_m;
    double z0_m = start_m[c->hi] - start_m[c->lo];
    if (strain_path_done(c->axis, c->start_s)) /* there: at rest, not chasing the last bit */
        return (struct wall_motion){0, 0};
    double rate = share * strain_path_rate_m_per_s(c->axis, z0_m, c->start_s);
    double end_m = start_m[wall] + share * (strain_path_length_m(c->axis, z0_m, c->end_s) - z0_m);
    double way_m = end_m - c->state->position_m[wall];
    double h = c->interval_s;
    return (struct wall_motion){rate, 2 * (way_m - rate * h) / (h * h)};
}

/* The pair of walls as a loop for wallctl/stress_control.h; forces and velocities by the caller. */
static struct stress_loop loop_of(const struct pair_control *c, double target_pa)
{
    return (struct stress_loop){.mass_kg = c->axis->mass_kg,
                                .damping_kg_per_s = c->axis->damping_kg_per_s,
                                .last_interval_s = c->last_interval_s,
                                .interval_s = c->interval_s,
                                .ahead_s = c->ahead_s,
                                .one_step = c->n_steps == 1,
                                .target_n = target_pa * walls_area_m2(c->state, c->hi / 2)};
}

/* Outward acceleration of wall w in the last interval; 0 unless contacts pushed at both its ends: that of free flight,
 * or of contacts that pull and let go, is not what a mass of contacts goes on with. */
static double touched_acceleration_m_per_s2(const struct wall_state *state, int w)
{
    const double outward = w % 2 ? 1 : -1;
    return !(state->force_before_n[w] > 0 && state->force_n[w] > 0) ? 0 : outward * state->acceleration_m_per_s2[w];
}

static void motion_set(struct wall_command *command, int wall, double sign, struct wall_motion motion)
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

static void loop_set(struct wall_command *command, int wall, double sign, const struct stress_motion *motion)
{
    motion_set(command, wall, sign, motion->motion);
    command->drive[wall] = DRIVE_LOOP;
    command->force_n[wall] = motion->force_n;
}

/* One wall as a degree of freedom of its own; sign: +1 the upper wall, -1 the lower. */
static void stress_wall(const struct pair_control *c, int wall, double sign, double target_pa,
                        struct wall_command *command)
{
    const struct wall_state *state = c->state;
    struct stress_loop loop = loop_of(c, target_pa);
    loop.stiffness_n_per_m = state->stiffness_n_per_m[wall];
    loop.contact_damping_kg_per_s = state->damping_kg_per_s[wall];
    loop.velocity_m_per_s = sign * state->velocity_m_per_s[wall];
    loop.acceleration_m_per_s2 = touched_acceleration_m_per_s2(state, wall);
    loop.force_n = state->force_n[wall];
    struct stress_motion motion = stress_motion(c->scheme, &loop);
    loop_set(command, wall, sign, &motion);
}

/* Both walls alike: one degree of freedom of that mass and damping, with the mean of both forces. */
static void stress_mirror(const struct pair_control *c, double target_pa, struct wall_command *command)
{
    const struct wall_state *s = c->state;
    struct stress_loop loop = loop_of(c, target_pa);
    loop.stiffness_n_per_m = 0.5 * (s->stiffness_n_per_m[c->hi] + s->stiffness_n_per_m[c->lo]);
    loop.contact_damping_kg_per_s = 0.5 * (s->damping_kg_per_s[c->hi] + s->damping_kg_per_s[c->lo]);
    loop.velocity_m_per_s = 0.5 * (s->velocity_m_per_s[c->hi] + -s->velocity_m_per_s[c->lo]);
    loop.acceleration_m_per_s2 =
        0.5 * (touched_acceleration_m_per_s2(s, c->hi) + touched_acceleration_m_per_s2(s, c->lo));
    loop.force_n = 0.5 * (s->force_n[c->hi] + s->force_n[c->lo]);
    struct stress_motion motion = stress_motion(c->scheme, &loop);
    loop_set(command, c->hi, 1, &motion);
    loop_set(command, c->lo, -1, &motion);
}

/* The loop goes to sim: mass, damping, and the driving force p A, a parabola through its start, middle and end; exact
 * at the start, later as far as the other walls are foreseen. target_pa [3]: at the three. */
static void impedance_wall(const struct pair_control *c, int wall, enum wall_drive drive, const double *target_pa,
                           struct wall_command *command)
{
    const int pair = c->hi / 2;
    const double h = c->interval_s;
    const double start_n = target_pa[0] * walls_area_m2(c->state, pair);
    const double middle_n = target_pa[1] * walls_area_m2(&c->foreseen[0], pair);
    const double end_n = target_pa[2] * walls_area_m2(&c->foreseen[1], pair);
    command->drive[wall] = drive;
    command->mass_kg[wall] = c->axis->mass_kg;
    command->damping_kg_per_s[wall] = c->axis->damping_kg_per_s;
    command->force_n[wall] = start_n;
    command->force_rate_n_per_s[wall] = (4 * (middle_n - start_n) - (end_n - start_n)) / h;
    command->force_rate2_n_per_s2[wall] = 4 * ((end_n - middle_n) - (middle_n - start_n)) / (h * h);
}

static void impedance_pair(const struct pair_control *c, struct wall_command *command)
{
    const bool mirror = c->axis->opposite == OPPOSITE_MIRROR;
    const enum wall_drive drive = mirror ? DRIVE_IMPEDANCE_MIRROR : DRIVE_IMPEDANCE;
    const double own_pa = c->target_pa[c->hi / 2], constant_pa = c->axis->pressure_pa;
    const double constant[] = {constant_pa, constant_pa, constant_pa};
    double target_pa[] = {own_pa, own_pa, own_pa}; /* of a coupled axis: as it is now */
    if (c->axis->mode == WALL_STRESS) {
        target_pa[1] = pressure_target_pa(c->axis, 0.5 * (c->start_s + c->end_s));
        target_pa[2] = pressure_target_pa(c->axis, c->end_s);
    }
    impedance_wall(c, c->hi, drive, target_pa, command);
    if (mirror)
        impedance_wall(c, c->lo, drive, target_pa, command);
    else if (c->axis->opposite == OPPOSITE_CONSTANT)
        impedance_wall(c, c->lo, drive, constant, command);
}

static void stress_pair(const struct pair_control *c, struct wall_command *command)
{
    double target_pa = c->target_pa[c->hi / 2];
    if (c->scheme == SCHEME_IMPEDANCE) {
        impedance_pair(c, command);
    } else if (c->axis->opposite == OPPOSITE_MIRROR) {
        stress_mirror(c, target_pa, command);
    } else {
        stress_wall(c, c->hi, 1, target_pa, command);
        if (c->axis->opposite == OPPOSITE_CONSTANT)
            stress_wall(c, c->lo, -1, c->axis->pressure_pa, command);
    }
}

/* Lengths of all pairs and their rates at `tau_s` in the interval, of those that do not keep the volume. */
static void lengths_of(const struct wall_command *command, double tau_s, double *length_m, double *rate_m_per_s)
{
    for (int pair = 0; pair < command->n_walls / 2; pair++) {
        double x[2], v[2];
        for (int k = 0; k < 2; k++) {
            const int wall = 2 * pair + k;
            const double a = command->acceleration_m_per_s2[wall];
            v[k] = command->velocity_m_per_s[wall] + tau_s * a;
            x[k] = command->position_m[wall] + tau_s * (command->velocity_m_per_s[wall] + 0.5 * tau_s * a);
        }
        length_m[pair] = x[1] - x[0];
        rate_m_per_s[pair] = v[1] - v[0];
    }
}

/* A pair that keeps the volume: the rate that does so at the start, the length at the end. In between the parabola is
 * off by the third power of the strain in the interval, or 0.15 times the second where a course has a kink. */
static void volume_pair(const struct pair_control *c, const bool *keeps_volume, struct wall_command *command)
{
    const int pairs = command->n_walls / 2, pair = c->hi / 2;
    const double *start = c->moment->stage_position_m, h = c->interval_s;
    const bool mirror = c->axis->opposite == OPPOSITE_MIRROR;
    double start_m[SCENE_AXES], length_m[SCENE_AXES], rate_m_per_s[SCENE_AXES];
    for (int k = 0; k < pairs; k++)
        start_m[k] = start[2 * k + 1] - start[2 * k];
    lengths_of(command, 0, length_m, rate_m_per_s);
    const struct coupled_length now = coupled_length(keeps_volume, pairs, pair, start_m, length_m, rate_m_per_s);
    lengths_of(command, h, length_m, rate_m_per_s);
    const struct coupled_length end = coupled_length(keeps_volume, pairs, pair, start_m, length_m, rate_m_per_s);
    for (int wall = c->hi; wall >= (mirror ? c->lo : c->hi); wall--) {
        const double share = mirror ? (wall == c->hi ? 0.5 : -0.5) : 1;
        const double way_m = start[wall] + share * (end.length_m - start_m[pair]) - c->state->position_m[wall];
        const double v = share * now.rate_m_per_s;
        motion_set(command, wall, 1, (struct wall_motion){v, 2 * (way_m - v * h) / (h * h)});
    }
}

static bool all_finite(const double *values, int count)
{
    for (int k = 0; k < count; k++)
        if (!isfinite(values[k]))
            return false;
    return true;
}

static bool state_is_finite(const struct wall_state *s)
{
    const double scalars[] = {
        s->time_s,          s->stage_time_s,          s->interval_s, s->kinetic_energy_j, s->elastic_energy_j,
        s->interface_error, s->interface_error_before};
    const double *walls[] = {
        s->position_m,        s->velocity_m_per_s,      s->acceleration_m_per_s2, s->force_n,
        s->stiffness_n_per_m, s->damping_kg_per_s,      s->stage_position_m,      s->force_before_n,
        s->ahead_position_m,  s->ahead_velocity_m_per_s};
    for (size_t k = 0; k < sizeof walls / sizeof walls[0]; k++)
        if (!all_finite(walls[k], s->n_walls))
            return false;
    return all_finite(scalars, sizeof scalars / sizeof scalars[0]);
}

static enum status state_check(const struct scene *scene, const struct wall_state *state)
{
    if (state->n_walls != scene_wall_count(scene))
        return status_fail(STATUS_FORMAT, "the wall state of step %" PRId64 " has %d walls, the scene %d", state->step,
                           state->n_walls, scene_wall_count(scene));
    if (state->command_step < state->step || (state->stage < 0 && state->command_step > state->step))
        return status_fail(STATUS_FORMAT,
                           "the wall state of step %" PRId64 " in stage %d asks for a command for step %" PRId64,
                           state->step, state->stage, state->command_step);
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

/* adaptive: the next interval from the energy mismatch at the walls in the last two, a PI controller of the step size
 * (Gustafsson 1991; as of ECCO, Sadjina et al. 2017) for a mismatch that grows with the square of the interval. */
static int64_t adaptive_steps(const struct scene *scene, const struct wall_state *state, const struct moment *moment)
{
    const double order = 2, integral = 0.3 / order, proportional = 0.4 / order, least = 1e-3;
    const double tolerance = scene->coupling.tolerance;
    if (moment->stage_step == 0)
        return 1;
    double error = fmax(state->interface_error / tolerance, least);
    double before = fmax(state->interface_error_before / tolerance, least);
    double factor = 0.9 * pow(error, -integral) * pow(before / error, proportional);
    double steps = round(state->interval_s / moment->stage->dt_s) * fmin(2, fmax(0.25, factor));
    return (int64_t)fmax(1, fmin(steps + 0.5, (double)scene->coupling.interval_steps));
}

/* Fills in everything but the motion; walls rest where they are. */
static void command_start(const struct scene *scene, const struct wall_state *state, const struct moment *moment,
                          struct wall_command *command)
{
    int64_t n_steps = scene->coupling.interval_steps;
    if (scene->coupling.scheme == SCHEME_ADAPTIVE)
        n_steps = adaptive_steps(scene, state, moment);
    if (n_steps > moment->steps_to_look)
        n_steps = moment->steps_to_look;
    if (n_steps > moment->steps_left)
        n_steps = moment->steps_left;
    *command = (struct wall_command){.step = state->step,
                                     .stage = moment->stage_index,
                                     .finished = n_steps == 0,
                                     .ended = moment->ended,
                                     .measure = moment->looks_at_energy && n_steps == moment->steps_to_look,
                                     .n_steps = n_steps > INT_MAX ? INT_MAX : (int)n_steps,
                                     .fraction_done = moment->fraction_done,
                                     .n_walls = state->n_walls};
    for (int wall = 0; wall < state->n_walls; wall++)
        command->position_m[wall] = state->position_m[wall];
}

/* The force that goes on as it went, `part` of the way from before to now. Contacts that just began or let go do not,
 * and none that pushed is expected to pull. */
static double expected_force_n(double before_n, double now_n, double part, bool always)
{
    const double expected_n = stress_force_ahead_n(before_n, now_n, part);
    if (always)
        return expected_n;
    return before_n > 0 && now_n > 0 ? fmax(0, expected_n) : now_n;
}

/* The state expected at command_step: where the command in force leads to, and forces that go on as they went. */
static struct wall_state state_ahead(const struct wall_state *state, const struct scene *scene)
{
    struct wall_state ahead = *state;
    const int64_t steps = state->command_step - state->step;
    if (steps == 0)
        return ahead;
    const bool whole = scene->coupling.scheme == SCHEME_PIPELINED; /* told when the interval in force began */
    const double ahead_s = (double)steps * scene->stage[state->stage].dt_s;
    const double before_s = whole ? state->interval_s : state->interval_s - ahead_s; /* of force_before_n */
    const double part = before_s > 0 && state->stage_step > 0 ? ahead_s / before_s : 0;
    ahead.step += steps;
    ahead.stage_step += steps;
    ahead.stage_time_s += ahead_s;
    ahead.time_s += ahead_s;
    ahead.energy_step += steps; /* as fresh as it was */
    if (whole)
        ahead.interval_s = ahead_s;
    for (int wall = 0; wall < state->n_walls; wall++) {
        ahead.position_m[wall] = state->ahead_position_m[wall];
        ahead.velocity_m_per_s[wall] = state->ahead_velocity_m_per_s[wall];
        ahead.force_n[wall] = expected_force_n(state->force_before_n[wall], state->force_n[wall], part, whole);
    }
    return ahead;
}

/* Where the walls will be at t in the interval: commanded paths, and the others as they move now. */
static struct wall_state foresee(const struct wall_state *state, const struct wall_command *command, const bool *strain,
                                 double t_s)
{
    struct wall_state foreseen = *state;
    for (int wall = 0; wall < state->n_walls; wall++) {
        double v = command->velocity_m_per_s[wall] + 0.5 * t_s * command->acceleration_m_per_s2[wall];
        foreseen.position_m[wall] += t_s * (strain[wall / 2] ? v : state->velocity_m_per_s[wall]);
    }
    return foreseen;
}

/* What moves an axis, in the order in which motions follow from each other. */
enum turn { TURN_STRAIN, TURN_LOOP, TURN_VOLUME, TURNS };

static enum turn turn_of(const struct scene_axis *axis)
{
    if (axis->mode == WALL_STRAIN)
        return TURN_STRAIN;
    return axis_has_loop(axis) ? TURN_LOOP : axis_keeps_volume(axis) ? TURN_VOLUME : TURNS;
}

static void move_pair(struct pair_control *c, enum turn turn, const bool *keeps_volume, struct wall_command *command)
{
    if (turn == TURN_STRAIN)
        strain_pair(c, command);
    else if (turn == TURN_LOOP)
        stress_pair(c, command);
    else
        volume_pair(c, keeps_volume, command);
}

static void move_walls(struct pair_control *c, struct wall_command *command)
{
    const int pairs = c->state->n_walls / 2;
    const struct scene_axis *axis[SCENE_AXES];
    bool strain[SCENE_AXES], keeps_volume[SCENE_AXES];
    for (int pair = 0; pair < pairs; pair++) {
        axis[pair] = &c->moment->stage->axis[scene_pair_axis(c->scene, pair)];
        strain[pair] = axis[pair]->mode == WALL_STRAIN;
        keeps_volume[pair] = axis_keeps_volume(axis[pair]);
        /* what a drive closes by itself, no other wall can follow */
        if (keeps_volume[pair] && c->scheme == SCHEME_IMPEDANCE)
            c->scheme = SCHEME_JACOBIAN;
    }
    for (enum turn turn = 0; turn < TURNS; turn++) {
        if (turn == TURN_LOOP)
            for (int part = 0; part < 2; part++)
                c->foreseen[part] = foresee(c->state, command, strain, 0.5 * (part + 1) * c->interval_s);
        for (int pair = 0; pair < pairs; pair++) {
            c->axis = axis[pair];
            c->lo = 2 * pair;
            c->hi = 2 * pair + 1;
            if (turn_of(c->axis) == turn)
                move_pair(c, turn, keeps_volume, command);
        }
    }
}

enum status wallctl_law(const struct scene *scene, const struct wall_state *told, struct wall_command *command)
{
    TRY(state_check(scene, told));
    const struct wall_state state = state_ahead(told, scene);
    struct moment moment = stage_sequence_moment(scene, &state);
    command_start(scene, &state, &moment, command);
    if (told->command_step > told->step && (command->finished || command->stage != told->stage)) {
        command->finished = false; /* a stage, and the end of the protocol, begin with a state of their own */
        command->stage = told->stage;
        command->ended = STAGE_END_NONE;
        command->n_steps = 0;
    }
    if (command->n_steps == 0)
        return STATUS_OK;
    double target_pa[SCENE_AXES];
    TRY(coupled_targets(scene, moment.stage, &state, (double)moment.stage_step * moment.stage->dt_s, target_pa));
    struct pair_control c = {.scene = scene,
                             .target_pa = target_pa,
                             .scheme = scene->coupling.scheme,
                             .state = &state,
                             .moment = &moment,
                             .start_s = (double)moment.stage_step * moment.stage->dt_s,
                             .end_s = (double)(moment.stage_step + command->n_steps) * moment.stage->dt_s,
                             .interval_s = command->n_steps * moment.stage->dt_s,
                             .n_steps = command->n_steps,
                             .last_interval_s = state.interval_s,
                             .ahead_s = (double)(told->command_step - told->step) * moment.stage->dt_s};
    move_walls(&c, command);
    if (!all_finite(command->velocity_m_per_s, command->n_walls) ||
        !all_finite(command->acceleration_m_per_s2, command->n_walls))
        return status_fail(STATUS_UNSTABLE,
                           "at step %" PRId64 " the command of a wall is not finite: its loop is not stable; fewer "
                           "coupling.interval_steps, shorter steps, more mass or more damping would help",
                           state.step);
    return STATUS_OK;
}

int wallctl_stable_steps(const struct scene_coupling *coupling, const struct scene_axis *axis, double stiffness_n_per_m,
                         double damping_kg_per_s, double dt_s)
{
    const struct stress_loop loop = {.mass_kg = axis->mass_kg,
                                     .damping_kg_per_s = axis->damping_kg_per_s,
                                     .stiffness_n_per_m = stiffness_n_per_m,
                                     .contact_damping_kg_per_s = damping_kg_per_s};
    const int n = coupling->interval_steps > INT_MAX ? INT_MAX : (int)coupling->interval_steps;
    struct scene_coupling trial = *coupling;
    if (trial.scheme == SCHEME_IMPEDANCE)
        trial.scheme = SCHEME_HOLD;
    return stress_stable_steps(&trial, &loop, dt_s, trial.scheme == SCHEME_HOLD ? n : (n + 1) / 2);
}
