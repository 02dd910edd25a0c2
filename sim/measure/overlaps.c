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

struct largest_overlap overlaps_largest(struct sample *sample)
{
    struct particles *p = &sample->particles;
    struct largest_overlap largest = {0};
    particles_export_positions(p);
    for (int k = 0; k < sample->pairs.count; k++) {
        const int i = sample->pairs.i[k], j = sample->pairs.j[k];
        const double reach = p->radius[i] + p->radius[j], d2 = distance2_m2(p, i, j);
        if (d2 >= reach * reach)
            continue;
        const double ratio = (reach - sqrt(d2)) / fmin(p->radius[i], p->radius[j]);
        if (ratio > largest.ratio)
            largest = (struct largest_overlap){ratio, p->id[i], p->id[j]};
    }
    for (int w = 0; w < sample->n_walls; w++) {
        const struct wall *wall = &sample->walls[w];
        for (int k = 0; k < wall->contacts.count; k++) {
            const int i = wall->contacts.i[k];
            const double overlap = p->radius[i] - wall->inward * (p->x[wall->axis][i] - wall->x);
            if (overlap > largest.ratio * p->radius[i])
                largest = (struct largest_overlap){overlap / p->radius[i], p->id[i], -1 - w};
        }
    }
    return largest;
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
