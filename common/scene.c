#include "common/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void scene_free(struct scene *scene)
{
    free(scene->text);
    free(scene->stage);
    free(scene->prepared);
    free(scene->source);
    scene->text = NULL;
    scene->source = NULL;
    scene->prepared = NULL;
    scene->stage = NULL;
    scene->n_stages = 0;
}

/* axis < 0: particles among themselves; else on the walls of the axis. */
static bool is_frictional(const struct scene_stage *stage, int axis)
{
    struct scene_material of_walls;
    if (axis < 0)
        return stage->material.mu_s > 0;
    return scene_wall_material(stage, (enum axis)axis, &of_walls) && of_walls.mu_s > 0;
}

bool scene_is_frictional(const struct scene *scene)
{
    bool any = false;
    for (int k = 0; k < scene->n_stages; k++)
        for (int axis = -1; axis < SCENE_AXES; axis++)
            any = any || is_frictional(&scene->stage[k], axis);
    return any;
}

/* The largest coefficients of rolling and torsion of particles and walls in any stage. */
static void largest_resistance(const struct scene *scene, double *rolling, double *torsion)
{
    *rolling = *torsion = 0;
    for (int k = 0; k < scene->n_stages; k++)
        for (int axis = 0; axis < SCENE_AXES; axis++) {
            const struct scene_material *m = &scene->stage[k].material;
            struct scene_material of_walls;
            (void)scene_wall_material(&scene->stage[k], (enum axis)axis, &of_walls);
            *rolling = fmax(*rolling, fmax(m->mu_rolling, of_walls.mu_rolling));
            *torsion = fmax(*torsion, fmax(m->mu_torsion, of_walls.mu_torsion));
        }
}

bool scene_resists_rolling(const struct scene *scene)
{
    double rolling, torsion;
    largest_resistance(scene, &rolling, &torsion);
    return rolling > 0 || torsion > 0;
}

bool scene_resists_torsion(const struct scene *scene)
{
    double rolling, torsion;
    largest_resistance(scene, &rolling, &torsion);
    return torsion > 0;
}

bool scene_is_hysteretic(const struct scene *scene)
{
    bool any = false;
    for (int k = 0; k < scene->n_stages; k++)
        any = any || scene->stage[k].material.law == LAW_HYSTERETIC;
    return any;
}

int scene_wall_count(const struct scene *scene)
{
    return 2 * (int)scene->dimension;
}

enum axis scene_pair_axis(const struct scene *scene, int pair)
{
    return scene->dimension == 3 ? (enum axis)pair : (pair == 0 ? AXIS_X : AXIS_Z);
}

int scene_stage_find(const struct scene *scene, const char *name)
{
    if (!name[0])
        return (int)scene->n_stages - 1;
    for (int k = 0; k < scene->n_stages; k++)
        if (strcmp(scene->stage[k].name, name) == 0)
            return k;
    return -1;
}

double scene_total_time_s(const struct scene *scene)
{
    double total = 0;
    for (int k = 0; k < scene->n_stages; k++)
        total += scene->stage[k].duration_s;
    return total;
}

const char *scene_law_name(int law)
{
    static const char *const names[] = {
#define CONTACT_LAW_NAME(name, NAME) #name,
        CONTACT_LAWS(CONTACT_LAW_NAME)
#undef CONTACT_LAW_NAME
    };
    return names[law];
}

bool scene_axis_has_target(const struct scene_axis *axis)
{
    const bool keeps = axis->mode == WALL_COUPLED && (axis->keep == KEEP_P || axis->keep == KEEP_Q);
    return axis->mode == WALL_STRESS || keeps;
}

double scene_axis_period_s(const struct scene_axis *axis)
{
    if (axis->mode == WALL_STRAIN && (axis->course == COURSE_COSINE || axis->course == COURSE_TRIANGLE))
        return 1 / axis->frequency_hz;
    return scene_axis_has_target(axis) && (axis->target == TARGET_COSINE || axis->target == TARGET_TRIANGLE)
               ? axis->period_s
               : 0;
}

double scene_axis_rate_end_s(const struct scene_axis *axis)
{
    const double steady_s = axis->strain / axis->rate_per_s; /* of one sign: checked */
    return steady_s > 0.5 * axis->rise_s ? steady_s + 0.5 * axis->rise_s : sqrt(2 * axis->rise_s * steady_s);
}

double scene_axis_length_s(const struct scene_axis *axis)
{
    const double last_s = axis->times_s.count > 0 ? axis->times_s.value[axis->times_s.count - 1] : 0;
    if (scene_axis_has_target(axis))
        return axis->target == TARGET_RAMP ? axis->ramp_s : axis->target == TARGET_TABLE ? last_s : 0;
    if (axis->mode != WALL_STRAIN)
        return 0;
    switch (axis->course) {
    case COURSE_SMOOTH:
        return 0.5 / axis->frequency_hz;
    case COURSE_RATE:
        return axis->strain != 0 ? scene_axis_rate_end_s(axis) : 0;
    case COURSE_TABLE:
        return last_s;
    default:
        return 0;
    }
}

double scene_axis_largest_strain(const struct scene_axis *axis, double duration_s)
{
    double largest = 0;
    if (axis->mode != WALL_STRAIN)
        return 0;
    if (axis->course == COURSE_TABLE) {
        for (int k = 0; k < axis->strains.count; k++)
            largest = fmax(largest, axis->strains.value[k]);
        return largest;
    }
    if (axis->course == COURSE_SMOOTH || (axis->course == COURSE_RATE && axis->strain != 0))
        return fmax(0, axis->strain);
    if (axis->course == COURSE_RATE)
        return 0; /* without an end, until a condition ends the stage */
    const double grown =
        axis->strain_growth * floor(floor(duration_s * axis->frequency_hz) / (double)axis->growth_cycles);
    const double amplitude = fabs(axis->strain) > fabs(axis->strain + grown) ? axis->strain : axis->strain + grown;
    return axis->two_way ? fabs(amplitude) : fmax(0, amplitude);
}

void scene_stage_place(const struct scene *scene, const struct scene_stage *stage, char *text, size_t size)
{
    if (stage->line > 0)
        snprintf(text, size, "%s:%d: stage \"%s\"", scene->source, stage->line, stage->name);
    else
        snprintf(text, size, "%s: stage \"%s\"", scene->source, stage->name);
}
