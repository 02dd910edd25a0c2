/* Particles put into an order in which neighbours in space are neighbours in memory, now and then. Every particle keeps
 * its id; records and hashes are in the order of ids. */
#ifndef SHAKEDOWN_SIM_NEIGHBOURS_LOCALITY_ORDER_H
#define SHAKEDOWN_SIM_NEIGHBOURS_LOCALITY_ORDER_H

#include "sim/neighbours/verlet_list.h"

/* Steps between renumberings as the scene says, or by the number of particles; 0: never. */
int64_t locality_order_interval(int64_t scene_steps, int count);

/* Sorts the particles along paths from candidate to candidate (neighbour_chains.h), by rows of cells, slabs along the
 * longest side of the sample; large samples by compact boxes of a span each first (bisection.h). Lists and histories go
 * with them. The order depends on positions, candidates and on the
 * order so far, on nothing else. To be followed by drift (the records are stale) and verlet_list_build. Errors:
 * STATUS_NO_MEMORY. */
enum status locality_order_apply(struct particles *particles, struct contact_list *pairs, struct wall *walls,
                                 int n_walls) MUST_USE;

#endif
