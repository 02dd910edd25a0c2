/* The history of contacts on its way from one list to the next. */
#ifndef SHAKEDOWN_SIM_NEIGHBOURS_HISTORY_TRANSFER_H
#define SHAKEDOWN_SIM_NEIGHBOURS_HISTORY_TRANSFER_H

#include "sim/contacts/contact_list.h"
#include "sim/neighbours/pair_search.h"

/* Closes `list` with the history of the members source[k] of `before`, a list of the same model, for each member k;
 * none where source[k] < 0. From slot to slot: the lists' own arrays of the history are not touched. Errors: as of
 * contact_list_close. */
enum status history_transfer_close(struct contact_list *list, const struct particles *particles,
                                   const struct wall *wall, struct contact_list *before, const int32_t *source,
                                   const struct search *search) MUST_USE;

#endif
