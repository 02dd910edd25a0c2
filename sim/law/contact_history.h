/* What contacts remember: one table for everything that keeps, moves or shows it. */
#ifndef SHAKEDOWN_SIM_LAW_CONTACT_HISTORY_H
#define SHAKEDOWN_SIM_LAW_CONTACT_HISTORY_H

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
    int component; /* of a vector; -1: a number */
    bool length;   /* kept in the unit of the slots (contact_slots.unit) */
    bool force;    /* kept in that of forces (contact_slots.force_unit) */
    bool odd; /* in 3D the other sign when i and j change places; in 2D a number along a tangent that turns with n */
    bool odd_in_plane; /* the other sign in 2D */
    bool rest;         /* what rounding left out of another field; mixed precision only */
};

/* Column c of a contact. */
const struct history_field *history_field(int c);

/* Whether a model has column c; and whether that changes its sign when i and j change places. */
bool history_has(const struct contact_model *model, int c);
bool history_is_odd(const struct contact_model *model, int c);

#endif
