/* Verlet lists from grids of cells: candidates within a skin, rebuilt when something has moved half the skin. The
 * history of contacts is carried over. */
#ifndef SHAKEDOWN_SIM_NEIGHBOR_H
#define SHAKEDOWN_SIM_NEIGHBOR_H

#include <stdbool.h>
#include <stdint.h>

#include "sim/cells.h"
#include "sim/contacts.h"
#include "sim/particles.h"
#include "sim/search.h"

struct neighbor {
    double skin;        /* of the lists as they are [m] */
    double skin_fixed;  /* what the scene asks for [m]; 0: tuned while running */
    double mean_radius; /* m */
    int64_t built_step; /* of the last build */
    int64_t rebuilds;
    int64_t renumber_steps; /* particles are renumbered at multiples of this; 0: never */
    struct search search;
    struct cells cells;
    struct search_block block;
    struct pair_buffer found, half_sorted;
    int32_t *row_first; /* [count + 2] where the pairs of each i start */
    int32_t *source;    /* where the history of a candidate comes from; -1: it is new */
    int source_capacity;
    struct contact_list spare_pairs, spare_wall; /* the lists under construction */
};

/* Prepares lists for the model of `particles`. skin_ratio: skin over the mean radius; 0: tuned while running. Errors:
 * STATUS_NO_MEMORY. */
enum status neighbor_init(struct neighbor *neighbor, const struct particles *particles, double skin_ratio,
                          bool hysteretic, enum kernel_isa isa) MUST_USE;
void neighbor_free(struct neighbor *neighbor);

/* Builds `pairs` and the walls' lists anew for the current positions: every pair closer than the radii and the skin,
 * sorted by (i, j). Errors: STATUS_NO_MEMORY, STATUS_LIMIT (too many pairs). */
enum status neighbor_build(struct neighbor *neighbor, struct particles *particles, struct contact_list *pairs,
                           struct wall *walls, int n_walls) MUST_USE;

/* Chooses the skin of the build that is due at `step`, from how fast the last one was used up: by counts of steps and
 * lengths alone, so that runs repeat. */
void neighbor_tune(struct neighbor *neighbor, const struct particles *particles, const struct wall *walls, int n_walls,
                   int64_t step);

/* How hard to look for an even filling of the sets (contact_list.search_max) in a build at `step`: the harder, the
 * longer the last lists lived. */
int neighbor_search_max(const struct neighbor *neighbor, int64_t step);

/* Whether the skin has turned out far too wide, so that a build is worth its cost. Looked at ever more seldom. */
bool neighbor_is_wide(const struct neighbor *neighbor, const struct particles *particles, const struct wall *walls,
                      int n_walls, int64_t step);

#endif
