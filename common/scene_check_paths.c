#include "common/scene_check.h"

#include <math.h>
#include <stdio.h>

/* What an axis is to do must fit into the stage, but for what rounding makes of its steps. */
static enum status length_check(const struct scene_stage *stage, const struct scene_axis *axis, const char *place)
{
    const int64_t cycles = stage->until_cycles > 0 ? stage->until_cycles : 1;
    const double path_s = scene_axis_length_s(axis), cycles_s = scene_axis_period_s(axis) * (double)cycles;
    const double length_s = stage->duration_s + stage->dt_s;
    if (stage->cut_path)
        return STATUS_OK;
    if (path_s > length_s)
        return status_fail(STATUS_CONFIG,
                           "%s: the path takes %g s, but the stage ends at duration_s = %g; a quicker path or a longer "
                           "stage would fit, cut_path = true would cut it",
                           place, path_s, stage->duration_s);
    if (cycles_s > length_s)
        return status_fail(STATUS_CONFIG,
                           "%s: %lld %s %g s, but the stage ends at duration_s = %g; shorter cycles or a longer stage "
                           "would fit, cut_path = true would cut them",
                           place, (long long)cycles, cycles > 1 ? "cycles take" : "cycle takes", cycles_s,
                           stage->duration_s);
    return STATUS_OK;
}

/* With fewer than two exchanges in a period walls would follow a slower cycle (aliasing). */
static enum status exchanges_check(const struct scene_coupling *coupling, const struct scene_stage *stage,
                                   const struct scene_axis *axis, const char *place)
{
    const double period_s = scene_axis_period_s(axis), interval_s = (double)coupling->interval_steps * stage->dt_s;
    if (!(period_s > 0 && period_s < 2 * interval_s))
        return STATUS_OK;
    return status_fail(
        STATUS_CONFIG,
        "%s: cycles of %g s are shorter than two exchanges (coupling.interval_steps = %lld of dt_s = %.3g s); "
        "longer cycles would do, or shorter exchanges",
        place, period_s, (long long)coupling->interval_steps, stage->dt_s);
}

enum status scene_check_paths(const struct scene *scene)
{
    for (int s = 0; s < scene->n_stages; s++)
        for (int k = 0; k < SCENE_AXES; k++) {
            const struct scene_stage *stage = &scene->stage[s];
            char place[300], at[256];
            scene_stage_place(scene, stage, at, sizeof at);
            snprintf(place, sizeof place, "%s: walls.%c", at, "xyz"[k]);
            TRY(length_check(stage, &stage->axis[k], place));
            TRY(exchanges_check(&scene->coupling, stage, &stage->axis[k], place));
        }
    return STATUS_OK;
}
