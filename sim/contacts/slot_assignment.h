/* Which member of a pair has it in its slots. Slots that stay empty cost the kernels as much as full ones, so the
 * particles of a block, who share its rows of slots, should have about as many pairs each. */
#ifndef SHAKEDOWN_SIM_CONTACTS_SLOT_ASSIGNMENT_H
#define SHAKEDOWN_SIM_CONTACTS_SLOT_ASSIGNMENT_H

#include "sim/contacts/contact_list.h"

/* Blocks of `width` particles, HALF_WIDTH or SET_WIDTH, and their rows of `width` slots each: block b has
 * slot_assignment_rows of them, and if `chained` one more, that of each particle's neighbour in the order. Rows of
 * blocks that share SET_WIDTH particles side by side are whole sets, as far as all of these blocks have them. The sets
 * of span s are span[s] ... span[s + 1] - 1 (contacts.h); half a set may be nobody's. In the list's working memory,
 * until it is dealt out again:
 */
struct slot_assignment {
    int width, span_width, n_blocks, n_spans;
    bool chained;
    const int32_t *whole; /* [n_blocks + 2] whole sets of those who share before those who block b shares with */
    const int32_t *lone;  /* [n_blocks + 1] other rows before those of block b */
    const int32_t *span;  /* [n_spans + 1] */
};

/* Of block b the row of neighbours in the order; how many others there are; and the k-th of them: row r has slots width
 * r and on. */
int slot_assignment_chain_row(const struct slot_assignment *assignment, int b);
int slot_assignment_rows(const struct slot_assignment *assignment, int b);
int slot_assignment_row(const struct slot_assignment *assignment, int b, int k);

/* Of span s the first whole set, and the first that may have two halves that stand apart. */
int slot_assignment_whole_set(const struct slot_assignment *assignment, int s);
int slot_assignment_halves_set(const struct slot_assignment *assignment, int s);

/* Deals the pairs of the list (i < j, of n_particles) out, in spans of span_width particles: list->slot and
 * list->n_sets. If they are in floats, in rows of HALF_WIDTH, partners half a row apart are not the same one, for
 * kernels add to the sums of both at once. The same list and search_max give the same slots. Errors: STATUS_NO_MEMORY.
 */
enum status slot_assignment_make(struct contact_list *list, int n_particles, int width, int span_width,
                                 struct slot_assignment *assignment) MUST_USE;

#endif
