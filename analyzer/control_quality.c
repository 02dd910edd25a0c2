#include "analyzer/control_quality.h"

#include <math.h>

#include "common/pressure_target.h"

/* Sums of |deviation| and of what it is measured by. */
struct tally {
    double sum, largest, size;
    double tolerance;
    size_t count;
};

static void tally_add(struct tally *tally, double deviation, double size)
{
    if (!isfinite(deviation))
        return;
    tally->sum += fabs(deviation);
    tally->largest = fmax(tally->largest, fabs(deviation));
    tally->size = fmax(tally->size, fabs(size));
    tally->count++;
}

static struct control_quality tally_kept(const struct tally *tally)
{
    if (tally->count == 0 || !(tally->size > 0))
        return (struct control_quality){NAN, NAN, 0};
    return (struct control_quality){tally->sum / (double)tally->count / tally->size, tally->largest / tally->size,
                                    tally->tolerance};
}

static void tolerance_add(struct tally *tally, double tolerance)
{
    if (tolerance > 0)
        tally->tolerance = tally->tolerance > 0 ? fmin(tally->tolerance, tolerance) : tolerance;
}

/* p, q = sigma_zz - mean lateral, and the volume, at a sample. */
struct point {
    const double *stress_pa; /* [dimension] */
    double p_pa, q_pa, volume_m3, time_s;
};

static struct point point_at(const struct run *run, size_t sample)
{
    const int axial = run->dimension - 1;
    const double *stress_pa = run_record(run, OBSERVABLE_STRESS_WALL, sample),
                 *length_m = run_record(run, OBSERVABLE_BOX_LENGTH, sample);
    struct point at = {.stress_pa = stress_pa, .volume_m3 = 1};
    double sum_pa = 0;
    for (int k = 0; k < run->dimension; k++) {
        sum_pa += stress_pa[k];
        at.volume_m3 *= length_m[k];
    }
    at.p_pa = sum_pa / run->dimension;
    at.q_pa = stress_pa[axial] - (sum_pa - stress_pa[axial]) / axial;
    at.time_s = *run_record(run, OBSERVABLE_STAGE_TIME, sample);
    return at;
}

static enum kept_quantity kept_by(const struct scene_axis *axis)
{
    static const enum kept_quantity by_keep[] = {
        [KEEP_VOLUME] = KEPT_VOLUME, [KEEP_P] = KEPT_P, [KEEP_Q] = KEPT_Q, [KEEP_B] = KEPT_B, [KEEP_PATH] = KEPT_PATH};
    return axis->mode == WALL_COUPLED ? by_keep[axis->keep] : KEPT_STRESS;
}

static void coupled_add(const struct scene_axis *axis, const struct point *at, double volume_m3, struct tally *tally)
{
    const double target_pa = pressure_target_pa(axis, at->time_s);
    switch (axis->keep) {
    case KEEP_P:
        tally_add(&tally[KEPT_P], at->p_pa - target_pa, target_pa);
        break;
    case KEEP_Q:
        tally_add(&tally[KEPT_Q], at->q_pa - target_pa, target_pa);
        break;
    case KEEP_PATH:
        tally_add(&tally[KEPT_PATH], at->q_pa - axis->deviator_pa - axis->dq_dp * (at->p_pa - axis->pressure_pa),
                  axis->pressure_pa);
        break;
    case KEEP_B: {
        const double span_pa = at->stress_pa[2] - at->stress_pa[0];
        if (fabs(span_pa) > 0.01 * at->p_pa)
            tally_add(&tally[KEPT_B], (at->stress_pa[1] - at->stress_pa[0]) / span_pa - axis->b, 1);
        break;
    }
    default:
        tally_add(&tally[KEPT_VOLUME], at->volume_m3 / volume_m3 - 1, 1);
    }
}

void control_quality_find(const struct run *run, int stage, size_t begin, size_t end,
                          struct control_quality kept[KEPT_QUANTITIES])
{
    struct tally tally[KEPT_QUANTITIES] = {0};
    const double volume_m3 = begin < end ? point_at(run, begin).volume_m3 : NAN;
    for (size_t k = begin; k < end; k++) {
        const struct point at = point_at(run, k);
        for (int slot = 0; slot < run->dimension; slot++) {
            const struct scene_axis *axis = &run->scene->stage[stage].axis[scene_pair_axis(run->scene, slot)];
            const double target_pa = axis->mode == WALL_STRESS ? pressure_target_pa(axis, at.time_s) : NAN;
            if (axis->mode == WALL_COUPLED)
                coupled_add(axis, &at, volume_m3, tally);
            else
                tally_add(&tally[KEPT_STRESS], at.stress_pa[slot] - target_pa, target_pa);
        }
    }
    for (int slot = 0; slot < run->dimension; slot++) {
        const struct scene_axis *axis = &run->scene->stage[stage].axis[scene_pair_axis(run->scene, slot)];
        tolerance_add(&tally[kept_by(axis)], axis->tolerance);
    }
    for (int k = 0; k < KEPT_QUANTITIES; k++)
        kept[k] = tally_kept(&tally[k]);
}

void control_quality_quantities(const struct run *run, int stage, struct quantity *quantities)
{
    static const enum quantity_id id[KEPT_QUANTITIES] = {QUANTITY_KEPT_STRESS, QUANTITY_KEPT_VOLUME, QUANTITY_KEPT_P,
                                                         QUANTITY_KEPT_Q,      QUANTITY_KEPT_PATH,   QUANTITY_KEPT_B};
    struct control_quality kept[KEPT_QUANTITIES];
    size_t begin, end;
    run_stage_range(run, stage, &begin, &end);
    control_quality_find(run, stage, begin, end, kept);
    for (int k = 0; k < KEPT_QUANTITIES; k++) {
        if (run->controller[0])
            quantity_absent(&quantities[id[k]], "a controller of the user's own set the targets, not the scene");
        else if (isnan(kept[k].largest))
            quantity_absent(&quantities[id[k]], "no axis is to keep it");
        else
            quantity_set(&quantities[id[k]], (struct estimate){kept[k].largest, NAN});
    }
}
