/* Radii by number, and grading curves: passing by mass against diameter, straight lines in ln(diameter) between the
 * points of a table. */
#ifndef SHAKEDOWN_COMMON_SIZE_DISTRIBUTION_H
#define SHAKEDOWN_COMMON_SIZE_DISTRIBUTION_H

#include "common/scene.h"

/* Part of an uncut Gaussian or lognormal distribution that lies between radius_min_m and radius_max_m. */
double size_part_within(const struct scene_sample *sample);

/* Sets mean_radius_m and mean_cube_m3 of the distribution as it is drawn from; a cut Gaussian as if it were not cut. */
void size_moments_set(struct scene_sample *sample);

/* Passing by mass of the table at a diameter. */
double size_table_passing(const struct scene_sample *sample, double diameter_m);

/* Radius of particle k of `count`, in increasing order. The number distribution of the curve is cut into `count` equal
 * parts; each particle has the mass of its part, so that the curve of the sample is that of the table within one
 * particle. */
double size_table_radius_m(const struct scene_sample *sample, int64_t k, int64_t count);

/* Diameter at which `passing` of the mass is finer: "d50" and the like. Of the table only. */
double size_table_diameter_m(const struct scene_sample *sample, double passing);

#endif
