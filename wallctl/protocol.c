#include "wallctl/protocol.h"

#include <math.h>

#include "wallctl/target.h"

double walls_area_m2(const struct wall_state *state, int pair)
{
    double area_m2 = 1;
    for (int other = 0; other < state->n_walls / 2; other++)
        if (other != pair)
            area_m2 *= state->position_m[2 * other + 1] - state->position_m[2 * other];
    return area_m2;
}

/* Period of the stress cycles of a stage; 0: it has none. */
static double cycle_period_s(const struct scene_stage *stage)
{
    for (int k = 0; k < SCENE_AXES; k++)
        if (stage->axis[k].mode == WALL_STRESS && stage->axis[k].target == TARGET_COSINE)
            return stage->axis[k].period_s;
    return 0;
}

int64_t protocol_stage_steps(const struct scene_stage *stage)
{
    const double rounding = 1e-9, steps = stage->duration_s / stage->dt_s, period_s = cycle_period_s(stage);
    const double cycles = period_s > 0 ? round(stage->duration_s / period_s) : 0;
    /* a last cycle that is meant to be whole is, if the time step does not divide it, by part of a step more */
    const bool whole = cycles >= 1 && fabs(cycles * period_s - stage->duration_s) <= rounding * stage->duration_s;
    const double count = whole ? ceil(steps * (1 - rounding)) : round(steps);
    return count > 1 ? (int64_t)count : 1;
}

static bool energy_ratio_met(const struct scene_stage *stage, const struct wall_state *state)
{
    bool fresh = state->energy_step > state->step - state->stage_step; /* measured after the first step of the stage */
    return fresh && state->elastic_energy_j > 0 &&
           state->kinetic_energy_j < stage->until_energy_ratio * state->elastic_energy_j;
}

static bool stress_near(const struct scene_stage *stage, double force_n, double area_m2, double target_pa)
{
    double tolerance_pa = fmax(stage->until_stress_error * fabs(target_pa), stage->stress_tolerance_pa);
    return fabs(force_n / area_m2 - target_pa) <= tolerance_pa;
}

/* Whether every stress-controlled wall is near its target; a stage without such walls never meets the condition. */
static bool stress_error_met(const struct scene *scene, const struct scene_stage *stage, const struct wall_state *state)
{
    double t_s = (double)state->stage_step * stage->dt_s;
    int controlled = 0;
    for (int pair = 0; pair < state->n_walls / 2; pair++) {
        const struct scene_axis *axis = &stage->axis[scene_pair_axis(scene, pair)];
        double lo_n = state->force_n[2 * pair], hi_n = state->force_n[2 * pair + 1];
        double area_m2 = walls_area_m2(state, pair);
        if (axis->mode != WALL_STRESS)
            continue;
        if (axis->opposite == OPPOSITE_MIRROR)
            hi_n = 0.5 * (lo_n + hi_n);
        if (!stress_near(stage, hi_n, area_m2, wallctl_target_pressure_pa(axis, t_s)))
            return false;
        if (axis->opposite == OPPOSITE_CONSTANT && !stress_near(stage, lo_n, area_m2, axis->pressure_pa))
            return false;
        controlled++;
    }
    return controlled > 0;
}

static bool conditions_met(const struct scene *scene, const struct scene_stage *stage, const struct wall_state *state)
{
    bool energy = stage->until_energy_ratio > 0, stress = stage->until_stress_error > 0;
    if (!(energy || stress) || state->stage_step == 0)
        return false;
    /* Half a step, so that rounding of the product does not cost a step. */
    if (((double)state->stage_step + 0.5) * stage->dt_s < stage->min_duration_s)
        return false;
    return (!energy || energy_ratio_met(stage, state)) && (!stress || stress_error_met(scene, stage, state));
}

static double fraction_done(const struct scene *scene, const struct moment *moment)
{
    double done_s = (double)moment->stage_step * moment->stage->dt_s;
    for (int k = 0; k < moment->stage_index; k++)
        done_s += scene->stage[k].duration_s;
    return moment->steps_left == 0 ? 1 : fmin(1, done_s / scene_total_time_s(scene));
}

struct moment protocol_moment(const struct scene *scene, const struct wall_state *state)
{
    struct moment moment = {
        .stage_index = state->stage, .stage_step = state->stage_step, .stage_position_m = state->stage_position_m};
    bool started = state->stage >= 0;
    if (started) {
        moment.stage = &scene->stage[state->stage];
        moment.steps_left = protocol_stage_steps(moment.stage) - state->stage_step;
        if (moment.steps_left < 0 || conditions_met(scene, moment.stage, state))
            moment.steps_left = 0;
    }
    if (moment.steps_left == 0 && state->stage + 1 < scene->n_stages) {
        moment.stage_index = state->stage + 1;
        moment.stage = &scene->stage[moment.stage_index];
        moment.stage_step = 0;
        moment.steps_left = protocol_stage_steps(moment.stage);
        moment.stage_position_m = state->position_m;
    }
    moment.fraction_done = fraction_done(scene, &moment);
    return moment;
}
