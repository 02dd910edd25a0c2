#include "sim/measure/stability_watch.h"

#include <math.h>
#include <stdio.h>

#include "common/pressure_target.h"
#include "sim/measure/measure.h"
#include "wallctl/control_law.h"

/* A box that a stress-controlled wall has opened to this many times the length at the start of the stage holds nothing
 * that would stop it; of walls that pull, and of others, which may start with fast particles. */
static const double PULLED = 2, GROWN = 4;

void stability_watch_start(struct stability_watch *watch)
{
    *watch = (struct stability_watch){0};
}

enum status stability_watch_look_at_contacts(struct stability_watch *watch, struct sample *sample,
                                             struct passing_watch *passing)
{
    struct largest_overlap now;
    TRY(overlaps_look(sample, passing, &now));
    const double limit = sample->scene->stage[sample->stage].limits.overlap_ratio;
    char other[32];
    if (now.ratio > watch->overlap_ratio) {
        watch->overlap_ratio = now.ratio;
        watch->overlap_step = (double)sample->step;
    }
    if (!(now.ratio > limit))
        return STATUS_OK;
    if (now.j < 0)
        snprintf(other, sizeof other, "a wall in %c", "xyz"[sample_axis(sample, (-1 - now.j) / 2)]);
    else
        snprintf(other, sizeof other, "particle %d", now.j);
    return status_fail(
        STATUS_UNSTABLE,
        "step %lld (t = %g s): particle %d and %s overlap by %.0f %% of the smaller radius: the contacts "
        "are too soft for this load, or dt_s too long. Stiffer contacts or less load would help; "
        "limits.overlap_ratio = %g is where the stage stops",
        (long long)sample->step, sample->time_s, now.i, other, 100 * now.ratio, limit);
}

/* The stress on the controlled wall or walls of component c [N/m^2]. */
static double controlled_stress_pa(const struct sample *sample, const struct scene_axis *axis, int c)
{
    double area = 1;
    for (int b = 0; b < sample->particles.dimension; b++)
        area *= b == c ? 1 : sample_box_length_m(sample, b);
    const double lo = sample->walls[2 * c].force, hi = sample->walls[2 * c + 1].force;
    return (axis->opposite == OPPOSITE_MIRROR ? 0.5 * (lo + hi) : hi) / area;
}

static void stress_look(struct stability_watch *watch, const struct sample *sample)
{
    const struct scene_stage *stage = &sample->scene->stage[sample->stage];
    const double t = (double)sample->stage_step * sample->dt;
    if (t < 0.5 * stage->duration_s)
        return;
    watch->error_looks++;
    for (int c = 0; c < sample->particles.dimension; c++) {
        const struct scene_axis *axis = &stage->axis[sample_axis(sample, c)];
        if (axis->mode != WALL_STRESS)
            continue;
        watch->target_pa[c] = pressure_target_pa(axis, t);
        const double error = fabs(controlled_stress_pa(sample, axis, c) - watch->target_pa[c]);
        const double ratio = watch->target_pa[c] != 0 ? error / fabs(watch->target_pa[c]) : 0;
        watch->error_sum[c] += ratio;
        watch->error_max[c] = fmax(watch->error_max[c], ratio);
    }
}

static bool touches(const struct sample *sample, int c)
{
    return sample->walls[2 * c].touching + sample->walls[2 * c + 1].touching > 0;
}

static enum status opened(const struct sample *sample, int c, const char *why)
{
    const double start = sample->stage_position_m[2 * c + 1] - sample->stage_position_m[2 * c];
    return status_fail(STATUS_UNSTABLE,
                       "step %lld (t = %g s): the walls in %c %s; the box is %.3g times as long as at the start of the "
                       "stage",
                       (long long)sample->step, sample->time_s, "xyz"[sample_axis(sample, c)], why,
                       sample_box_length_m(sample, c) / start);
}

/* Walls under stress control that have nothing to hold them. */
static enum status opening_look(struct stability_watch *watch, const struct sample *sample)
{
    const struct scene_stage *stage = &sample->scene->stage[sample->stage];
    const double t = (double)sample->stage_step * sample->dt;
    for (int c = 0; c < sample->particles.dimension; c++) {
        const struct scene_axis *axis = &stage->axis[sample_axis(sample, c)];
        const double start = sample->stage_position_m[2 * c + 1] - sample->stage_position_m[2 * c];
        if (axis->mode != WALL_STRESS)
            continue;
        const bool pulls = pressure_target_pa(axis, t) < 0;
        const bool alone = pulls && !touches(sample, c);
        watch->pulled_on_nothing[c] = alone ? watch->pulled_on_nothing[c] + 1 : 0;
        if (watch->pulled_on_nothing[c] > STABILITY_WATCH_ALONE_MAX)
            return opened(sample, c, "pull (pressure_pa is negative) and touch nothing");
        if (sample_box_length_m(sample, c) > (pulls ? PULLED : GROWN) * start)
            return opened(sample, c,
                          pulls ? "pull (pressure_pa is negative) and nothing holds them"
                                : "have run apart: the pressure does not hold the sample together");
    }
    return STATUS_OK;
}

/* Walls that strains lead away from the sample; walls that both follow pressures, which may carry it off. */
static void place_look(struct stability_watch *watch, const struct sample *sample)
{
    const double *start = sample->stage_position_m;
    for (int c = 0; c < sample->particles.dimension; c++) {
        const struct scene_axis *axis = &sample->scene->stage[sample->stage].axis[sample_axis(sample, c)];
        const struct wall *lo = &sample->walls[2 * c], *hi = lo + 1;
        const bool touching = touches(sample, c);
        watch->touched[c] = touching || watch->touched[c] > 0;
        watch->left[c] = axis->mode == WALL_STRAIN && watch->touched[c] > 0 && !touching ? watch->left[c] + 1 : 0;
        if (axis->mode == WALL_STRESS && axis->opposite == OPPOSITE_CONSTANT)
            watch->drift[c] =
                0.5 * (lo->x + hi->x - start[2 * c] - start[2 * c + 1]) / (start[2 * c + 1] - start[2 * c]);
    }
}

enum status stability_watch_look(struct stability_watch *watch, struct sample *sample, double fastest,
                                 struct passing_watch *passing)
{
    const double inertial = measure_inertial_number(sample);
    watch->looks++;
    watch->inertial_sum += inertial;
    watch->inertial_max = fmax(watch->inertial_max, inertial);
    stress_look(watch, sample);
    place_look(watch, sample);
    watch->fastest_ratio = fmax(watch->fastest_ratio, fastest);
    TRY(stability_watch_look_at_contacts(watch, sample, passing));
    return opening_look(watch, sample);
}
