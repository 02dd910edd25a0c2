/* Cells that find which particles of a packing without contacts a new one would overlap. */
#ifndef SHAKEDOWN_SIM_SAMPLE_PACKING_GRID_H
#define SHAKEDOWN_SIM_SAMPLE_PACKING_GRID_H

#include "sim/grains/particles.h"

/* Cells at least as large as the largest particle, and not many more of them than particles; each lists its particles
 * by links. */
struct packing_grid {
    int cells[3];
    double lo[3], size[3];
    int *first; /* of each cell, -1 ends */
    int *next;  /* of each particle */
};

/* For the box lo, hi [dimension], in m. Errors: STATUS_NO_MEMORY. Free it in any case. */
enum status packing_grid_init(struct packing_grid *grid, const struct particles *p, const double *lo, const double *hi,
                              double diameter_m) MUST_USE;
void packing_grid_free(struct packing_grid *grid);

/* Particle i, whose position is set, belongs to the packing. */
void packing_grid_insert(struct packing_grid *grid, const struct particles *p, int i);

/* The first particle found that overlaps a sphere of `radius` at x [dimension] by more than `ratio` of the smaller
 * radius; -1: none does. */
int packing_grid_overlap(const struct packing_grid *grid, const struct particles *p, const double *x, double radius,
                         double ratio);

#endif
