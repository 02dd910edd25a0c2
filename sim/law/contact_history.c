#include "sim/law/contact_history.h"

#define COMPONENT(column, name_, unit_, kind_, c, rest_, length_, force_, is_rest_)                                    \
    [column] = {.name = name_,                                                                                         \
                .unit = unit_,                                                                                         \
                .kind = kind_,                                                                                         \
                .component = c,                                                                                        \
                .rest = rest_,                                                                                         \
                .length = length_,                                                                                     \
                .force = force_,                                                                                       \
                .is_rest = is_rest_},
#define NUMBER(column, need, name_, unit_, kind_, rest_, length_, is_rest_)                                            \
    COMPONENT(column, name_, unit_, kind_, -1, rest_, length_, false, is_rest_)
#define VECTOR(column, rest_, need, name_, unit_, kind_, force_)                                                       \
    COMPONENT(column, name_, unit_, kind_, 0, rest_, false, force_, false)                                             \
    COMPONENT(column + 1, name_, unit_, kind_, 1, rest_ + 1, false, force_, false)                                     \
    COMPONENT(column + 2, name_, unit_, kind_, 2, rest_ + 2, false, force_, false)                                     \
    COMPONENT(rest_, name_ "_rest", unit_, kind_, 0, 0, false, force_, true)                                           \
    COMPONENT(rest_ + 1, name_ "_rest", unit_, kind_, 1, 0, false, force_, true)                                       \
    COMPONENT(rest_ + 2, name_ "_rest", unit_, kind_, 2, 0, false, force_, true)

static const struct history_field table[HISTORY_COLUMNS] = {HISTORY_TABLE(NUMBER, VECTOR)};

const struct history_field *history_field(int c)
{
    return &table[c];
}

bool history_is_odd(const struct contact_model *model, int c)
{
    const enum history_kind kind = table[c].kind;
    return kind == HISTORY_ROTATION || (kind == HISTORY_TANGENT && model->dimension == 3);
}

int history_shown(const struct contact_model *model, int *column)
{
    int n = 0;
    for (int c = 0; c < HISTORY_COLUMNS && n < HISTORY_FIELDS_MAX; c++) {
        const struct history_field *field = &table[c];
        if (history_has(model, c) && !field->is_rest && field->component <= 0 && c != HISTORY_SLIDING)
            column[n++] = c;
    }
    return n;
}
