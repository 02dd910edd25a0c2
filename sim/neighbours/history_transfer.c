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

static void carry(struct contact_list *to, void *array, const struct contact_list *from, const void *known, bool turns,
                  const struct search *search)
{
    const int slots = to->n_sets * SET_WIDTH;
    if (from->count == 0)
        memset(array, 0, (size_t)slots * (to->single ? sizeof(float) : sizeof(double)));
    else if (to->single)
        search->transfer_floats(array, known, to->scratch, slots, turns);
    else
        search->transfer_doubles(array, known, to->scratch, slots, turns);
}

/* Histories of a list with another unit; they are powers of 2, so that nothing is rounded. */
static void convert(struct contact_list *list, double from_unit)
{
    const size_t slots = (size_t)list->n_sets * SET_WIDTH;
    const float factor = (float)(from_unit / list->slots.unit);
    if (factor == 1) /* double has but one */
        return;
    for (size_t s = 0; s < slots; s++)
        ((float *)list->slots.history)[s] *= factor;
}

enum status history_transfer_close(struct contact_list *list, const struct particles *particles,
                                   const struct wall *wall, struct contact_list *before, const int32_t *source,
                                   const struct search *search)
{
    const bool turns = list->n_springs == 3; /* in space a spring points from one member to the other */
    if (!before->closed)
        TRY(contact_list_close(before, particles, wall));
    TRY(contact_list_place(list, particles, wall));
    if (list->count == 0)
        return STATUS_OK;
    TRY(find_sources(list, before, source));
    struct contact_slots *to = &list->slots;
    const struct contact_slots *from = &before->slots;
    if (list->hysteretic) {
        carry(list, to->history, before, from->history, false, search);
        convert(list, from->unit);
    }
    if (list->n_springs)
        carry(list, to->sliding, before, from->sliding, false, search);
    for (int c = 0; c < list->n_springs; c++) {
        carry(list, to->spring[c], before, from->spring[c], turns, search);
        if (list->single)
            carry(list, to->rest[c], before, from->rest[c], turns, search);
        else /* there is none, but its zeros are part of the state, with their signs */
            memset(to->rest[c], 0, (size_t)list->n_sets * SET_WIDTH * sizeof(double));
    }
    return STATUS_OK;
}
