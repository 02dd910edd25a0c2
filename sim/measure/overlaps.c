#include "sim/measure/overlaps.h"

#include <math.h>

/* `dimension` is known where this is compiled: it is inlined. */
static inline double distance2_m2(int dimension, const struct particles *p, int i, int j)
{
    double d2 = 0;
    for (int c = 0; c < dimension; c++) {
        const double d = p->x[c][i] - p->x[c][j];
        d2 += d * d;
    }
    return d2;
}

/* A pair that overlaps less than the largest so far, and is not followed, is not looked at closely: no root. */
static inline void look_at_pairs(int dimension, const struct sample *sample, struct passing_watch *passing,
                                 struct largest_overlap *largest)
{
    const struct particles *p = &sample->particles;
    const double followed = passing ? PASSING_WATCH_FOLLOWED : 1;
    for (int k = 0; k < sample->pairs.count; k++) {
        const int i = sample->pairs.i[k], j = sample->pairs.j[k];
        const double a = p->radius[i], b = p->radius[j], smaller = a < b ? a : b, reach = a + b;
        const double deepest = largest->ratio * smaller, shallow = followed * reach;
        const double far = reach - (deepest < shallow ? deepest : shallow), d2 = distance2_m2(dimension, p, i, j);
        if (d2 >= far * far)
            continue;
        const double overlap_m = reach - sqrt(d2), ratio = overlap_m / smaller;
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
    if (sample->particles.dimension == 2)
        look_at_pairs(2, sample, passing, largest);
    else
        look_at_pairs(3, sample, passing, largest);
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
        for (int c = 0; c < p->dimension; c++) {
            const double v = particles_velocity(p, c, i);
            v2 += v * v;
        }
        /* against one of its own kind that comes with the same speed: 2 v sqrt(m/2 / k) */
        const double square = 2 * v2 * p->mass[i] / (k * p->radius[i] * p->radius[i]);
        largest = square > largest ? square : largest;
    }
    return sqrt(largest);
}
