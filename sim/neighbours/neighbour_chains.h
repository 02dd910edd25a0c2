/* An order in which most particles have a candidate for contact right behind them, for sets of such pairs
 * (slot_assignment.h). */
#ifndef SHAKEDOWN_SIM_NEIGHBOURS_NEIGHBOUR_CHAINS_H
#define SHAKEDOWN_SIM_NEIGHBOURS_NEIGHBOUR_CHAINS_H

#include "sim/contacts/contact_list.h"

/* Paths from candidate to candidate, one after the other. order[k]: the k-th particle of an order that brings
 * neighbours together, which decides where there is a choice; it becomes the order of the paths. Errors:
 * STATUS_NO_MEMORY. */
enum status neighbour_chains_order(const struct contact_list *pairs, int n_particles, int32_t *order) MUST_USE;

#endif
