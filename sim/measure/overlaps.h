/* The extremes of a sample that tell that its model does not hold any more. */
#ifndef SHAKEDOWN_SIM_MEASURE_OVERLAPS_H
#define SHAKEDOWN_SIM_MEASURE_OVERLAPS_H

#include "sim/sample/sample.h"

/* The largest overlap over the smaller radius; 0: nothing touches. */
struct largest_overlap {
    double ratio;
    int i, j; /* ids; j < 0: wall -1-j */
};

/* Of the positions as they are now; the last step need not be complete. */
struct largest_overlap overlaps_largest(struct sample *sample);

/* The overlap, over the smallest radius, that a head-on contact of two particles of the largest speed there is would
 * reach in loading: beyond 1 they pass through each other. */
double overlaps_of_fastest(const struct sample *sample);

#endif
