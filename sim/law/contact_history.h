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

/* Column c of a contact. */
const struct history_field *history_field(int c);

/* Whether a model has column c; and whether that changes its sign when i and j change places. */
bool history_has(const struct contact_model *model, int c);
bool history_is_odd(const struct contact_model *model, int c);

/* The fields of a model that frames show, rests added in, by the first column of each, [HISTORY_FIELDS_MAX]; returns
 * their number. Left out is `sliding`, which frames have beside them. */
int history_shown(const struct contact_model *model, int *column);

#endif
