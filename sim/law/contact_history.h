/* What contacts remember: one table for everything that keeps, moves or shows it. */
#ifndef SHAKEDOWN_SIM_LAW_CONTACT_HISTORY_H
#define SHAKEDOWN_SIM_LAW_CONTACT_HISTORY_H

#include "common/history_kind.h"
#include "sim/law/contact_model.h"

/* The columns; a vector takes three side by side, of which 2D uses the first. */
enum history_column {
    HISTORY_MAX_OVERLAP,
    HISTORY_SPRING,
    HISTORY_SPRING_REST = HISTORY_SPRING + 3,
    HISTORY_FORCE = HISTORY_SPRING_REST + 3,
    HISTORY_FORCE_REST = HISTORY_FORCE + 3,
    HISTORY_CONTACT_RADIUS = HISTORY_FORCE_REST + 3,
    HISTORY_SLIDING,
    HISTORY_ROLLING,
    HISTORY_ROLLING_REST = HISTORY_ROLLING + 3,
    HISTORY_TORSION = HISTORY_ROLLING_REST + 3,
    HISTORY_TORSION_REST,
    HISTORY_COLUMNS
};

struct history_field {
    const char *name; /* of the field, as in checkpoints, frames and --explain */
    const char *unit;
    enum history_kind kind; /* 2D: a tangent is a number along a tangent that turns with n, a rotation one about it */
    int component;          /* of a vector; -1: a number */
    int rest;               /* the column that has what rounding left out of this one, in mixed precision; 0: none */
    bool length;            /* kept in the unit of the slots (contact_slots.unit) */
    bool force;             /* kept in that of forces (contact_slots.force_unit) */
    bool is_rest;           /* of another column; mixed precision only */
};

/* What a model must have to have a field, in the order of the table. */
enum history_need {
    HISTORY_OF_LARGEST_OVERLAP,
    HISTORY_OF_SPRING,
    HISTORY_OF_MINDLIN,
    HISTORY_OF_FRICTION,
    HISTORY_OF_ROLLING,
    HISTORY_OF_TORSION
};

/* The table: NUMBER(column, need, name, unit, kind, rest, length, is_rest), and VECTOR(column, rest, need, name, unit,
 * kind, force), three components and the three of what rounding leaves out of them. */
#define HISTORY_TABLE(NUMBER, VECTOR)                                                                                  \
    NUMBER(HISTORY_MAX_OVERLAP, HISTORY_OF_LARGEST_OVERLAP, "max_overlap", "m", HISTORY_NUMBER, 0, true, false)        \
    VECTOR(HISTORY_SPRING, HISTORY_SPRING_REST, HISTORY_OF_SPRING, "spring", "m", HISTORY_TANGENT, false)              \
    VECTOR(HISTORY_FORCE, HISTORY_FORCE_REST, HISTORY_OF_MINDLIN, "tangential_force", "N", HISTORY_TANGENT, true)      \
    NUMBER(HISTORY_CONTACT_RADIUS, HISTORY_OF_MINDLIN, "contact_radius", "m", HISTORY_NUMBER, 0, true, false)          \
    NUMBER(HISTORY_SLIDING, HISTORY_OF_FRICTION, "sliding", "1", HISTORY_NUMBER, 0, false, false)                      \
    VECTOR(HISTORY_ROLLING, HISTORY_ROLLING_REST, HISTORY_OF_ROLLING, "rolling_spring", "m", HISTORY_ROTATION, false)  \
    NUMBER(HISTORY_TORSION, HISTORY_OF_TORSION, "torsion_spring", "m", HISTORY_NUMBER, HISTORY_TORSION_REST, false,    \
           false)                                                                                                      \
    NUMBER(HISTORY_TORSION_REST, HISTORY_OF_TORSION, "torsion_spring_rest", "m", HISTORY_NUMBER, 0, false, true)

/* Column c of a contact. */
const struct history_field *history_field(int c);

static inline bool history_meets(const struct contact_model *model, enum history_need need)
{
    const bool friction = model->frictional, mindlin = model->traits & NORMAL_MINDLIN;
    return need == HISTORY_OF_LARGEST_OVERLAP ? (model->traits & NORMAL_REMEMBERS_OVERLAP) != 0
           : need == HISTORY_OF_SPRING        ? friction && !mindlin
           : need == HISTORY_OF_MINDLIN       ? friction && mindlin
           : need == HISTORY_OF_FRICTION      ? friction
           : need == HISTORY_OF_ROLLING       ? model->rolling
                                              : model->torsion;
}

/* How many columns a model has before column c: its place among them, the same for kernels, where it is a constant, and
 * for all else. */
static inline int history_place(const struct contact_model *model, int c)
{
    const int components = model->dimension == 2 ? 1 : 3;
    int n = 0;
#define HISTORY_COUNT_NUMBER(column, need, name, unit, kind, rest_of, length, is_rest)                                 \
    n += (column) < c && history_meets(model, need) && (model->mixed || !(is_rest));
#define HISTORY_COUNT_VECTOR(column, rest_of, need, name, unit, kind, force)                                           \
    if (history_meets(model, need)) {                                                                                  \
        n += (column) < c ? c - (column) < components ? c - (column) : components : 0;                                 \
        n += model->mixed && (rest_of) < c ? c - (rest_of) < components ? c - (rest_of) : components : 0;              \
    }
    HISTORY_TABLE(HISTORY_COUNT_NUMBER, HISTORY_COUNT_VECTOR)
#undef HISTORY_COUNT_NUMBER
#undef HISTORY_COUNT_VECTOR
    return n;
}

/* Whether a model has column c; and whether that changes its sign when i and j change places. */
static inline bool history_has(const struct contact_model *model, int c)
{
    return history_place(model, c + 1) > history_place(model, c);
}
bool history_is_odd(const struct contact_model *model, int c);

/* The fields of a model that frames show, rests added in, by the first column of each, [HISTORY_FIELDS_MAX]; returns
 * their number. Left out is `sliding`, which frames have beside them. */
int history_shown(const struct contact_model *model, int *column);

#endif
