#include "sim/sample/contact_state.h"

#include <math.h>
#include <string.h>

#include "sim/lanes/lanes_reference.h"

#define ISA        look
#define MODEL_TEXT "sim/sample/contact_state_tmpl.h"
#include "sim/law/for_each_model.h"

typedef void contact_at(const struct sample *sample, int l, int k, const struct contact_geometry *g,
                        struct contact_forces *f);

/* [law][dimension - 2][friction] */
static contact_at *const contact_models[LAW_COUNT][2][4] = {
#define MODEL(d, n, f) NAME__(contact_at, ISA, d, n, f, 0)
#define LAW(name, NAME_)                                                                                               \
    {{MODEL(2, name, 0), MODEL(2, name, 1), MODEL(2, name, 2)},                                                        \
     {MODEL(3, name, 0), MODEL(3, name, 1), MODEL(3, name, 2), MODEL(3, name, 3)}},
    CONTACT_LAWS(LAW)
#undef LAW
#undef MODEL
};

static struct contact_geometry pair_geometry(const struct particles *p, int i, int j)
{
    struct contact_geometry g = {0};
    double d2 = 0;
    for (int c = 0; c < p->dimension; c++) {
        g.n[c] = p->x[c][i] - p->x[c][j];
        d2 += g.n[c] * g.n[c];
    }
    g.distance = sqrt(d2);
    for (int c = 0; c < p->dimension; c++)
        g.n[c] /= g.distance;
    g.overlap = p->radius[i] + p->radius[j] - g.distance;
    return g;
}

static struct contact_geometry wall_geometry(const struct particles *p, int i, const struct wall *wall)
{
    struct contact_geometry g = {0};
    g.n[wall->axis] = wall->inward;
    g.distance = wall->inward * (p->x[wall->axis][i] - wall->x);
    g.overlap = p->radius[i] - g.distance;
    return g;
}

struct contact_geometry contact_geometry_at(const struct sample *sample, int l, int k)
{
    const struct contact_list *list = sample_list(sample, l);
    return l == 0 ? pair_geometry(&sample->particles, list->i[k], list->j[k])
                  : wall_geometry(&sample->particles, list->i[k], &sample->walls[l - 1]);
}

bool contact_state_at(struct complete_sample whole, int l, int k, struct contact_geometry *geometry,
                      struct contact_forces *forces)
{
    const struct contact_model *model = &whole.sample->pairs.model;
    *geometry = contact_geometry_at(whole.sample, l, k);
    *forces = (struct contact_forces){0};
    if (!(geometry->overlap > 0))
        return false;
    if (whole.sample->material) /* before the first stage there is no law */
        contact_models[model->normal][model->dimension - 2][contact_model_friction(model)](whole.sample, l, k, geometry,
                                                                                           forces);
    return true;
}

static void add_state(const struct sample *sample, int l, int k, const struct contact_geometry *g,
                      const struct contact_forces *f, struct contact_survey *sum)
{
    const struct particles *p = &sample->particles;
    const struct contact_list *list = sample_list(sample, l);
    const bool pair = l == 0;
    const int dim = p->dimension;
    const int i = list->i[k], n = sum->pairs + sum->walls;
    double smaller_radius = p->radius[i];
    if (pair && p->radius[list->j[k]] < smaller_radius)
        smaller_radius = p->radius[list->j[k]];
    if (g->overlap > sum->max_overlap_ratio * smaller_radius)
        sum->max_overlap_ratio = g->overlap / smaller_radius;
    sum->sliding += pair && list->model.frictional && contact_list_slides(list, k);
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

void contact_survey_make(struct complete_sample whole, bool state, struct contact_survey *sum)
{
    struct contact_geometry g;
    struct contact_forces f;
    for (int l = 0; l <= whole.sample->n_walls; l++)
        for (int k = 0; k < sample_list(whole.sample, l)->count; k++) {
            if (!contact_state_at(whole, l, k, &g, &f))
                continue;
            sum->elastic_normal_j += f.elastic_j;
            sum->elastic_tangential_j += f.spring_j;
            if (state)
                add_state(whole.sample, l, k, &g, &f, sum);
        }
}
