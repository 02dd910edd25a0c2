#include "common/scene_check.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Least part of a Gaussian between its cut-offs. */
static const double GAUSSIAN_PART = 1e-3;

/* Checks between the keys of one material; `where` is its path. */
static enum status material_check(const struct scene_material *m, const config_setting_t *at, const char *where)
{
    if (m->law == LAW_LINEAR && !(m->kn_n_per_m > 0))
        return config_fail(at, where, "law \"linear\" needs kn_n_per_m above 0");
    if (m->law == LAW_LINEAR && (m->k1_n_per_m > 0 || m->k2_n_per_m > 0 || m->kc_n_per_m > 0))
        return config_fail(at, where, "k1, k2 and kc belong to law \"hysteretic\"; law \"linear\" takes kn_n_per_m");
    if (m->law == LAW_HYSTERETIC && !(m->k1_n_per_m > 0 && m->k2_n_per_m >= m->k1_n_per_m))
        return config_fail(at, where, "law \"hysteretic\" needs 0 < k1_n_per_m <= k2_n_per_m (here %g and %g)",
                           m->k1_n_per_m, m->k2_n_per_m);
    if (m->law == LAW_HYSTERETIC && m->kn_n_per_m > 0)
        return config_fail(at, where, "kn_n_per_m belongs to law \"linear\"; law \"hysteretic\" takes k1 and k2");
    if (m->mu_d < 0 && m->mu_d != -1.0)
        return config_fail(at, where, "mu_d (%g) must not be negative; only -1 stands for mu_s", m->mu_d);
    if (m->mu_d > m->mu_s)
        return config_fail(at, where, "mu_d (%g) must not exceed mu_s (%g)", m->mu_d, m->mu_s);
    if (m->mu_s > 0 && !(m->kt_n_per_m > 0))
        return config_fail(at, where, "friction (mu_s above 0) needs kt_n_per_m above 0");
    return STATUS_OK;
}

/* Whether the file says `key` for an axis ("x"), in the stage or for all of them. */
static bool is_given(const config_setting_t *root, const config_setting_t *stage, const char *axis, const char *key)
{
    const config_setting_t *from[] = {stage, root};
    for (int k = 0; k < 2; k++) {
        const config_setting_t *walls = config_setting_get_member(from[k], "walls");
        const config_setting_t *group = walls ? config_setting_get_member(walls, axis) : NULL;
        if (group && config_setting_get_member(group, key))
            return true;
    }
    return false;
}

static enum status stress_check(const struct scene_axis *a, const config_setting_t *at, const char *where)
{
    if (!(a->mass_kg > 0 || a->damping_kg_per_s > 0))
        return config_fail(at, where, "mode \"stress\" needs mass_kg or damping_kg_per_s above 0");
    if (a->target == TARGET_RAMP && !(a->ramp_s > 0))
        return config_fail(at, where, "target \"ramp\" needs ramp_s above 0");
    if (a->target == TARGET_COSINE && !(a->period_s > 0))
        return config_fail(at, where, "target \"cosine\" needs period_s above 0");
    return STATUS_OK;
}

static enum status axis_check(const struct scene_axis *a, const config_setting_t *at, const char *where)
{
    if (a->mode == WALL_STRAIN && !(a->frequency_hz > 0))
        return config_fail(at, where, "mode \"strain\" needs frequency_hz above 0");
    if (a->mode == WALL_STRAIN && a->opposite == OPPOSITE_CONSTANT)
        return config_fail(at, where,
                           "opposite \"constant\" goes with mode \"stress\"; allowed here: \"fixed\", "
                           "\"mirror\"");
    return a->mode == WALL_STRESS ? stress_check(a, at, where) : STATUS_OK;
}

/* A pressure that was forgotten would be a wall that opens the box. */
static enum status pressure_check(const struct scene_axis *a, const char *axis, const config_setting_t *root,
                                  const config_setting_t *at, const char *where)
{
    if (a->mode != WALL_STRESS)
        return STATUS_OK;
    if (!is_given(root, at, axis, "pressure_pa"))
        return config_fail(at, where, "mode \"stress\" needs pressure_pa; 0.0 is a free wall");
    if (a->target == TARGET_RAMP && !is_given(root, at, axis, "pressure_end_pa"))
        return config_fail(at, where, "target \"ramp\" needs pressure_end_pa");
    if (a->target == TARGET_COSINE && !is_given(root, at, axis, "amplitude_pa"))
        return config_fail(at, where, "target \"cosine\" needs amplitude_pa");
    return STATUS_OK;
}

/* Within the strain, and in the order in which they are passed. */
static enum status frame_strains_check(const struct scene_stage *stage, int strained, const config_setting_t *at,
                                       const char *where)
{
    const struct config_floats *list = &stage->frame_strains;
    double end = 0, before = 0;
    if (list->count > 0 && strained != 1)
        return config_fail(at, where, "frame_strains needs exactly one strain-controlled axis (here %d)", strained);
    for (int k = 0; k < SCENE_AXES; k++)
        end += stage->axis[k].mode == WALL_STRAIN ? stage->axis[k].strain : 0;
    const double sign = end < 0 ? -1 : 1;
    for (int k = 0; k < list->count; k++) {
        if (!(sign * list->value[k] <= sign * end))
            return config_fail(at, where, "frame_strains: %g is never reached; allowed: from 0 to %g", list->value[k],
                               end);
        if (!(sign * list->value[k] >= sign * before))
            return config_fail(at, where, "frame_strains: %g comes after %g; they are passed from 0 to %g",
                               list->value[k], before, end);
        before = list->value[k];
    }
    return STATUS_OK;
}

