#include "sim/sample/contact_state.h"

#include "sim/sample/contact_look.h"

struct contact_geometry contact_geometry_at(const struct sample *sample, int l, int k)
{
    const struct particles *p = &sample->particles;
    const struct contact_list *list = sample_list(sample, l);
    if (l > 0)
        return contact_geometry_at_wall(p, list->i[k], &sample->walls[l - 1]);
    return p->dimension == 2 ? contact_geometry_of_pair(2, p, list->i[k], list->j[k])
                             : contact_geometry_of_pair(3, p, list->i[k], list->j[k]);
}

static const struct contact_looks *looks_of(const struct sample *sample)
{
    const struct contact_model *model = &sample->pairs.model;
    const int law = model->normal, dimension = model->dimension - 2, friction = contact_model_friction(model);
    return sample->isa == ISA_reference ? &contact_looks_plain[law][dimension][friction]
                                        : &contact_looks_fma[law][dimension][friction];
}

bool contact_state_at(struct complete_sample whole, int l, int k, struct contact_geometry *geometry,
                      struct contact_forces *forces)
{
    *geometry = contact_geometry_at(whole.sample, l, k);
    *forces = (struct contact_forces){0};
    if (!(geometry->overlap > 0))
        return false;
    if (whole.sample->material) /* before the first stage there is no law */
        looks_of(whole.sample)->forces(whole.sample, l, k, geometry, forces);
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

void contact_survey_make(struct complete_sample whole, struct contact_survey *sum)
{
    struct contact_geometry g;
    struct contact_forces f;
    for (int l = 0; l <= whole.sample->n_walls; l++)
        for (int k = 0; k < sample_list(whole.sample, l)->count; k++) {
            if (!contact_state_at(whole, l, k, &g, &f))
                continue;
            sum->elastic_normal_j += f.elastic_j;
            sum->elastic_tangential_j += f.spring_j;
            add_state(whole.sample, l, k, &g, &f, sum);
        }
}

double contact_state_elastic_j(struct complete_sample whole)
{
    double normal_j = 0, tangential_j = 0;
    for (int l = 0; whole.sample->material && l <= whole.sample->n_walls; l++)
        looks_of(whole.sample)->energies(whole.sample, l, &normal_j, &tangential_j);
    return normal_j + tangential_j;
}
