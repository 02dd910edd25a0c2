#include <math.h>
#include <stdio.h>

#include "common/scene_check.h"

/* Where a complaint belongs. */
struct place {
    const struct scene *scene;
    const config_setting_t *root, *at;
    char path[128]; /* of the axis */
    char axis[2];   /* its name */
    const struct scene_stage *stage;
};

/* Whether the file says `key` for the axis, in the stage or for all of them. */
static bool is_given(const struct place *place, const char *key)
{
    const config_setting_t *from[] = {place->at, place->root};
    for (int k = 0; k < 2; k++) {
        const config_setting_t *walls = config_setting_get_member(from[k], "walls");
        const config_setting_t *group = walls ? config_setting_get_member(walls, place->axis) : NULL;
        if (group && config_setting_get_member(group, key))
            return true;
    }
    return false;
}

static enum status table_check(const struct place *place, const struct scene_axis *a,
                               const struct config_floats *values, const char *name)
{
    const struct config_floats *times = &a->times_s;
    if (times->count < 2 || times->count != values->count)
        return config_fail(place->at, place->path, "a table needs times_s and %s, two or more of each (here %d and %d)",
                           name, (int)times->count, (int)values->count);
    if (times->value[0] != 0)
        return config_fail(place->at, place->path, "times_s begins at %g; allowed: 0", times->value[0]);
    for (int k = 1; k < times->count; k++)
        if (!(times->value[k] > times->value[k - 1]))
            return config_fail(place->at, place->path, "times_s: %g comes after %g; allowed: increasing times",
                               times->value[k], times->value[k - 1]);
    return STATUS_OK;
}

static enum status rate_check(const struct place *place, const struct scene_axis *a)
{
    if (a->rate_per_s == 0)
        return config_fail(place->at, place->path, "course \"rate\" needs rate_per_s");
    if (a->strain * a->rate_per_s < 0)
        return config_fail(place->at, place->path, "strain (%g) and rate_per_s (%g) must be of one sign", a->strain,
                           a->rate_per_s);
    return STATUS_OK;
}

static enum status strain_check(const struct place *place, const struct scene_axis *a)
{
    static const char *const names[] = {"smooth", "rate", "cosine", "triangle"};
    if (a->course == COURSE_RATE)
        return rate_check(place, a);
    if (a->course == COURSE_TABLE) {
        TRY(table_check(place, a, &a->strains, "strains"));
        if (a->strains.value[0] != 0)
            return config_fail(place->at, place->path, "strains begins at %g; allowed: 0, where the stage starts",
                               a->strains.value[0]);
        return STATUS_OK;
    }
    if (!(a->frequency_hz > 0))
        return config_fail(place->at, place->path, "mode \"strain\" needs frequency_hz above 0 (course \"%s\")",
                           names[a->course]);
    if (a->course != COURSE_SMOOTH && a->strain == 0)
        return config_fail(place->at, place->path, "strain cycles need an amplitude, strain");
    return STATUS_OK;
}

static enum status target_check(const struct place *place, const struct scene_axis *a)
{
    if (a->target == TARGET_TABLE)
        return table_check(place, a, &a->pressures_pa, "pressures_pa");
    if (a->target == TARGET_RAMP && !(a->ramp_s > 0))
        return config_fail(place->at, place->path, "target \"ramp\" needs ramp_s above 0");
    const bool cycles = a->target == TARGET_COSINE || a->target == TARGET_TRIANGLE;
    if (cycles && !(a->period_s > 0))
        return config_fail(place->at, place->path, "target \"%s\" needs period_s above 0",
                           a->target == TARGET_COSINE ? "cosine" : "triangle");
    if (cycles && !is_given(place, "amplitude_pa"))
        return config_fail(place->at, place->path, "stress cycles need amplitude_pa");
    if (a->target == TARGET_RAMP && !is_given(place, "pressure_end_pa"))
        return config_fail(place->at, place->path, "target \"ramp\" needs pressure_end_pa");
    return STATUS_OK;
}

/* A wall that answers forces. A pressure that was forgotten would open the box. */
static enum status stress_check(const struct place *place, const struct scene_axis *a, const char *mode)
{
    if (!(a->mass_kg > 0 || a->damping_kg_per_s > 0))
        return config_fail(place->at, place->path, "%s needs mass_kg or damping_kg_per_s above 0", mode);
    const bool timed = scene_axis_has_target(a);
    if (timed)
        TRY(target_check(place, a));
    const bool table = timed && a->target == TARGET_TABLE && a->opposite != OPPOSITE_CONSTANT;
    if (!table && !(a->mode == WALL_COUPLED && a->keep == KEEP_B) && !is_given(place, "pressure_pa"))
        return config_fail(place->at, place->path, "%s needs pressure_pa; 0.0 is a free wall", mode);
    return STATUS_OK;
}

