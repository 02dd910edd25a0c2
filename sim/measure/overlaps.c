#include "sim/measure/overlaps.h"

#include <math.h>

static double distance2_m2(const struct particles *p, int i, int j)
{
    double d2 = 0;
    for (int c = 0; c < p->dimension; c++) {
        const double d = p->x[c][i] - p->x[c][j];
        d2 += d * d;
    }
    return d2;
}

static void look_at_pairs(const struct sample *sample, struct passing_watch *passing, struct largest_overlap *largest)
{
    const struct particles *p = &sample->particles;
    for (int k = 0; k < sample->pairs.count; k++) {
        const int i = sample->pairs.i[k], j = sample->pairs.j[k];
        const double reach = p->radius[i] + p->radius[j], d2 = distance2_m2(p, i, j);
        if (d2 >= reach * reach)
            continue;
        const double overlap_m = reach - sqrt(d2), ratio = overlap_m / fmin(p->radius[i], p->radius[j]);
        if (ratio > largest->ratio)
            *largest = (struct largest_overlap){ratio, p->id[i], p->id[j]};
        if (passing)
            passing_watch_add(passing, sample, k, overlap_m / reach);
    }
}

static void look_at_walls(const struct sample *sample, struct largest_overlap *largest)
{
    const struct particles *p = &sample->particles;
    for (int w = 0; w < sample->n_walls; w++) {
        const struct wall *wall = &sample->walls[w];
        for (int k = 0; k < wall->contacts.count; k++) {
            const int i = wall->contacts.i[k];
            const double overlap = p->radius[i] - wall->inward * (p->x[wall->axis][i] - wall->x);
            if (overlap > largest->ratio * p->radius[i])
                *largest = (struct largest_overlap){overlap / p->radius[i], p->id[i], -1 - w};
        }
    }
}

enum status overlaps_look(struct sample *sample, struct passing_watch *passing, struct largest_overlap *largest)
{
    *largest = (struct largest_overlap){0};
    particles_export_positions(&sample->particles);
    if (passing)
        TRY(passing_watch_begin(passing, sample));
    look_at_pairs(sample, passing, largest);
    look_at_walls(sample, largest);
    if (passing)
        passing_watch_end(passing);
    return STATUS_OK;
}

double overlaps_of_fastest(const struct sample *sample)
{
    const struct particles *p = &sample->particles;
    const struct scene_material *m = sample->material;
    const double k = m->law == LAW_HYSTERETIC ? m->k1_n_per_m : sample->law.stiffness; /* that of loading */
    double largest = 0;
    for (int i = 0; i < p->count; i++) {
        double v2 = 0;
        for (int c = 0; c < p->dimension; c++)
            v2 += particles_velocity(p, c, i) * particles_velocity(p, c, i);
        /* against one of its own kind that comes with the same speed: 2 v sqrt(m/2 / k) */
        largest = fmax(largest, 2 * v2 * p->mass[i] / (k * p->radius[i] * p->radius[i]));
    }
    return sqrt(largest);
}
