#include "sim/sample/contact_state.h"

#include <math.h>
#include <string.h>

#include "sim/law/contact_law.h"

/* Compiled for each model: `dim` and `springs` are constants where these functions are called. */
#define FOR_MODEL static inline __attribute__((always_inline))

FOR_MODEL struct contact_geometry pair_geometry(const struct particles *p, int dim, int i, int j)
{
    struct contact_geometry g = {0};
    double d2 = 0;
    for (int c = 0; c < dim; c++) {
        g.n[c] = p->x[c][i] - p->x[c][j];
        d2 += g.n[c] * g.n[c];
    }
    g.distance = sqrt(d2);
    const double inverse = 1 / g.distance;
    for (int c = 0; c < dim; c++)
        g.n[c] *= inverse;
    g.overlap = p->radius[i] + p->radius[j] - g.distance;
    return g;
}

FOR_MODEL struct contact_geometry wall_geometry(const struct particles *p, int i, const struct wall *wall)
{
    struct contact_geometry g = {0};
    g.n[wall->axis] = wall->inward;
    g.distance = wall->inward * (p->x[wall->axis][i] - wall->x);
    g.overlap = p->radius[i] - g.distance;
    return g;
}

FOR_MODEL struct contact_geometry geometry_of(const struct sample *sample, int dim, int l, int k)
{
    const struct contact_list *list = sample_list(sample, l);
    if (l == 0)
        return pair_geometry(&sample->particles, dim, list->i[k], list->j[k]);
    return wall_geometry(&sample->particles, list->i[k], &sample->walls[l - 1]);
}

/* Velocity of i against j or the wall at the contact: normal part u, tangential part vt (2D: vt[0] along (-n1, n0)). */
FOR_MODEL double relative_velocity(const struct sample *sample, int dim, int springs, int l, int k, const double *n,
                                   double *vt)
{
    const struct particles *p = &sample->particles;
    const struct contact_list *list = sample_list(sample, l);
    const struct wall *wall = l > 0 ? &sample->walls[l - 1] : NULL;
    int i = list->i[k], j = list->j[k];
    double v[3] = {0}, w[3] = {0}, u = 0;
    for (int c = 0; c < dim; c++) {
        v[c] = p->v[c][i] - (!wall ? p->v[c][j] : wall->axis == c ? wall->v : 0);
        u += v[c] * n[c];
    }
    for (int c = 0; c < springs; c++)
        w[c] = p->radius[i] * p->omega[c][i] + (wall ? 0 : p->radius[j] * p->omega[c][j]);
    if (dim == 2) {
        vt[0] = v[1] * n[0] - v[0] * n[1] - w[0];
    } else {
        vt[0] = v[0] + (n[1] * w[2] - n[2] * w[1]) - u * n[0];
        vt[1] = v[1] + (n[2] * w[0] - n[0] * w[2]) - u * n[1];
        vt[2] = v[2] + (n[0] * w[1] - n[1] * w[0]) - u * n[2];
    }
    return u;
}

FOR_MODEL struct contact_forces forces_of(const struct sample *sample, int dim, int springs, int l, int k,
                                          const struct contact_geometry *g)
{
    const struct contact_list *list = sample_list(sample, l);
    const struct contact_law_constants *law = &sample->law;
    const double *n = g->n;
    struct contact_forces f = {0};
    double vt[3], ft[3], u = relative_velocity(sample, dim, springs, l, k, n, vt);
    f.elastic =
        list->hysteretic ? contact_elastic_force(law, g->overlap, contact_list_history(list, k)) : law->k1 * g->overlap;
    f.normal = f.elastic - law->gamma_n * u;
    for (int c = 0; c < springs; c++) {
        double xi = contact_list_spring(list, c, k) -
                    0.5 * sample->dt * vt[c]; /* it is kept for the middle of the step to come */
        ft[c] = -law->kt * xi - law->gamma_t * vt[c];
        f.spring_energy += 0.5 * law->kt * xi * xi;
    }
    if (springs == 1) {
        f.tangential[0] = -ft[0] * n[1];
        f.tangential[1] = ft[0] * n[0];
    } else if (springs == 3) {
        memcpy(f.tangential, ft, sizeof ft);
    }
    for (int c = 0; c < dim; c++)
        f.total[c] = f.normal * n[c] + f.tangential[c];
    return f;
}

