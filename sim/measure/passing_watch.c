#include "sim/measure/passing_watch.h"

#include <math.h>
#include <stdlib.h>

/* On a straight way the normal turns by more than 90 degrees where the distance of the centres falls below 1/sqrt(2) of
 * the sum of the radii: an overlap of 0.29 of that sum. Small grains that slide along large ones overlap by less. */
static const double DEEP = 0.25;
/* Pairs are followed from this overlap on, which most contacts never have: those that pass through at more than 0.67 of
 * the sum of the radii are missed. */
static const double FOLLOWED = 0.05;

static int by_ids(const void *a, const void *b)
{
    const struct passing_pair *x = a, *y = b;
    return x->i != y->i ? (x->i > y->i) - (x->i < y->i) : (x->j > y->j) - (x->j < y->j);
}

/* From the particle in slot j to that in slot i [m]; returns the square of the distance. */
static double normal_of(const struct particles *p, int i, int j, double *normal)
{
    double d2 = 0;
    for (int c = 0; c < p->dimension; c++) {
        normal[c] = p->x[c][i] - p->x[c][j];
        d2 += normal[c] * normal[c];
    }
    return d2;
}

/* Of those that overlapped at the last look: whose normal has turned round since they came together? */
static void turned_count(struct passing_watch *watch, const struct sample *sample)
{
    const struct particles *p = &sample->particles;
    for (size_t k = 0; k < watch->n; k++) {
        struct passing_pair *pair = &watch->pair[k];
        double now[3], along = 0;
        (void)normal_of(p, p->slot[pair->i], p->slot[pair->j], now);
        for (int c = 0; c < p->dimension; c++)
            along += now[c] * pair->normal[c];
        if (along >= 0 || pair->overlap < DEEP || sample->step - pair->since > PASSING_WATCH_TURN_STEPS)
            continue;
        watch->passed++;
        watch->last[0] = pair->i;
        watch->last[1] = pair->j;
        watch->last_step = sample->step;
        pair->since = INT64_MIN / 2; /* counted once: its normal starts anew */
    }
}

static enum status room_for(struct passing_watch *watch, size_t n)
{
    if (n <= watch->capacity)
        return STATUS_OK;
    const size_t capacity = n + n / 4;
    struct passing_pair *pair = realloc(watch->pair, capacity * sizeof *pair);
    watch->pair = pair ? pair : watch->pair;
    struct passing_pair *next = realloc(watch->next, capacity * sizeof *next);
    watch->next = next ? next : watch->next;
    if (!pair || !next)
        return status_fail(STATUS_NO_MEMORY, "out of memory for %zu pairs", n);
    watch->capacity = capacity;
    return STATUS_OK;
}

/* Those that overlap now, with the normal that they had when they came together or, after a while, with that of now. */
static size_t touching_collect(const struct passing_watch *watch, const struct sample *sample)
{
    const struct particles *p = &sample->particles;
    const struct contact_list *list = &sample->pairs;
    size_t n = 0;
    for (int k = 0; k < list->count; k++) {
        const bool rising = p->id[list->i[k]] < p->id[list->j[k]];
        const int i = rising ? list->i[k] : list->j[k], j = rising ? list->j[k] : list->i[k];
        struct passing_pair now = {.i = p->id[i], .j = p->id[j], .since = sample->step};
        const double reach = p->radius[i] + p->radius[j], d2 = normal_of(p, i, j, now.normal);
        if (d2 > (1 - FOLLOWED) * (1 - FOLLOWED) * reach * reach)
            continue;
        const double part = 1 - sqrt(d2) / reach;
        const struct passing_pair *known =
            watch->n > 0 ? bsearch(&now, watch->pair, watch->n, sizeof now, by_ids) : NULL;
        if (known && sample->step - known->since <= PASSING_WATCH_TURN_STEPS)
            now = *known;
        now.overlap = fmax(now.overlap, part);
        watch->next[n++] = now;
    }
    return n;
}

enum status passing_watch_look(struct passing_watch *watch, struct sample *sample)
{
    particles_export_positions(&sample->particles);
    turned_count(watch, sample);
    TRY(room_for(watch, (size_t)sample->pairs.count));
    watch->n = touching_collect(watch, sample);
    struct passing_pair *spare = watch->pair;
    watch->pair = watch->next;
    watch->next = spare;
    if (watch->n > 0)
        qsort(watch->pair, watch->n, sizeof *watch->pair, by_ids);
    return STATUS_OK;
}

void passing_watch_forget(struct passing_watch *watch)
{
    watch->n = 0;
}

void passing_watch_free(struct passing_watch *watch)
{
    free(watch->pair);
    free(watch->next);
    *watch = (struct passing_watch){0};
}