/* Slopes at which the stress that follows from the others is none, or goes against what it answers. While z is strained
 * below q = constant the lateral walls would have to change their stress by more than sigma_zz changes; but they
 * change sigma_zz by nearly as much as their own, and run away from each other (or into the sample). */
static enum status path_check(const struct place *place, const struct scene_axis *a, bool axial)
{
    const double drained = place->scene->dimension == 3 ? 3 : 2;
    const double least = place->scene->dimension == 3 ? -1.5 : -2;
    const bool strained = place->stage->axis[AXIS_Z].mode == WALL_STRAIN;
    if (axial ? a->dq_dp < drained : a->dq_dp >= 0 || (!strained && a->dq_dp > least))
        return STATUS_OK;
    if (!axial && a->dq_dp > least)
        return config_fail(place->at, place->path,
                           "dq_dp = %g cannot be kept by lateral walls while z is strained; allowed: 0 and more, or "
                           "lateral walls with a stress of their own (a ramp) and keep = \"path\" in z",
                           a->dq_dp);
    return config_fail(place->at, place->path,
                       "dq_dp = %g cannot be kept by this axis; allowed: %s %g (%g is the drained "
                       "path, dp = 0 is keep = \"p\")",
                       a->dq_dp, axial ? "below" : "above", axial ? drained : least, drained);
}

static enum status coupled_check(const struct place *place, const struct scene_axis *a, bool axial)
{
    static const char *const names[] = {"keep = \"volume\"", "keep = \"p\"", "keep = \"q\"", "keep = \"b\"",
                                        "keep = \"path\""};
    if (a->opposite == OPPOSITE_CONSTANT)
        return config_fail(place->at, place->path,
                           "opposite \"constant\" goes with mode \"stress\"; allowed here: "
                           "\"fixed\", \"mirror\"");
    if (a->keep == KEEP_VOLUME)
        return STATUS_OK;
    if (a->keep == KEEP_Q && !axial)
        return config_fail(place->at, place->path, "keep = \"q\" is for walls.z");
    if (a->keep == KEEP_B && place->axis[0] != 'y')
        return config_fail(place->at, place->path, "keep = \"b\" is for walls.y of a 3D scene");
    if (a->keep == KEEP_PATH)
        TRY(path_check(place, a, axial));
    return stress_check(place, a, names[a->keep]);
}

static enum status axis_check(const struct place *place, const struct scene_axis *a, bool axial)
{
    if (a->mode == WALL_STRAIN && a->opposite == OPPOSITE_CONSTANT)
        return config_fail(place->at, place->path,
                           "opposite \"constant\" goes with mode \"stress\"; allowed here: \"fixed\", \"mirror\"");
    switch (a->mode) {
    case WALL_STRAIN:
        return strain_check(place, a);
    case WALL_STRESS:
        return stress_check(place, a, "mode \"stress\"");
    case WALL_COUPLED:
        return coupled_check(place, a, axial);
    default:
        return STATUS_OK;
    }
}

/* Two axes that keep one thing must mean the same by it; and one axis at least is not coupled, or keeps q. */
static enum status couplings_check(const struct place *place, const char *where)
{
    const struct scene_axis *first = NULL;
    int coupled = 0;
    for (int k = 0; k < SCENE_AXES; k++) {
        const struct scene_axis *a = &place->stage->axis[k];
        if (a->mode != WALL_COUPLED)
            continue;
        coupled += a->keep != KEEP_Q;
        if (a->keep != KEEP_P && a->keep != KEEP_PATH)
            continue;
        if (first && (first->keep != a->keep || first->target != a->target || first->pressure_pa != a->pressure_pa ||
                      first->dq_dp != a->dq_dp || first->deviator_pa != a->deviator_pa))
            return config_fail(place->at, where,
                               "two coupled axes must keep the same: keep, target, pressure_pa, dq_dp "
                               "and deviator_pa differ");
        first = a;
    }
    if (coupled == place->scene->dimension)
        return config_fail(place->at, where, "all axes are coupled: one must move by itself, or rest");
    return STATUS_OK;
}

