/* MODEL_TEXT of contact_state.c: one contact of a sample in the law's own text, in double. */
#if !SINGLE
#include "sim/law/contact_law_tmpl.h"

#include "sim/law/contact_measure_tmpl.h"

/* Contact k of list l, which touches. */
static void NAME(contact_at)(const struct sample *sample, int l, int k, const struct contact_geometry *g,
                             struct contact_forces *f)
{
    const struct particles *p = &sample->particles;
    const struct contact_list *list = sample_list(sample, l);
    const struct wall *wall = l > 0 ? &sample->walls[l - 1] : NULL;
    const int i = list->i[k], j = list->j[k];
    struct NAME(sides) at = {.inverse = 1, .delta = g->overlap};
    double values[HISTORY_COLUMNS] = {0}, pair[PAIR_CONSTANTS];
    void *history[HISTORY_COLUMNS], *pairs[PAIR_CONSTANTS] = {&pair[PAIR_ROOT_MASS], &pair[PAIR_RADIUS]};
    for (int c = 0; c < DIM; c++) {
        at.d[c] = g->n[c];
        at.g[c] = p->v[c][i] - (!wall ? p->v[c][j] : wall->axis == c ? wall->v : 0);
    }
#if FRICTIONAL
    at.arm = g->distance / (g->distance + g->overlap);
    for (int c = 0; c < DIM; c++)
        at.lag[c] = 0; /* no time passes */
    for (int c = 0; c < SPRINGS; c++) {
        at.lag_w[c] = 0;
        at.w[c] = p->radius[i] * p->omega[c][i] + (wall ? 0 : p->radius[j] * p->omega[c][j]);
#if DIM == 3
        at.spin[c] = 0;
#endif
    }
#endif
#if ROLLING
    at.radius = p->radius[i];
    at.share = wall ? 1 : p->radius[j] / (p->radius[i] + p->radius[j]);
    for (int c = 0; c < SPRINGS; c++) {
        at.lag_turning[c] = 0;
        at.turning[c] = p->omega[c][i] - (wall ? 0 : p->omega[c][j]);
    }
#endif
    for (int c = 0; c < HISTORY_COLUMNS; c++) {
        history[c] = &values[c];
        if (list->history[c] && !history_field(c)->is_rest)
            values[c] = contact_list_whole(list, c, k);
    }
    pair[PAIR_ROOT_MASS] = sqrt(wall ? p->mass[i] : p->mass[i] * p->mass[j] / (p->mass[i] + p->mass[j]));
    pair[PAIR_RADIUS] = wall ? p->radius[i] : p->radius[i] * p->radius[j] / (p->radius[i] + p->radius[j]);
    NAME(contact_look)(wall ? &sample->wall_law[wall->axis] : &sample->law, sample->kicked_s, &at, pairs, history, f);
}
#endif
