/* Which member of a pair has it in its slots. Slots that stay empty cost the kernels as much as full ones, so the
 * SET_WIDTH particles of a block, who share its sets, should have about as many pairs each. */
#ifndef SHAKEDOWN_SIM_DEAL_H
#define SHAKEDOWN_SIM_DEAL_H

#include "sim/contacts.h"

/* Sets of the blocks: block b, particles SET_WIDTH b and on, has sets first[b] ... first[b + 1] - 1. */
struct deal {
    int n_blocks;
    const int32_t *first; /* [n_blocks + 1] in the list's working memory, until it is dealt out again */
};

/* Deals the pairs of the list (i < j, of n_particles) out: list->slot and list->n_sets. The same list and search_max
 * give the same slots. Errors: STATUS_NO_MEMORY. */
enum status deal_pairs(struct contact_list *list, int n_particles, struct deal *deal) MUST_USE;

#endif
