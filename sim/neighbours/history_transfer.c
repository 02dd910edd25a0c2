#include "sim/neighbours/history_transfer.h"

#include <string.h>

/* A column of the history on its way from one list to another; ranges are of slots, or of members. */
struct transfer {
    struct contact_list *to;
    const struct contact_list *from;
    const int32_t *source;
    const struct search *search;
    int column;
    float factor; /* of lengths, from one unit to the other */
};

enum { TRANSFER_GRAIN = 16384 };

static void empty_sources(void *context, int first, int end)
{
    const struct transfer *t = context;
    memset(t->to->scratch + first, -1, (size_t)(end - first) * sizeof *t->to->scratch);
}

static void find_source(void *context, int first, int end)
{
    const struct transfer *t = context;
    for (int k = first; k < end; k++) {
        const int32_t source = t->source[k];
        const uint32_t to = t->to->slot[k], from = t->from->slot[source < 0 ? 0 : source];
        t->to->scratch[to / 2] = source < 0 ? -1 : (int32_t)(from ^ (to & 1));
    }
}

/* Where the history of each slot comes from: twice the slot of the list before, 1 more if it belongs to the other
 * member there; -1: nowhere. In the list's working memory. */
static enum status find_sources(struct transfer *t)
{
    const int slots = t->to->n_sets * SET_WIDTH;
    TRY(contact_list_work(t->to, (size_t)slots, 0));
    team_run_ranges(t->to->team, slots, TRANSFER_GRAIN, empty_sources, t);
    if (t->from->count)
        team_run_ranges(t->to->team, t->to->count, TRANSFER_GRAIN, find_source, t);
    return STATUS_OK;
}

static void transfer_slots(void *context, int first, int end)
{
    const struct transfer *t = context;
    const size_t real = t->to->model.mixed ? sizeof(float) : sizeof(double);
    void *array = (char *)t->to->slots.history[t->column] + real * (size_t)first;
    const void *known = t->from->slots.history[t->column];
    const int32_t *source = t->to->scratch + first;
    const bool turns = history_is_odd(&t->to->model, t->column);
    if (t->from->count == 0)
        memset(array, 0, real * (size_t)(end - first));
    else if (t->to->model.mixed)
        t->search->transfer_floats(array, known, source, end - first, turns);
    else
        t->search->transfer_doubles(array, known, source, end - first, turns);
}

/* Lengths of a list with another unit; they are powers of 2, so that nothing is rounded. Double has but one. */
static void convert_slots(void *context, int first, int end)
{
    const struct transfer *t = context;
    for (int s = first; s < end; s++)
        ((float *)t->to->slots.history[t->column])[s] *= t->factor;
}

static void transfer_column(struct transfer *t)
{
    const int slots = t->to->n_sets * SET_WIDTH;
    team_run_ranges(t->to->team, slots, TRANSFER_GRAIN, transfer_slots, t);
    if (history_field(t->column)->length && t->factor != 1)
        team_run_ranges(t->to->team, slots, TRANSFER_GRAIN, convert_slots, t);
}

enum status history_transfer_close(struct contact_list *list, const struct particles *particles,
                                   const struct wall *wall, struct contact_list *before, const int32_t *source,
                                   const struct search *search)
{
    if (!before->closed)
        TRY(contact_list_close(before, particles, wall));
    TRY(contact_list_place(list, particles, wall));
    if (list->count == 0)
        return STATUS_OK;
    struct transfer t = {list, before, source, search, 0, (float)(before->slots.unit / list->slots.unit)};
    TRY(find_sources(&t));
    for (t.column = 0; t.column < HISTORY_COLUMNS; t.column++)
        if (history_has(&list->model, t.column))
            transfer_column(&t);
    return STATUS_OK;
}
