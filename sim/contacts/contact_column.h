/* A column of the history of a list, ready to be read for many members. */
#ifndef SHAKEDOWN_SIM_CONTACTS_CONTACT_COLUMN_H
#define SHAKEDOWN_SIM_CONTACTS_CONTACT_COLUMN_H

#include "sim/contacts/contact_list.h"

struct contact_column {
    const float *floats; /* of the slots; one of these three */
    const double *doubles, *copy;
    double unit; /* of what the slots have; powers of 2 */
    bool odd;    /* whether it changes its sign when i and j change places */
};

/* Of what the slots of the list have in column c. */
static inline double contact_column_unit(const struct contact_list *list, int c)
{
    const struct history_field *field = history_field(c);
    return field->length ? list->slots.unit : field->force ? list->slots.force_unit : 1;
}

static inline struct contact_column contact_column_of(const struct contact_list *list, int c)
{
    const struct contact_slots *slots = &list->slots;
    struct contact_column column = {.unit = contact_column_unit(list, c), .odd = history_is_odd(&list->model, c)};
    if (!list->closed)
        column.copy = list->history[c];
    else if (list->model.mixed)
        column.floats = slots->history[c];
    else
        column.doubles = slots->history[c];
    return column;
}

/* Of member k, as i has it against j. */
static inline double contact_column_value(const struct contact_column *column, const struct contact_list *list, int k)
{
    if (column->copy)
        return column->copy[k];
    const uint32_t slot = list->slot[k] / 2;
    const double value = column->floats ? column->floats[slot] : column->doubles[slot];
    return (column->odd && list->slot[k] % 2 ? -column->unit : column->unit) * value;
}

#endif