/* A fraction of nothing is never met. */
static enum status stress_error_check(const struct scene *scene, const struct scene_stage *stage,
                                      const config_setting_t *at, const char *where)
{
    if (!(stage->until_stress_error > 0) || stage->stress_tolerance_pa > 0)
        return STATUS_OK;
    for (int k = 0; k < SCENE_AXES; k++) {
        const struct scene_axis *a = &stage->axis[k];
        const bool zero = a->target == TARGET_RAMP ? a->pressure_end_pa == 0 : a->pressure_pa == 0;
        if (a->mode == WALL_STRESS && zero && !(scene->dimension == 2 && k == AXIS_Y))
            return config_fail(at, where,
                               "until_stress_error is a fraction of the target, which is 0 in walls.%c: never met; "
                               "stress_tolerance_pa says what is near enough",
                               "xyz"[k]);
    }
    return STATUS_OK;
}

enum status scene_check_stage(const struct scene *scene, const struct scene_stage *stage, const config_setting_t *root,
                              const config_setting_t *at, const char *where)
{
    char path[128];
    if (!(stage->duration_s >= stage->dt_s))
        return config_fail(at, where, "duration_s (%g) must be at least dt_s (%g)", stage->duration_s, stage->dt_s);
    if (stage->duration_s / stage->dt_s > 1e12)
        return config_fail(at, where, "duration_s/dt_s is above 1e12 steps");
    snprintf(path, sizeof path, "%s.material", where);
    TRY(material_check(&stage->material, at, path));
    int strained = 0;
    for (int k = 0; k < SCENE_AXES; k++) {
        snprintf(path, sizeof path, "%s.walls.%c", where, "xyz"[k]);
        if (scene->dimension == 2 && k == AXIS_Y && stage->axis[k].mode != WALL_FIXED)
            return config_fail(at, path, "a 2D scene has no walls in y");
        TRY(axis_check(&stage->axis[k], at, path));
        TRY(pressure_check(&stage->axis[k], (const char[]){"xyz"[k], '\0'}, root, at, path));
        strained += stage->axis[k].mode == WALL_STRAIN;
    }
    TRY(frame_strains_check(stage, strained, at, where));
    return stress_error_check(scene, stage, at, where);
}

/* Cut so narrowly, a distribution is drawn from for ever. */
static double gaussian_part(const struct scene_sample *s)
{
    double scale = 1 / (s->radius_sd_m * sqrt(2));
    return 0.5 *
           (erf((s->radius_max_m - s->radius_mean_m) * scale) - erf((s->radius_min_m - s->radius_mean_m) * scale));
}

enum status scene_check_sample(const struct scene_sample *sample, const config_setting_t *at)
{
    if (sample->radius_max_m < sample->radius_min_m)
        return config_fail(at, "sample", "radius_max_m (%g) must be at least radius_min_m (%g)", sample->radius_max_m,
                           sample->radius_min_m);
    if (sample->radius_distribution == RADIUS_GAUSSIAN &&
        !(sample->radius_sd_m > 0 && sample->radius_mean_m >= sample->radius_min_m &&
          sample->radius_mean_m <= sample->radius_max_m))
        return config_fail(at, "sample",
                           "gaussian radii need radius_sd_m above 0 and radius_mean_m between the cut-offs");
    if (sample->radius_distribution == RADIUS_GAUSSIAN && !(gaussian_part(sample) >= GAUSSIAN_PART))
        return config_fail(at, "sample",
                           "gaussian radii: only %g of them lie between radius_min_m and radius_max_m; allowed: at "
                           "least %g. For one size, or a narrow range, take radius_distribution = \"uniform\"",
                           gaussian_part(sample), GAUSSIAN_PART);
    if (sample->initial == INITIAL_CHECKPOINT && !sample->checkpoint[0])
        return config_fail(at, "sample", "initial = \"checkpoint\" needs the path in checkpoint");
    return STATUS_OK;
}

/* What a name is in that of a checkpoint. */
static char file_character(char c)
{
    return c == '/' ? '_' : c;
}

static bool same_file(const char *a, const char *b)
{
    while (*a && file_character(*a) == file_character(*b))
        a++, b++;
    return file_character(*a) == file_character(*b);
}

enum status scene_check_name(const struct scene *scene, int64_t index, const config_setting_t *at, const char *where)
{
    enum { NAME_LONGEST = 200 }; /* of a file: 255 */
    const char *name = scene->stage[index].name;
    if (!name[0] || strlen(name) > NAME_LONGEST)
        return config_fail(at, where, "name has %zu characters; allowed: 1 to %d", strlen(name), NAME_LONGEST);
    for (int64_t k = 0; k < index; k++)
        if (same_file(name, scene->stage[k].name))
            return config_fail(at, where,
                               "name \"%s\": there is a stage \"%s\" already, and each writes a checkpoint-NAME.h5 "
                               "(with _ for /)",
                               name, scene->stage[k].name);
    return STATUS_OK;
}
