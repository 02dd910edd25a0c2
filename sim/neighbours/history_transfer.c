#include "sim/neighbours/history_transfer.h"

#include <string.h>

/* Where the history of each slot comes from: twice the slot of `before`, 1 more if it belongs to the other member
 * there; -1: nowhere. In the list's working memory. */
static enum status find_sources(struct contact_list *list, const struct contact_list *before, const int32_t *source)
{
    const size_t slots = (size_t)list->n_sets * SET_WIDTH;
    TRY(contact_list_work(list, slots, 0));
    memset(list->scratch, -1, slots * sizeof *list->scratch);
    for (int k = 0; before->count && k < list->count; k++) {
        const uint32_t to = list->slot[k], from = before->slot[source[k] < 0 ? 0 : source[k]];
        list->scratch[to / 2] = source[k] < 0 ? -1 : (int32_t)(from ^ (to & 1));
    }
    return STATUS_OK;
}

static void transfer(struct contact_list *to, void *array, const struct contact_list *from, const void *known,
                     bool turns, const struct search *search)
{
    const int slots = to->n_sets * SET_WIDTH;
    if (from->count == 0)
        memset(array, 0, (size_t)slots * (to->model.single ? sizeof(float) : sizeof(double)));
    else if (to->model.single)
        search->transfer_floats(array, known, to->scratch, slots, turns);
    else
        search->transfer_doubles(array, known, to->scratch, slots, turns);
}

/* Lengths of a list with another unit; they are powers of 2, so that nothing is rounded. */
static void convert(const struct contact_list *list, int c, double from_unit)
{
    const size_t slots = (size_t)list->n_sets * SET_WIDTH;
    const float factor = (float)(from_unit / list->slots.unit);
    if (factor == 1) /* double has but one */
        return;
    for (size_t s = 0; s < slots; s++)
        ((float *)list->slots.history[c])[s] *= factor;
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
    TRY(find_sources(list, before, source));
    for (int c = 0; c < HISTORY_COLUMNS; c++) {
        if (!history_has(&list->model, c))
            continue;
        transfer(list, list->slots.history[c], before, before->slots.history[c], history_is_odd(&list->model, c),
                 search);
        if (history_field(c)->length)
            convert(list, c, before->slots.unit);
    }
    return STATUS_OK;
}