FOR_MODEL void add_state(const struct sample *sample, int dim, int springs, int l, int k,
                         const struct contact_geometry *g, const struct contact_forces *f, struct contact_survey *sum)
{
    const struct particles *p = &sample->particles;
    const struct contact_list *list = sample_list(sample, l);
    const bool pair = l == 0;
    const int i = list->i[k], n = sum->pairs + sum->walls;
    double smaller_radius = p->radius[i];
    if (pair && p->radius[list->j[k]] < smaller_radius)
        smaller_radius = p->radius[list->j[k]];
    if (g->overlap > sum->max_overlap_ratio * smaller_radius)
        sum->max_overlap_ratio = g->overlap / smaller_radius;
    sum->sliding += pair && springs && contact_list_slides(list, k);
    sum->i[n] = i;
    sum->j[n] = pair ? list->j[k] : -1;
    sum->pairs += pair;
    sum->walls += !pair;
    for (int a = 0; a < dim; a++)
        for (int b = 0; b < dim; b++) {
            sum->stress[a * dim + b] += f->total[a] * g->n[b] * g->distance;
            if (pair)
                sum->fabric[a * dim + b] += g->n[a] * g->n[b];
        }
}

FOR_MODEL void survey_list(const struct sample *sample, int dim, int springs, int l, bool state,
                           struct contact_survey *result)
{
    const int count = sample_list(sample, l)->count;
    struct contact_survey sum = *result;
    for (int k = 0; k < count; k++) {
        const struct contact_geometry g = geometry_of(sample, dim, l, k);
        if (!(g.overlap > 0))
            continue;
        const struct contact_forces f = forces_of(sample, dim, springs, l, k, &g);
        sum.elastic_normal_j += f.elastic * f.elastic;
        sum.elastic_tangential_j += f.spring_energy;
        if (state)
            add_state(sample, dim, springs, l, k, &g, &f, &sum);
    }
    *result = sum;
}

FOR_MODEL void survey_lists(const struct sample *sample, int dim, int springs, bool state, struct contact_survey *sum)
{
    for (int l = 0; l <= sample->n_walls; l++)
        survey_list(sample, dim, springs, l, state, sum);
    if (sum->elastic_normal_j > 0) /* before the first stage there is no law */
        sum->elastic_normal_j /= 2 * sample->law.k2;
}

void contact_survey_make(struct complete_sample whole, bool state, struct contact_survey *sum)
{
    const struct sample *sample = whole.sample;
    switch (10 * sample->particles.dimension + sample->pairs.n_springs) {
    case 20:
        state ? survey_lists(sample, 2, 0, true, sum) : survey_lists(sample, 2, 0, false, sum);
        break;
    case 21:
        state ? survey_lists(sample, 2, 1, true, sum) : survey_lists(sample, 2, 1, false, sum);
        break;
    case 30:
        state ? survey_lists(sample, 3, 0, true, sum) : survey_lists(sample, 3, 0, false, sum);
        break;
    default:
        state ? survey_lists(sample, 3, 3, true, sum) : survey_lists(sample, 3, 3, false, sum);
        break;
    }
}

bool contact_state_at(struct complete_sample whole, int l, int k, struct contact_geometry *geometry,
                      struct contact_forces *forces)
{
    const struct sample *sample = whole.sample;
    const int dim = sample->particles.dimension;
    *geometry = geometry_of(sample, dim, l, k);
    if (!(geometry->overlap > 0))
        return false;
    *forces = forces_of(sample, dim, sample->pairs.n_springs, l, k, geometry);
    return true;
}
