/* Which member of a pair has it in its slots. Slots that stay empty cost the kernels as much as full ones, so the
 * SET_WIDTH particles of a block, who share its sets, should have about as many pairs each. */
#ifndef SHAKEDOWN_SIM_DEAL_H
#define SHAKEDOWN_SIM_DEAL_H

#include "sim/contacts.h"

/* Sets of the blocks, particles SET_WIDTH b and on: block b has count[b + 1] - count[b], and if `chained` one more,
 * that of each particle's neighbour in the order. Those of a span of blocks follow each other (contacts.h). */
struct deal {
    int n_blocks;
    bool chained;
    const int32_t *count; /* [n_blocks + 1] in the list's working memory, until it is dealt out again */
};

/* The set of neighbours in the order, and the first of the others, of block b. */
int deal_next_set(const struct deal *deal, int b);
int deal_other_set(const struct deal *deal, int b);

/* Deals the pairs of the list (i < j, of n_particles) out: list->slot and list->n_sets. The same list and search_max
 * give the same slots. Errors: STATUS_NO_MEMORY. */
enum status deal_pairs(struct contact_list *list, int n_particles, struct deal *deal) MUST_USE;

#endif
