#include "wallctl/stage_sequence.h"

#include <math.h>

#include "wallctl/coupled_axes.h"

/* Period of the cycles of a stage; 0: it has none. */
static double cycle_period_s(const struct scene_stage *stage)
{
    double period_s = 0;
    for (int k = 0; k < SCENE_AXES && !(period_s > 0); k++)
        period_s = scene_axis_period_s(&stage->axis[k]);
    return period_s;
}

/* Steps that cover a whole number of cycles: if the time step does not divide them, part of a step more. */
static double whole_steps(double time_s, double dt_s)
{
    const double rounding = 1e-9;
    return ceil(time_s / dt_s * (1 - rounding));
}

static double duration_steps(const struct scene_stage *stage)
{
    const double rounding = 1e-9, period_s = cycle_period_s(stage);
    const double cycles = period_s > 0 ? round(stage->duration_s / period_s) : 0;
    const bool whole = cycles >= 1 && fabs(cycles * period_s - stage->duration_s) <= rounding * stage->duration_s;
    return whole ? whole_steps(stage->duration_s, stage->dt_s) : round(stage->duration_s / stage->dt_s);
}

/* Whether there is anything to look at on the way. */
static bool has_conditions(const struct scene_stage *stage)
{
    bool any = stage->until_energy_ratio > 0 || stage->until_stress_error > 0 || stage->until_q_pa.count > 0 ||
               stage->until_q_over_p.count > 0 || stage->until_r_u > 0;
    for (int k = 0; k < SCENE_AXES; k++)
        any = any || stage->axis[k].until_strain.count > 0 || stage->axis[k].until_stress_pa.count > 0;
    return any;
}

/* Steps of a stage that no condition on the way ends, at least 1, and what ends it then. */
static int64_t stage_steps(const struct scene_stage *stage, enum stage_end *end)
{
    double steps = duration_steps(stage);
    *end = has_conditions(stage) || stage->until_cycles > 0 ? STAGE_END_LIMIT : STAGE_END_LENGTH;
    if (stage->until_cycles > 0) {
        const double cycles = whole_steps((double)stage->until_cycles * cycle_period_s(stage), stage->dt_s);
        *end = cycles <= steps ? STAGE_END_CYCLES : *end;
        steps = fmin(cycles, steps);
    }
    return steps > 1 ? (int64_t)steps : 1;
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
    double target_pa[SCENE_AXES];
    int controlled = 0;
    if (coupled_targets(scene, stage, state, (double)state->stage_step * stage->dt_s, target_pa) != STATUS_OK)
        return false;
    for (int pair = 0; pair < state->n_walls / 2; pair++) {
        const struct scene_axis *axis = &stage->axis[scene_pair_axis(scene, pair)];
        double lo_n = state->force_n[2 * pair], hi_n = state->force_n[2 * pair + 1];
        double area_m2 = walls_area_m2(state, pair);
        if (!axis_has_loop(axis))
            continue;
        if (axis->opposite == OPPOSITE_MIRROR)
            hi_n = 0.5 * (lo_n + hi_n);
        if (!stress_near(stage, hi_n, area_m2, target_pa[pair]))
            return false;
        if (axis->opposite == OPPOSITE_CONSTANT && !stress_near(stage, lo_n, area_m2, axis->pressure_pa))
            return false;
        controlled++;
    }
    return controlled > 0;
}

static bool rest_met(const struct scene *scene, const struct scene_stage *stage, const struct wall_state *state)
{
    const bool energy = stage->until_energy_ratio > 0, stress = stage->until_stress_error > 0;
    return (energy || stress) && (!energy || energy_ratio_met(stage, state)) &&
           (!stress || stress_error_met(scene, stage, state));
}

static bool beyond(const struct config_band *band, double value)
{
    if (band->count == 0)
        return false;
    if (band->count == 2)
        return value <= band->value[0] || value >= band->value[1];
    return band->value[0] > 0 ? value >= band->value[0] : value <= band->value[0];
}

