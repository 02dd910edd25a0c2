/* MODEL_TEXT of contact_look_table.h: contacts of a sample in the law's own text, in double. */
#if !SINGLE
#include "sim/law/contact_law_tmpl.h"

#include "sim/law/contact_measure_tmpl.h"

/* A list of contacts, and the law in which they are looked at. */
struct NAME(list_look) {
    const struct particles *particles;
    const struct contact_list *list;
    const struct wall *wall; /* NULL: pairs */
    const struct contact_law_constants *law;
    int n_columns; /* of the history, what rounding left out aside: */
    int at[HISTORY_COLUMNS];
    struct contact_column column[HISTORY_COLUMNS], rest[HISTORY_COLUMNS];
    bool has_rest[HISTORY_COLUMNS];
};

/* What one of them is: both sides, and what it remembers. */
struct NAME(contact) {
    struct NAME(sides) at;
    double value[HISTORY_COLUMNS], pair[PAIR_CONSTANTS];
};

LANES_INLINE struct NAME(list_look) NAME(look_at_list)(const struct sample *sample, int l)
{
    const struct wall *wall = l > 0 ? &sample->walls[l - 1] : NULL;
    struct NAME(list_look) look = {.particles = &sample->particles,
                                   .list = sample_list(sample, l),
                                   .wall = wall,
                                   .law = wall ? &sample->wall_law[wall->axis] : &sample->law};
    for (int c = 0; c < HISTORY_COLUMNS; c++) {
        const int rest = history_field(c)->rest, n = look.n_columns;
        if (!look.list->history[c] || history_field(c)->is_rest)
            continue;
        look.at[n] = c;
        look.column[n] = contact_column_of(look.list, c);
        look.has_rest[n] = look.list->model.mixed && rest;
        if (look.has_rest[n])
            look.rest[n] = contact_column_of(look.list, rest);
        look.n_columns++;
    }
    return look;
}

/* Contact k, which touches. `contact` starts with zeros: no time passes, so lags stay 0. */
LANES_INLINE void NAME(look_up)(const struct NAME(list_look) * look, int k, const struct contact_geometry *g,
                                struct NAME(contact) * contact)
{
    const struct particles *p = look->particles;
    const struct contact_list *list = look->list;
    const struct wall *wall = look->wall;
    const int i = list->i[k], j = list->j[k];
    struct NAME(sides) *at = &contact->at;
    at->inverse = 1;
    at->delta = g->overlap;
    for (int c = 0; c < DIM; c++) {
        at->d[c] = g->n[c];
        at->g[c] = p->v[c][i] - (!wall ? p->v[c][j] : wall->axis == c ? wall->v : 0);
    }
#if FRICTIONAL
    at->arm = g->distance / (g->distance + g->overlap);
    for (int c = 0; c < SPRINGS; c++)
        at->w[c] = p->radius[i] * p->omega[c][i] + (wall ? 0 : p->radius[j] * p->omega[c][j]);
#endif
#if ROLLING
    at->radius = p->radius[i];
    at->share = wall ? 1 : p->radius[j] / (p->radius[i] + p->radius[j]);
    for (int c = 0; c < SPRINGS; c++)
        at->turning[c] = p->omega[c][i] - (wall ? 0 : p->omega[c][j]);
#endif
    for (int n = 0; n < look->n_columns; n++) {
        double *value = &contact->value[look->at[n]];
        *value = contact_column_value(&look->column[n], list, k);
        if (look->has_rest[n])
            *value += contact_column_value(&look->rest[n], list, k);
    }
#if PER_PAIR
    contact->pair[PAIR_ROOT_MASS] = sqrt(wall ? p->mass[i] : p->mass[i] * p->mass[j] / (p->mass[i] + p->mass[j]));
    contact->pair[PAIR_RADIUS] = wall ? p->radius[i] : p->radius[i] * p->radius[j] / (p->radius[i] + p->radius[j]);
#endif
}

LANES_INLINE void NAME(forces)(const struct NAME(list_look) * look, const struct NAME(law) * law, int k,
                               const struct contact_geometry *g, struct NAME(contact) * contact,
                               struct contact_forces *f)
{
    void *history[HISTORY_COLUMNS], *pair[PAIR_CONSTANTS];
    NAME(look_up)(look, k, g, contact);
    for (int c = 0; c < HISTORY_COLUMNS; c++)
        history[c] = &contact->value[c];
    for (int c = 0; c < PAIR_CONSTANTS; c++)
        pair[c] = &contact->pair[c];
    NAME(contact_look)(law, &contact->at, pair, history, f);
}

static void NAME(contact_forces_at)(const struct sample *sample, int l, int k, const struct contact_geometry *g,
                                    struct contact_forces *f)
{
    const struct NAME(list_look) look = NAME(look_at_list)(sample, l);
    const struct NAME(law) law = NAME(law_of_look)(look.law, sample->kicked_s);
    struct NAME(contact) contact = {0};
    NAME(forces)(&look, &law, k, g, &contact, f);
}

/* Of pairs and of walls apart: so that the compiler keeps a pair's geometry in registers. */
LANES_INLINE void NAME(energies)(bool pairs, const struct NAME(list_look) * look, const struct NAME(law) * law,
                                 double *normal_j, double *tangential_j)
{
    const struct particles *p = look->particles;
    const struct contact_list *list = look->list;
    struct NAME(contact) contact = {0};
    for (int k = 0; k < list->count; k++) {
        struct contact_forces f;
        const struct contact_geometry g = pairs ? contact_geometry_of_pair(DIM, p, list->i[k], list->j[k])
                                                : contact_geometry_at_wall(p, list->i[k], look->wall);
        if (!(g.overlap > 0))
            continue;
        NAME(forces)(look, law, k, &g, &contact, &f);
        *normal_j += f.elastic_j;
        *tangential_j += f.spring_j;
    }
}

static void NAME(contact_energies)(const struct sample *sample, int l, double *normal_j, double *tangential_j)
{
    const struct NAME(list_look) look = NAME(look_at_list)(sample, l);
    const struct NAME(law) law = NAME(law_of_look)(look.law, sample->kicked_s);
    if (l == 0)
        NAME(energies)(true, &look, &law, normal_j, tangential_j);
    else
        NAME(energies)(false, &look, &law, normal_j, tangential_j);
}
#endif
