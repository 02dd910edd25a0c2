/* Verlet lists from grids of cells: candidates within a skin, rebuilt when something has moved half the skin. The
 * history of contacts is carried over. */
#ifndef SHAKEDOWN_SIM_NEIGHBOURS_VERLET_LIST_H
#define SHAKEDOWN_SIM_NEIGHBOURS_VERLET_LIST_H

#include <stdbool.h>
#include <stdint.h>

#include "sim/contacts/contact_list.h"
#include "sim/grains/particles.h"
#include "sim/neighbours/cell_list.h"
#include "sim/neighbours/pair_search.h"

/* What the threads of a large sample find each on its own. */
struct verlet_piece {
    struct search_block block;
    struct pair_buffer found;
    int32_t *of_span; /* [n_spans] pairs by the span of i; then where the next one goes */
    enum status status;
};

struct verlet_list {
    struct thread_team *team;   /* NULL: the caller alone, with one piece */
    struct verlet_piece *piece; /* [n_pieces] */
    int n_pieces, n_spans;
    int32_t *span_first; /* [n_spans + 1] where the pairs of each span start in the list */
    double skin;         /* of the lists as they are [m] */
    double skin_fixed;   /* what the scene asks for [m]; 0: tuned while running */
    double mean_radius;  /* m */
    int64_t built_step;  /* of the last build */
    int64_t rebuilds;
    int64_t renumber_steps; /* particles are renumbered at multiples of this; 0: never */
    struct search search;
    struct cell_list cells;
    struct pair_buffer half_sorted;
    int32_t *first_pair_of; /* [count + 2] where the pairs of each i start */
    int32_t *source;        /* where the history of a candidate comes from; -1: it is new */
    int source_capacity;
    struct contact_list spare_pairs, spare_wall; /* the lists under construction */
};

/* Prepares lists for particles and contacts of a model, built by a team, or, without one (NULL), by the caller alone:
 * the same lists. skin_ratio: skin over the mean radius; 0: tuned while running. Errors: STATUS_NO_MEMORY. */
enum status verlet_list_init(struct verlet_list *verlet, const struct particles *particles, double skin_ratio,
                             const struct contact_model *model, enum instruction_set isa,
                             struct thread_team *team) MUST_USE;
void verlet_list_free(struct verlet_list *verlet);

/* Builds `pairs` and the walls' lists anew for the current positions: every pair closer than the radii and the skin,
 * sorted by (i, j). Errors: STATUS_NO_MEMORY, STATUS_LIMIT (too many pairs). */
enum status verlet_list_build(struct verlet_list *verlet, struct particles *particles, struct contact_list *pairs,
                              struct wall *walls, int n_walls) MUST_USE;

/* Chooses the skin of the build that is due at `step`, from how fast the last one was used up: by counts of steps and
 * lengths alone, so that runs repeat. */
void verlet_list_tune(struct verlet_list *verlet, const struct particles *particles, const struct wall *walls,
                      int n_walls, int64_t step);

/* How hard to look for an even filling of the sets (contact_list.search_max) in a build at `step`: the harder, the
 * longer the last lists lived. */
int verlet_list_search_max(const struct verlet_list *verlet, int64_t step);

/* Whether the skin has turned out far too wide, so that a build is worth its cost. Looked at ever more seldom. */
bool verlet_list_is_wide(const struct verlet_list *verlet, const struct particles *particles, const struct wall *walls,
                         int n_walls, int64_t step);

#endif
