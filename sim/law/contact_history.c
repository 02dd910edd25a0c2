#include "sim/law/contact_history.h"

static bool has_max_overlap(const struct contact_model *model)
{
    return model->traits & NORMAL_REMEMBERS_OVERLAP;
}

static bool has_friction(const struct contact_model *model)
{
    return model->frictional;
}

static bool has_spring(const struct contact_model *model)
{
    return model->frictional && !(model->traits & NORMAL_MINDLIN);
}

static bool has_force(const struct contact_model *model)
{
    return model->frictional && model->traits & NORMAL_MINDLIN;
}

static bool has_rolling(const struct contact_model *model)
{
    return model->rolling;
}

static bool has_torsion(const struct contact_model *model)
{
    return model->torsion;
}

struct row {
    struct history_field field;
    bool (*has)(const struct contact_model *model);
};

#define NUMBER(name_, unit_, length_, has_)                                                                            \
    {                                                                                                                  \
        {.name = name_, .unit = unit_, .kind = HISTORY_NUMBER, .component = -1, .length = length_}, has_               \
    }

#define COMPONENT(name_, unit_, kind_, c, rest_, is_rest_, force_, has_)                                               \
    {                                                                                                                  \
        {.name = name_,                                                                                                \
         .unit = unit_,                                                                                                \
         .kind = kind_,                                                                                                \
         .component = c,                                                                                               \
         .rest = rest_,                                                                                                \
         .force = force_,                                                                                              \
         .is_rest = is_rest_},                                                                                         \
            has_                                                                                                       \
    }
/* Three components, and the three of what rounding leaves out of them. */
#define VECTOR(column, rest_, name_, unit_, kind_, force_, has_)                                                       \
    [column] = COMPONENT(name_, unit_, kind_, 0, rest_, false, force_, has_),                                          \
    [column + 1] = COMPONENT(name_, unit_, kind_, 1, rest_ + 1, false, force_, has_),                                  \
    [column + 2] = COMPONENT(name_, unit_, kind_, 2, rest_ + 2, false, force_, has_),                                  \
    [rest_] = COMPONENT(name_ "_rest", unit_, kind_, 0, 0, true, force_, has_),                                        \
    [rest_ + 1] = COMPONENT(name_ "_rest", unit_, kind_, 1, 0, true, force_, has_),                                    \
    [rest_ + 2] = COMPONENT(name_ "_rest", unit_, kind_, 2, 0, true, force_, has_)

static const struct row table[HISTORY_COLUMNS] = {
    [HISTORY_MAX_OVERLAP] = NUMBER("max_overlap", "m", true, has_max_overlap),
    VECTOR(HISTORY_SPRING, HISTORY_SPRING_REST, "spring", "m", HISTORY_TANGENT, false, has_spring),
    VECTOR(HISTORY_FORCE, HISTORY_FORCE_REST, "tangential_force", "N", HISTORY_TANGENT, true, has_force),
    [HISTORY_CONTACT_RADIUS] = NUMBER("contact_radius", "m", true, has_force),
    [HISTORY_SLIDING] = NUMBER("sliding", "1", false, has_friction),
    VECTOR(HISTORY_ROLLING, HISTORY_ROLLING_REST, "rolling_spring", "m", HISTORY_ROTATION, false, has_rolling),
    [HISTORY_TORSION] =
        COMPONENT("torsion_spring", "m", HISTORY_NUMBER, -1, HISTORY_TORSION_REST, false, false, has_torsion),
    [HISTORY_TORSION_REST] = COMPONENT("torsion_spring_rest", "m", HISTORY_NUMBER, -1, 0, true, false, has_torsion),
};

const struct history_field *history_field(int c)
{
    return &table[c].field;
}

bool history_has(const struct contact_model *model, int c)
{
    const struct history_field *field = &table[c].field;
    const int components = model->dimension == 2 ? 1 : 3;
    return table[c].has(model) && field->component < components && (model->mixed || !field->is_rest);
}

bool history_is_odd(const struct contact_model *model, int c)
{
    const enum history_kind kind = table[c].field.kind;
    return kind == HISTORY_ROTATION || (kind == HISTORY_TANGENT && model->dimension == 3);
}

int history_shown(const struct contact_model *model, int *column)
{
    int n = 0;
    for (int c = 0; c < HISTORY_COLUMNS && n < HISTORY_FIELDS_MAX; c++) {
        const struct history_field *field = &table[c].field;
        if (history_has(model, c) && !field->is_rest && field->component <= 0 && c != HISTORY_SLIDING)
            column[n++] = c;
    }
    return n;
}