enum status scene_check_walls(const struct scene *scene, const struct scene_stage *stage, const config_setting_t *root,
                              const config_setting_t *at, const char *where)
{
    for (int k = 0; k < SCENE_AXES; k++) {
        struct place place = {.scene = scene, .root = root, .at = at, .axis = {"xyz"[k], '\0'}, .stage = stage};
        snprintf(place.path, sizeof place.path, "%s.walls.%c", where, "xyz"[k]);
        if (scene->dimension == 2 && k == AXIS_Y && stage->axis[k].mode != WALL_FIXED)
            return config_fail(at, place.path, "a 2D scene has no walls in y");
        TRY(axis_check(&place, &stage->axis[k], k == AXIS_Z));
    }
    const struct place place = {.scene = scene, .at = at, .stage = stage};
    return couplings_check(&place, where);
}

/* Within the strain, and in the order in which they are passed. */
static enum status frame_strains_check(const struct scene_stage *stage, const config_setting_t *at, const char *where)
{
    const struct config_floats *list = &stage->frame_strains;
    const struct scene_axis *axis = NULL;
    int strained = 0;
    for (int k = 0; k < SCENE_AXES; k++)
        if (stage->axis[k].mode == WALL_STRAIN) {
            axis = &stage->axis[k];
            strained++;
        }
    if (list->count == 0)
        return STATUS_OK;
    if (strained != 1)
        return config_fail(at, where, "frame_strains needs exactly one strain-controlled axis (here %d)", strained);
    if (axis->course != COURSE_SMOOTH && !(axis->course == COURSE_RATE && axis->strain != 0))
        return config_fail(at, where,
                           "frame_strains needs a course that leads to a strain, \"smooth\" or \"rate\"; "
                           "otherwise frame_interval_s");
    const double sign = axis->strain < 0 ? -1 : 1;
    double before = 0;
    for (int k = 0; k < list->count; k++) {
        if (!(sign * list->value[k] <= sign * axis->strain))
            return config_fail(at, where, "frame_strains: %g is never reached; allowed: from 0 to %g", list->value[k],
                               axis->strain);
        if (!(sign * list->value[k] >= sign * before))
            return config_fail(at, where, "frame_strains: %g comes after %g; they are passed from 0 to %g",
                               list->value[k], before, axis->strain);
        before = list->value[k];
    }
    return STATUS_OK;
}

static double last_target_pa(const struct scene_axis *a)
{
    if (a->target == TARGET_TABLE)
        return a->pressures_pa.value[a->pressures_pa.count - 1];
    return a->target == TARGET_RAMP ? a->pressure_end_pa : a->pressure_pa;
}

/* A fraction of nothing is never met. */
static enum status stress_error_check(const struct scene_stage *stage, const config_setting_t *at, const char *where)
{
    int controlled = 0;
    if (!(stage->until_stress_error > 0))
        return STATUS_OK;
    for (int k = 0; k < SCENE_AXES; k++) {
        const struct scene_axis *a = &stage->axis[k];
        controlled += a->mode == WALL_STRESS || (a->mode == WALL_COUPLED && a->keep != KEEP_VOLUME);
        if (a->mode == WALL_STRESS && last_target_pa(a) == 0 && !(stage->stress_tolerance_pa > 0))
            return config_fail(at, where,
                               "until_stress_error is a fraction of the target, which is 0 in walls.%c: never met; "
                               "stress_tolerance_pa says what is near enough",
                               "xyz"[k]);
    }
    if (controlled == 0)
        return config_fail(at, where, "until_stress_error needs a stress-controlled axis");
    return STATUS_OK;
}

static enum status conditions_check(const struct scene_stage *stage, const config_setting_t *at, const char *where)
{
    double period_s = 0;
    for (int k = 0; k < SCENE_AXES; k++)
        period_s = fmax(period_s, scene_axis_period_s(&stage->axis[k]));
    if (stage->until_cycles > 0 && !(period_s > 0))
        return config_fail(at, where, "until_cycles needs an axis with cycles of strain or stress");
    if (stage->until_r_u > 0 && !(stage->reference_pressure_pa > 0))
        return config_fail(at, where, "until_r_u needs reference_pressure_pa above 0: p before the test");
    return stress_error_check(stage, at, where);
}

enum status scene_check_stage(const struct scene_stage *stage, const config_setting_t *at, const char *where)
{
    if (!(stage->duration_s > 0))
        return config_fail(at, where, "duration_s: missing; nothing else in the stage says how long it is");
    if (!(stage->duration_s >= stage->dt_s))
        return config_fail(at, where, "duration_s (%g) must be at least dt_s (%g)", stage->duration_s, stage->dt_s);
    if (stage->duration_s / stage->dt_s > 1e12)
        return config_fail(at, where, "duration_s/dt_s is above 1e12 steps");
    TRY(frame_strains_check(stage, at, where));
    return conditions_check(stage, at, where);
}
