/* Particles sorted into the cells of a grid. Particles of very different sizes are sorted into several grids, one for
 * each class of radii (a factor of two), so that a large particle does not make the small ones' cells large. */
#ifndef SHAKEDOWN_SIM_NEIGHBOURS_CELL_LIST_H
#define SHAKEDOWN_SIM_NEIGHBOURS_CELL_LIST_H

#include <stdint.h>

#include "sim/base/thread_team.h"
#include "sim/grains/particles.h"

enum { CELL_LEVELS_MAX = 12 };

/* A grid over the bounding box of all centres; its cells are wider than any two of its particles reach. */
struct cell_grid {
    int n[3];       /* cells along each axis; 1 along axes that are not there */
    int first;      /* index of its first cell in cell_first */
    int count;      /* particles in it; 0: nothing else is set */
    double largest; /* radius [m] */
    double reach;   /* two of its largest particles and the skin [m] */
    double size[3]; /* of a cell [m] */
    double inverse_size[3];
};

struct cell_list {
    int dimension, n_levels, total;
    int most;                                /* particles in one cell */
    double lo[3], hi[3];                     /* of the centres [m] */
    struct cell_grid level[CELL_LEVELS_MAX]; /* the largest particles first */
    int32_t *cell_of;                        /* [count] */
    int32_t *cell_first;                     /* [total + 1] range in by_cell; of all levels, one after the other */
    int32_t *by_cell;                        /* [count] particles sorted by cell, rising within each */
    double *x[3], *radius;                   /* [count] in the order of by_cell */
    uint8_t *level_of;                       /* [count] */
    int capacity;                            /* of cell_first */
};

/* Errors: STATUS_NO_MEMORY. */
enum status cell_list_init(struct cell_list *cells, const struct particles *particles) MUST_USE;
void cell_list_free(struct cell_list *cells);

/* Sorts the particles where they are now; cells are at least twice the largest radius of their level and `skin_m` wide.
 * The team may be NULL. Errors: STATUS_NO_MEMORY. */
enum status cell_list_sort(struct cell_list *cells, const struct particles *particles, double skin_m,
                           struct thread_team *team) MUST_USE;

/* Smallest and largest of x [n], n > 0. */
void cell_list_range(const double *x, int n, double *lowest, double *highest);

#endif
