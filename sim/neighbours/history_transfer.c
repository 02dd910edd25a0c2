#include "sim/neighbours/history_transfer.h"

#include <string.h>

/* The history on its way from one list to another. */
struct transfer {
    struct contact_list *to;
    const struct contact_list *from;
    const int32_t *source;
    const struct search *search;
    struct transfer_columns columns;
};

enum { TRANSFER_GRAIN = 16384, TRANSFER_SETS = TRANSFER_GRAIN / SET_WIDTH };

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
    team_run_ranges(t->to->team, t->to->count, TRANSFER_GRAIN, find_source, t);
    return STATUS_OK;
}

static void transfer_sets(void *context, int first, int end)
{
    const struct transfer *t = context;
    const struct contact_slots *to = &t->to->slots, *from = &t->from->slots;
    const size_t slot = (size_t)first * SET_WIDTH;
    if (t->to->model.mixed)
        t->search->transfer_floats(contact_slots_float(to, SLOT_HISTORY, slot),
                                   contact_slots_float(from, SLOT_HISTORY, 0), t->to->scratch + slot, end - first,
                                   &t->columns);
    else
        t->search->transfer_doubles(contact_slots_double(to, SLOT_HISTORY, slot),
                                    contact_slots_double(from, SLOT_HISTORY, 0), t->to->scratch + slot, end - first,
                                    &t->columns);
}

/* Lengths of a list with another unit change by `scale`; units are powers of 2, so that nothing is rounded. */
static void set_columns(struct transfer *t, double scale)
{
    const struct contact_model *model = &t->to->model;
    struct transfer_columns *columns = &t->columns;
    columns->set = (int)(t->to->slots.set_bytes / (model->mixed ? sizeof(float) : sizeof(double)));
    for (int c = 0; c < HISTORY_COLUMNS; c++) {
        if (!history_has(model, c))
            continue;
        const double factor = history_field(c)->length ? scale : 1;
        columns->factor[columns->n] = (float)factor;
        columns->turned[columns->n++] = (float)(history_is_odd(model, c) ? -factor : factor);
    }
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
    if (before->count == 0) {
        contact_list_empty_slots(list);
        return STATUS_OK;
    }
    struct transfer t = {.to = list, .from = before, .source = source, .search = search};
    set_columns(&t, before->slots.unit / list->slots.unit);
    TRY(find_sources(&t));
    team_run_ranges(list->team, list->n_sets, TRANSFER_SETS, transfer_sets, &t);
    return STATUS_OK;
}
