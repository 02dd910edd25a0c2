#include "sim/contacts/contact_list.h"

#include <stdlib.h>
#include <string.h>

#include "sim/base/aligned_array.h"

enum status contact_list_reserve(struct contact_list *list, int capacity, int dimension)
{
    (void)dimension;
    if (capacity <= list->capacity)
        return STATUS_OK;
    size_t size = (size_t)capacity, keep = (size_t)list->count;
    TRY(array_resize(&list->i, sizeof *list->i, size, keep));
    TRY(array_resize(&list->j, sizeof *list->j, size, keep));
    TRY(array_resize(&list->slot, sizeof *list->slot, size, keep));
    TRY(array_resize(&list->reach, sizeof(double), size, keep));
    for (int c = 0; c < HISTORY_COLUMNS; c++)
        if (history_has(&list->model, c))
            TRY(array_resize(&list->history[c], sizeof(double), size, keep));
    list->capacity = capacity;
    return STATUS_OK;
}

void contact_list_carry(struct contact_list *to, int t, const struct contact_list *from, int f)
{
    for (int c = 0; c < HISTORY_COLUMNS; c++)
        if (to->history[c]) /* those that its model has */
            to->history[c][t] = from->history[c][f];
}

void contact_list_clear(struct contact_list *to, int t)
{
    for (int c = 0; c < HISTORY_COLUMNS; c++)
        if (to->history[c])
            to->history[c][t] = 0;
}

enum status contact_list_work(struct contact_list *list, size_t count, size_t kept)
{
    const size_t size = count + count / 8;
    if (count <= list->scratch_size)
        return STATUS_OK;
    TRY(array_resize(&list->scratch, sizeof *list->scratch, size, kept));
    list->scratch_size = size;
    return STATUS_OK;
}

void contact_list_free(struct contact_list *list)
{
    free(list->i);
    free(list->j);
    free(list->slot);
    free(list->reach);
    for (int c = 0; c < PAIR_CONSTANTS; c++)
        free(list->slots.pair[c]);
    for (int c = 0; c < HISTORY_COLUMNS; c++) {
        free(list->history[c]);
        free(list->slots.history[c]);
    }
    free(list->scratch);
    free(list->slots.span);
    free(list->slots.first);
    free(list->slots.partner);
    free(list->slots.gap);
    for (int c = 0; c < 3; c++)
        free(list->slots.built[c]);
    free(list->slots.reach);
    memset(list, 0, sizeof *list);
}
