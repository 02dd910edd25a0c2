/* The extremes of a sample that tell that its model does not hold any more. */
#ifndef SHAKEDOWN_SIM_MEASURE_OVERLAPS_H
#define SHAKEDOWN_SIM_MEASURE_OVERLAPS_H

#include "sim/measure/passing_watch.h"
#include "sim/sample/sample.h"

/* The largest overlap over the smaller radius; 0: nothing touches. */
struct largest_overlap {
    double ratio;
    int i, j; /* ids; j < 0: wall -1-j */
};

/* A look at the positions as they are now; the last step need not be complete. `passing`: who sees in the same walk
 * which particles pass through each other; NULL: nobody. Errors: STATUS_NO_MEMORY. */
enum status overlaps_look(struct sample *sample, struct passing_watch *passing,
                          struct largest_overlap *largest) MUST_USE;

/* The overlap, over the smallest radius, that a head-on contact of two particles of the largest speed there is would
 * reach in loading: beyond 1 they pass through each other. */
double overlaps_of_fastest(const struct sample *sample);

#endif
