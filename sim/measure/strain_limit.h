/* Whether the strains of a scene leave the particles room: known before the first step. */
#ifndef SHAKEDOWN_SIM_MEASURE_STRAIN_LIMIT_H
#define SHAKEDOWN_SIM_MEASURE_STRAIN_LIMIT_H

#include "sim/sample/sample.h"

/* The densest that particles can be without overlaps beyond `overlap_ratio` of their radius on average: those that fill
 * space without a gap and then shrink with it, 1/(1 - overlap_ratio/2)^d. No packing bears more. */
double strain_limit_solid_fraction(int dimension, double overlap_ratio);

/* STATUS_CONFIG, with stage and keys, if the walls of a stage from `first` on, all of them at rest or led by strains,
 * make the box smaller than that. The sample is at the start of stage `first`; later stages are looked at as long as no
 * axis answers stresses and no condition may end a stage sooner, as the box is not known after that. */
enum status strain_limit_check(const struct sample *sample, int first) MUST_USE;

#endif
