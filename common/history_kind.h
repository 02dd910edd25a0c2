/* What a field of a contact's history is, which decides how it turns with the contact and how records show it. */
#ifndef SHAKEDOWN_COMMON_HISTORY_KIND_H
#define SHAKEDOWN_COMMON_HISTORY_KIND_H

/* Of a contact a record has one number, or the components of a vector: of a position [dimension], of a rotation one
 * about y in 2D, three in 3D. */
enum history_kind {
    HISTORY_NUMBER,   /* the same seen from either particle */
    HISTORY_TANGENT,  /* vector along the contact's plane, of i against j */
    HISTORY_ROTATION, /* vector of a rotation, of i against j */
    HISTORY_KINDS
};

enum { HISTORY_FIELDS_MAX = 16, HISTORY_NAME_MAX = 48, HISTORY_UNIT_MAX = 16 }; /* of a model; bytes with the zero */

/* Values per contact in records. */
static inline int history_kind_values(enum history_kind kind, int dimension)
{
    return kind == HISTORY_NUMBER ? 1 : kind == HISTORY_ROTATION && dimension == 2 ? 1 : dimension;
}

#endif
