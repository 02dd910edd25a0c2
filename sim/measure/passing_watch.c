#include "sim/measure/passing_watch.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* On a straight way the normal turns by more than 90 degrees where the distance of the centres falls below 1/sqrt(2) of
 * the sum of the radii: an overlap of 0.29 of that sum. Small grains that slide along large ones overlap by less. */
static const double DEEP = 0.25;

/* The pair of ids i < j, if it is followed. */
static const struct passing_pair *find(const struct passing_watch *watch, int i, int j)
{
    int32_t k = watch->n > 0 ? watch->first[i] : -1;
    while (k >= 0 && watch->pair[k].j != j)
        k = watch->before[k];
    return k >= 0 ? &watch->pair[k] : NULL;
}

/* From the particle in slot j to that in slot i [m]. */
static void normal_of(const struct particles *p, int i, int j, double *normal)
{
    for (int c = 0; c < p->dimension; c++)
        normal[c] = p->x[c][i] - p->x[c][j];
}

/* Of those that overlapped at the last look: whose normal has turned round since they came together? */
static void turned_count(struct passing_watch *watch, const struct sample *sample)
{
    const struct particles *p = &sample->particles;
    for (size_t k = 0; k < watch->n; k++) {
        struct passing_pair *pair = &watch->pair[k];
        double now[3], along = 0;
        normal_of(p, p->slot[pair->i], p->slot[pair->j], now);
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
    int32_t *before = realloc(watch->before, capacity * sizeof *before);
    watch->before = before ? before : watch->before;
    if (!pair || !next || !before)
        return status_fail(STATUS_NO_MEMORY, "out of memory for %zu pairs", n);
    watch->capacity = capacity;
    return STATUS_OK;
}

static enum status room_for_particles(struct passing_watch *watch, int count)
{
    if (count <= watch->first_count)
        return STATUS_OK;
    int32_t *first = realloc(watch->first, (size_t)count * sizeof *first);
    if (!first)
        return status_fail(STATUS_NO_MEMORY, "out of memory for %d particles", count);
    watch->first = first;
    watch->first_count = count;
    return STATUS_OK;
}

enum status passing_watch_begin(struct passing_watch *watch, const struct sample *sample)
{
    turned_count(watch, sample);
    watch->n_next = 0;
    TRY(room_for_particles(watch, sample->particles.count));
    return room_for(watch, (size_t)sample->pairs.count);
}

/* Of a pair that was followed, the normal that it had when it came together; after a while, that of now. */
void passing_watch_add(struct passing_watch *watch, const struct sample *sample, int place, double overlap)
{
    if (overlap < PASSING_WATCH_FOLLOWED)
        return;
    const struct particles *p = &sample->particles;
    const int first = sample->pairs.i[place], second = sample->pairs.j[place];
    const bool rising = p->id[first] < p->id[second];
    const int i = rising ? first : second, j = rising ? second : first;
    struct passing_pair now = {.i = p->id[i], .j = p->id[j], .since = sample->step};
    const struct passing_pair *known = find(watch, now.i, now.j);
    if (known && sample->step - known->since <= PASSING_WATCH_TURN_STEPS)
        now = *known;
    else
        normal_of(p, i, j, now.normal);
    now.overlap = fmax(now.overlap, overlap);
    watch->next[watch->n_next++] = now;
}

void passing_watch_end(struct passing_watch *watch)
{
    struct passing_pair *spare = watch->pair;
    watch->pair = watch->next;
    watch->next = spare;
    watch->n = watch->n_next;
    memset(watch->first, -1, (size_t)watch->first_count * sizeof *watch->first);
    for (size_t k = 0; k < watch->n; k++) {
        int32_t *first = &watch->first[watch->pair[k].i];
        watch->before[k] = *first;
        *first = (int32_t)k;
    }
}

void passing_watch_forget(struct passing_watch *watch)
{
    watch->n = 0;
}

void passing_watch_free(struct passing_watch *watch)
{
    free(watch->pair);
    free(watch->next);
    free(watch->first);
    free(watch->before);
    *watch = (struct passing_watch){0};
}
