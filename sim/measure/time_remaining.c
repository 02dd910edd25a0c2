#include "sim/measure/time_remaining.h"

#include <math.h>

/* Samples that make a trend, and the least part of the scatter that the line must explain. */
enum { SAMPLES_MIN = 4 };
static const double EXPLAINED_MIN = 0.5;

void time_remaining_add(struct time_remaining *remaining, int64_t stage_step, double energy_ratio)
{
    if (!(energy_ratio > 0) || !isfinite(energy_ratio))
        return;
    remaining->samples++;
    remaining->last_step = (double)stage_step;
    remaining->last_log = log(energy_ratio);
    const double weight = (double)remaining->samples * remaining->samples;
    const double ds = remaining->last_step - remaining->step, dl = remaining->last_log - remaining->log_ratio;
    remaining->weight += weight;
    remaining->step += weight / remaining->weight * ds;
    remaining->log_ratio += weight / remaining->weight * dl;
    remaining->ss += weight * ds * (remaining->last_step - remaining->step);
    remaining->sl += weight * ds * (remaining->last_log - remaining->log_ratio);
    remaining->ll += weight * dl * (remaining->last_log - remaining->log_ratio);
}

/* Step of the stage at which the ratio is met, the last sample's if it is already; NaN: no trend towards it. */
static double step_of_ratio(const struct time_remaining *remaining, double ratio)
{
    bool falls = remaining->samples >= SAMPLES_MIN && remaining->sl < 0 &&
                 remaining->sl * remaining->sl >= EXPLAINED_MIN * remaining->ss * remaining->ll;
    if (remaining->samples > 0 && remaining->last_log <= log(ratio))
        return remaining->last_step;
    if (!falls)
        return NAN;
    return remaining->last_step + (log(ratio) - remaining->last_log) * remaining->ss / remaining->sl;
}

static double steps_of(double duration_s, const struct scene_stage *stage)
{
    return fmax(1, round(duration_s / stage->dt_s));
}

/* Length of the present stage, which ends by a condition. */
static double stage_end(const struct time_remaining *remaining, const struct scene_stage *stage, int64_t stage_step,
                        enum time_remaining_kind *kind)
{
    const double limit = steps_of(stage->duration_s, stage);
    double end = stage->until_energy_ratio > 0 ? step_of_ratio(remaining, stage->until_energy_ratio) : NAN;
    if (isfinite(end))
        end = fmax(end, stage->min_duration_s / stage->dt_s);
    bool ahead = end > (double)stage_step; /* false for NaN, and while the stress is waited for */
    *kind = ahead ? TIME_REMAINING_EXTRAPOLATED : TIME_REMAINING_AT_MOST;
    return ahead ? fmin(end, limit) : limit;
}

double time_remaining_steps(const struct time_remaining *remaining, const struct scene *scene, int stage,
                            int64_t stage_step, enum time_remaining_kind *kind)
{
    double steps = -(double)stage_step;
    *kind = TIME_REMAINING_KNOWN;
    for (int k = stage < 0 ? 0 : stage; k < scene->n_stages; k++) {
        const struct scene_stage *at = &scene->stage[k];
        const bool has_condition = at->until_energy_ratio > 0 || at->until_stress_error > 0;
        if (has_condition && k == stage) {
            steps += stage_end(remaining, at, stage_step, kind);
            continue;
        }
        steps += steps_of(at->duration_s, at);
        if (has_condition)
            *kind = TIME_REMAINING_AT_MOST;
    }
    return steps;
}