/* Conditions of one axis. */
static enum stage_end axis_condition_met(const struct scene_axis *axis, const struct wall_state *state, int pair)
{
    const double *now_m = &state->position_m[2 * pair], *start_m = &state->stage_position_m[2 * pair];
    if (beyond(&axis->until_strain, 1 - (now_m[1] - now_m[0]) / (start_m[1] - start_m[0])))
        return STAGE_END_STRAIN;
    return beyond(&axis->until_stress_pa, walls_stress_pa(state, pair)) ? STAGE_END_STRESS : STAGE_END_NONE;
}

static enum stage_end stress_condition_met(const struct scene_stage *stage, const struct wall_state *state)
{
    const double p_pa = walls_mean_stress_pa(state), q_pa = walls_deviator_pa(state);
    if (beyond(&stage->until_q_pa, q_pa))
        return STAGE_END_Q;
    if (p_pa > 0 && beyond(&stage->until_q_over_p, q_pa / p_pa))
        return STAGE_END_Q_OVER_P;
    if (stage->until_r_u > 0 && 1 - p_pa / stage->reference_pressure_pa >= stage->until_r_u)
        return STAGE_END_R_U;
    return STAGE_END_NONE;
}

/* The condition that is met at `state`. They are looked at on a schedule of their own, in steps of the stage. */
static enum stage_end condition_met(const struct scene *scene, const struct scene_stage *stage,
                                    const struct wall_state *state)
{
    if (!has_conditions(stage) || state->stage_step == 0 || state->stage_step % stage->condition_steps != 0)
        return STAGE_END_NONE;
    /* Half a step, so that rounding of the product does not cost a step. */
    if (((double)state->stage_step + 0.5) * stage->dt_s < stage->min_duration_s)
        return STAGE_END_NONE;
    enum stage_end end = stress_condition_met(stage, state);
    for (int pair = 0; end == STAGE_END_NONE && pair < state->n_walls / 2; pair++)
        end = axis_condition_met(&stage->axis[scene_pair_axis(scene, pair)], state, pair);
    if (end == STAGE_END_NONE && rest_met(scene, stage, state))
        end = STAGE_END_REST;
    return end;
}

static double fraction_done(const struct scene *scene, const struct moment *moment)
{
    double done_s = (double)moment->stage_step * moment->stage->dt_s;
    for (int k = 0; k < moment->stage_index; k++)
        done_s += scene->stage[k].duration_s;
    return moment->steps_left == 0 ? 1 : fmin(1, done_s / scene_total_time_s(scene));
}

/* How long the stage goes on, at most until somebody has to look at its conditions. */
static void set_ahead(struct moment *moment)
{
    const struct scene_stage *stage = moment->stage;
    moment->steps_to_look = INT64_MAX;
    if (has_conditions(stage))
        moment->steps_to_look = stage->condition_steps - moment->stage_step % stage->condition_steps;
    moment->looks_at_energy = stage->until_energy_ratio > 0;
}

struct moment stage_sequence_moment(const struct scene *scene, const struct wall_state *state)
{
    struct moment moment = {
        .stage_index = state->stage, .stage_step = state->stage_step, .stage_position_m = state->stage_position_m};
    bool started = state->stage >= 0;
    if (started) {
        enum stage_end end, met;
        moment.stage = &scene->stage[state->stage];
        moment.steps_left = stage_steps(moment.stage, &end) - state->stage_step;
        met = condition_met(scene, moment.stage, state);
        if (moment.steps_left <= 0 || met != STAGE_END_NONE) {
            moment.steps_left = 0;
            moment.ended = met != STAGE_END_NONE ? met : end;
        }
    }
    if (moment.steps_left == 0 && state->stage + 1 < scene->n_stages) {
        enum stage_end end;
        moment.stage_index = state->stage + 1;
        moment.stage = &scene->stage[moment.stage_index];
        moment.stage_step = 0;
        moment.steps_left = stage_steps(moment.stage, &end);
        moment.stage_position_m = state->position_m;
    }
    set_ahead(&moment);
    moment.fraction_done = fraction_done(scene, &moment);
    return moment;
}
