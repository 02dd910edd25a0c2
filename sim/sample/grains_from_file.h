/* A sample whose grains a table gives. */
#ifndef SHAKEDOWN_SIM_SAMPLE_GRAINS_FROM_FILE_H
#define SHAKEDOWN_SIM_SAMPLE_GRAINS_FROM_FILE_H

#include "sim/grains/particles.h"

/* Radii, masses, positions, velocities and spins from the file of the scene, in its order; box_lo_m, box_hi_m
 * [dimension] become the box that the scene says, or that the grains touch. Errors: as of grain_file_read;
 * STATUS_CONFIG ("file:line: ...") for a content that is not the one the scene was checked with, grains outside of the
 * box, overlaps beyond sample.overlap_ratio, spins in a scene without friction. */
enum status grains_from_file(struct particles *p, const struct scene *scene, double *box_lo_m,
                             double *box_hi_m) MUST_USE;

#endif
