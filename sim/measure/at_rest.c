#include "sim/measure/at_rest.h"

#include <math.h>
#include <stdlib.h>

#include "sim/sample/contact_state.h"
#include "sim/sample/energy.h"

/* Mean normal force; marks who touches something, if there is `touches` [count]. */
static double mean_normal_force_n(struct complete_sample whole, bool *touches, int *contacts)
{
    const struct sample *sample = whole.sample;
    struct contact_geometry g;
    struct contact_forces f;
    double sum = 0;
    *contacts = 0;
    for (int l = 0; l <= sample->n_walls; l++) {
        const struct contact_list *list = sample_list(sample, l);
        for (int k = 0; k < list->count; k++) {
            if (!contact_state_at(whole, l, k, &g, &f))
                continue;
            sum += fabs(f.normal);
            ++*contacts;
            if (touches)
                touches[list->i[k]] = true;
            if (touches && l == 0)
                touches[list->j[k]] = true;
        }
    }
    return *contacts ? sum / *contacts : 0;
}

static double mean_net_force_n(const struct particles *p, const bool *touches)
{
    double sum = 0;
    int n = 0;
    for (int i = 0; i < p->count; i++) {
        double a2 = 0;
        for (int c = 0; c < p->dimension; c++)
            a2 += p->a[c][i] * p->a[c][i];
        if (touches && !touches[i])
            continue;
        sum += p->mass[i] * sqrt(a2);
        n++;
    }
    return n ? sum / n : 0;
}

struct rest_figures rest_figures_of(struct complete_sample whole)
{
    const struct particles *p = &whole.sample->particles;
    const struct held_energy held = energy_held(whole);
    bool *touches = calloc((size_t)p->count, sizeof *touches); /* without: all count */
    struct rest_figures figures = {0};
    const double normal_n = mean_normal_force_n(whole, touches, &figures.contacts);
    if (figures.contacts && normal_n > 0) {
        figures.unbalanced_force = mean_net_force_n(p, touches) / normal_n;
        figures.energy_ratio = held.elastic_j > 0 ? held.kinetic_j / held.elastic_j : INFINITY;
    }
    free(touches);
    return figures;
}
