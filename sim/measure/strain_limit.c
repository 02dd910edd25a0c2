#include "sim/measure/strain_limit.h"

#include <math.h>
#include <stdio.h>

double strain_limit_solid_fraction(int dimension, double overlap_ratio)
{
    return overlap_ratio < 2 ? pow(1 - 0.5 * overlap_ratio, -dimension) : INFINITY;
}

/* "walls.x.strain = 0.3, walls.z.strain = 0.5" */
static void strains_text(const struct sample *sample, const struct scene_stage *stage, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (int c = 0; c < sample->particles.dimension && used < size; c++) {
        const enum axis name = sample_axis(sample, c);
        const double strain = scene_axis_largest_strain(&stage->axis[name], stage->duration_s);
        if (strain > 0)
            used += (size_t)snprintf(text + used, size - used, "%swalls.%c.strain = %g", used ? ", " : "", "xyz"[name],
                                     strain);
    }
}

/* Lengths of the box at the end of the stage; false: they are not known. `smallest`: at its densest. */
static bool lengths_after(const struct sample *sample, const struct scene_stage *stage, double *length,
                          double *smallest)
{
    bool known = true;
    *smallest = 1;
    for (int c = 0; c < sample->particles.dimension; c++) {
        const struct scene_axis *axis = &stage->axis[sample_axis(sample, c)];
        const bool strained = axis->mode == WALL_STRAIN;
        known = known && (strained || axis->mode == WALL_FIXED);
        *smallest *= length[c] * (1 - scene_axis_largest_strain(axis, stage->duration_s));
        if (!strained)
            continue;
        /* cycles, tables, and a rate without an end: where they end is not looked at here */
        known = known && (axis->course == COURSE_SMOOTH || (axis->course == COURSE_RATE && axis->strain != 0));
        length[c] *= 1 - axis->strain;
    }
    return known;
}

/* Walls that answer stresses, or a condition that may end the stage before it has come to its strain. */
static bool may_give_way(const struct sample *sample, const struct scene_stage *stage)
{
    bool any = stage->until_energy_ratio > 0 || stage->until_stress_error > 0 || stage->until_q_pa.count > 0 ||
               stage->until_q_over_p.count > 0 || stage->until_r_u > 0;
    for (int c = 0; c < sample->particles.dimension; c++) {
        const struct scene_axis *axis = &stage->axis[sample_axis(sample, c)];
        any = any || (axis->mode != WALL_STRAIN && axis->mode != WALL_FIXED) || axis->until_strain.count > 0 ||
              axis->until_stress_pa.count > 0;
    }
    return any;
}

enum status strain_limit_check(const struct sample *sample, int first)
{
    const int dimension = sample->particles.dimension;
    const double solid = particles_solid_volume(&sample->particles);
    double length[3], smallest;
    bool known = true;
    for (int c = 0; c < dimension; c++)
        length[c] = sample_box_length_m(sample, c);
    for (int s = first; s < sample->scene->n_stages && known; s++) {
        const struct scene_stage *stage = &sample->scene->stage[s];
        const double bears = strain_limit_solid_fraction(dimension, stage->limits.overlap_ratio);
        char strains[128], place[256];
        if (may_give_way(sample, stage))
            return STATUS_OK;
        known = lengths_after(sample, stage, length, &smallest);
        if (solid <= bears * smallest)
            continue;
        strains_text(sample, stage, strains, sizeof strains);
        scene_stage_place(sample->scene, stage, place, sizeof place);
        return status_fail(
            STATUS_CONFIG,
            "%s: %s would make the box smaller than the particles bear: a solid fraction of %.3g, with no "
            "wall that gives way; up to %.3g is possible within limits.overlap_ratio = %g. A smaller "
            "strain, or a wall under stress, would do",
            place, strains, solid / smallest, bears, stage->limits.overlap_ratio);
    }
    return STATUS_OK;
}
