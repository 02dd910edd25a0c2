#include "sim/outlook.h"

#include <math.h>

/* Samples that make a trend, and the least part of the scatter that the line must explain. */
enum { SAMPLES_MIN = 4 };
static const double EXPLAINED_MIN = 0.5;

void outlook_add(struct outlook *outlook, int64_t stage_step, double energy_ratio)
{
    if (!(energy_ratio > 0) || !isfinite(energy_ratio))
        return;
    outlook->samples++;
    outlook->last_step = (double)stage_step;
    outlook->last_log = log(energy_ratio);
    const double weight = (double)outlook->samples * outlook->samples;
    const double ds = outlook->last_step - outlook->step, dl = outlook->last_log - outlook->log_ratio;
    outlook->weight += weight;
    outlook->step += weight / outlook->weight * ds;
    outlook->log_ratio += weight / outlook->weight * dl;
    outlook->ss += weight * ds * (outlook->last_step - outlook->step);
    outlook->sl += weight * ds * (outlook->last_log - outlook->log_ratio);
    outlook->ll += weight * dl * (outlook->last_log - outlook->log_ratio);
}

/* Step of the stage at which the ratio is met, the last sample's if it is already; NaN: no trend towards it. */
static double step_of_ratio(const struct outlook *outlook, double ratio)
{
    bool falls = outlook->samples >= SAMPLES_MIN && outlook->sl < 0 &&
                 outlook->sl * outlook->sl >= EXPLAINED_MIN * outlook->ss * outlook->ll;
    if (outlook->samples > 0 && outlook->last_log <= log(ratio))
        return outlook->last_step;
    if (!falls)
        return NAN;
    return outlook->last_step + (log(ratio) - outlook->last_log) * outlook->ss / outlook->sl;
}

static double steps_of(double duration_s, const struct scene_stage *stage)
{
    return fmax(1, round(duration_s / stage->dt_s));
}

/* Length of the present stage, which ends by a condition. */
static double stage_end(const struct outlook *outlook, const struct scene_stage *stage, int64_t stage_step,
                        enum outlook_kind *kind)
{
    const double limit = steps_of(stage->duration_s, stage);
    double end = stage->until_energy_ratio > 0 ? step_of_ratio(outlook, stage->until_energy_ratio) : NAN;
    if (isfinite(end))
        end = fmax(end, stage->min_duration_s / stage->dt_s);
    bool ahead = end > (double)stage_step; /* false for NaN, and while the stress is waited for */
    *kind = ahead ? OUTLOOK_EXTRAPOLATED : OUTLOOK_AT_MOST;
    return ahead ? fmin(end, limit) : limit;
}

double outlook_steps_left(const struct outlook *outlook, const struct scene *scene, int stage, int64_t stage_step,
                          enum outlook_kind *kind)
{
    double steps = -(double)stage_step;
    *kind = OUTLOOK_KNOWN;
    for (int k = stage < 0 ? 0 : stage; k < scene->n_stages; k++) {
        const struct scene_stage *at = &scene->stage[k];
        const bool has_condition = at->until_energy_ratio > 0 || at->until_stress_error > 0;
        if (has_condition && k == stage) {
            steps += stage_end(outlook, at, stage_step, kind);
            continue;
        }
        steps += steps_of(at->duration_s, at);
        if (has_condition)
            *kind = OUTLOOK_AT_MOST;
    }
    return steps;
}
