/* Verlet lists from a grid of cells: candidates within a skin, rebuilt when something has moved half the skin. The
 * history of contacts is carried over. */
#ifndef SHAKEDOWN_SIM_NEIGHBOR_H
#define SHAKEDOWN_SIM_NEIGHBOR_H

#include <stdbool.h>
#include <stdint.h>

#include "sim/contacts.h"
#include "sim/particles.h"

struct neighbor {
    double skin; /* m */
    int64_t rebuilds;
    int32_t *cell_of;    /* [count] */
    int32_t *cell_first; /* [cells + 1] range in by_cell */
    int32_t *by_cell;    /* [count] particles sorted by cell */
    double *sorted_x[3]; /* positions and radii in the order of by_cell */
    double *sorted_radius;
    int cell_capacity;
    struct contact_list spare_pairs, spare_wall; /* the lists under construction */
};

/* Prepares lists for the model of `particles`; skin in m. Errors: STATUS_NO_MEMORY. */
enum status neighbor_init(struct neighbor *neighbor, const struct particles *particles, double skin_m,
                          bool hysteretic) MUST_USE;
void neighbor_free(struct neighbor *neighbor);

/* Builds `pairs` and the walls' lists anew for the current positions. Errors: STATUS_NO_MEMORY. */
enum status neighbor_build(struct neighbor *neighbor, struct particles *particles, struct contact_list *pairs,
                           struct wall *walls, int n_walls) MUST_USE;

#endif
