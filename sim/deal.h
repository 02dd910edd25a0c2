/* Which member of a pair has it in its slots. Slots that stay empty cost the kernels as much as full ones, so the
 * particles of a block, who share its rows of slots, should have about as many pairs each. */
#ifndef SHAKEDOWN_SIM_DEAL_H
#define SHAKEDOWN_SIM_DEAL_H

#include "sim/contacts.h"

/* Blocks of `width` particles, HALF_WIDTH or SET_WIDTH, and their rows of `width` slots each: block b has count[b + 1]
 * - count[b], and if `chained` one more, that of each particle's neighbour in the order. The sets of span s are span[s]
 * ... span[s + 1] - 1 (contacts.h); half a set may be nobody's. */
struct deal {
    int width, n_blocks, n_spans;
    bool chained;
    const int32_t *count; /* [n_blocks + 1] in the list's working memory, until it is dealt out again */
    const int32_t *span;  /* [n_spans + 1] there too */
};

/* The row of neighbours in the order, and the first of the others, of block b: slots width row and on. */
int deal_next_row(const struct deal *deal, int b);
int deal_other_row(const struct deal *deal, int b);

/* Deals the pairs of the list (i < j, of n_particles) out: list->slot and list->n_sets. The same list and search_max
 * give the same slots. Errors: STATUS_NO_MEMORY. */
enum status deal_pairs(struct contact_list *list, int n_particles, int width, struct deal *deal) MUST_USE;

#endif
