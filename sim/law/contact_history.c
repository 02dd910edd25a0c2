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
    return model->rolling && model->dimension == 3;
}

struct row {
    struct history_field field;
    bool (*has)(const struct contact_model *model);
};

#define NUMBER(name_, unit_, length_, has_)                                                                            \
    {                                                                                                                  \
        {.name = name_, .unit = unit_, .component = -1, .length = length_}, has_                                       \
    }
#define COMPONENT(name_, unit_, c, rest_, force_, has_)                                                                \
    {                                                                                                                  \
        {.name = name_, .unit = unit_, .component = c, .odd = true, .rest = rest_, .force = force_}, has_              \
    }

/* a' (omega_i - omega_j) changes its sign with i and j in any dimension; along n it does not */
#define ROLLED(name_, c, rest_)                                                                                        \
    {                                                                                                                  \
        {.name = name_, .unit = "m", .component = c, .odd = true, .odd_in_plane = true, .rest = rest_}, has_rolling    \
    }

static const struct row table[HISTORY_COLUMNS] = {
    [HISTORY_MAX_OVERLAP] = NUMBER("max_overlap", "m", true, has_max_overlap),
    [HISTORY_SPRING] = COMPONENT("spring", "m", 0, false, false, has_spring),
    [HISTORY_SPRING + 1] = COMPONENT("spring", "m", 1, false, false, has_spring),
    [HISTORY_SPRING + 2] = COMPONENT("spring", "m", 2, false, false, has_spring),
    [HISTORY_SPRING_REST] = COMPONENT("spring_rest", "m", 0, true, false, has_spring),
    [HISTORY_SPRING_REST + 1] = COMPONENT("spring_rest", "m", 1, true, false, has_spring),
    [HISTORY_SPRING_REST + 2] = COMPONENT("spring_rest", "m", 2, true, false, has_spring),
    [HISTORY_FORCE] = COMPONENT("tangential_force", "N", 0, false, true, has_force),
    [HISTORY_FORCE + 1] = COMPONENT("tangential_force", "N", 1, false, true, has_force),
    [HISTORY_FORCE + 2] = COMPONENT("tangential_force", "N", 2, false, true, has_force),
    [HISTORY_FORCE_REST] = COMPONENT("tangential_force_rest", "N", 0, true, true, has_force),
    [HISTORY_FORCE_REST + 1] = COMPONENT("tangential_force_rest", "N", 1, true, true, has_force),
    [HISTORY_FORCE_REST + 2] = COMPONENT("tangential_force_rest", "N", 2, true, true, has_force),
    [HISTORY_CONTACT_RADIUS] = NUMBER("contact_radius", "m", true, has_force),
    [HISTORY_SLIDING] = NUMBER("sliding", "1", false, has_friction),
    [HISTORY_ROLLING] = ROLLED("rolling_spring", 0, false),
    [HISTORY_ROLLING + 1] = ROLLED("rolling_spring", 1, false),
    [HISTORY_ROLLING + 2] = ROLLED("rolling_spring", 2, false),
    [HISTORY_ROLLING_REST] = ROLLED("rolling_spring_rest", 0, true),
    [HISTORY_ROLLING_REST + 1] = ROLLED("rolling_spring_rest", 1, true),
    [HISTORY_ROLLING_REST + 2] = ROLLED("rolling_spring_rest", 2, true),
    [HISTORY_TORSION] = NUMBER("torsion_spring", "m", false, has_torsion),
    [HISTORY_TORSION_REST] = {{.name = "torsion_spring_rest", .unit = "m", .component = -1, .rest = true}, has_torsion},
};

const struct history_field *history_field(int c)
{
    return &table[c].field;
}

bool history_has(const struct contact_model *model, int c)
{
    const struct history_field *field = &table[c].field;
    const int components = model->dimension == 2 ? 1 : 3;
    return table[c].has(model) && field->component < components && (model->single || !field->rest);
}

bool history_is_odd(const struct contact_model *model, int c)
{
    return model->dimension == 3 ? table[c].field.odd : table[c].field.odd_in_plane;
}
