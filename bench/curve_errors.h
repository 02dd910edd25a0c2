/* How far the curves of a run of one stage lie from those of a reference run: same packing, same samples. */
#ifndef SHAKEDOWN_BENCH_CURVE_ERRORS_H
#define SHAKEDOWN_BENCH_CURVE_ERRORS_H

#include <stdbool.h>
#include <stdint.h>

#include "common/status.h"

struct curve_errors {
    double stress;   /* |sigma - sigma_ref|_2 / |sigma_ref|_2 of the axial stress over all samples */
    double early;    /* the same up to 1.5 % of axial strain; NaN if there is no sample */
    double peak;     /* relative difference of the largest axial stress */
    double position; /* largest difference of a box length over that length */
    double strain;   /* largest difference of a strain (lateral under strain control, eps_D in cycles) over its range */
    double gain;     /* difference of that strain at the end over what it is there */
    double residual,
        controller_residual; /* interface residuals over the work of the walls at the end, 0 without work */
    double elapsed_s;
    int64_t steps, exchanges; /* exchanges: wall states that the run counts at its end, 0 if it has no END */
    bool complete;            /* the run ended well and has the samples of the reference */
};

/* Both are run.h5. Over the samples that both have: a run that stopped has fewer. STATUS_INCOMPLETE if they were not
 * taken at the same times; errors of run_read. */
enum status curve_errors_measure(const char *reference, const char *path, struct curve_errors *errors) MUST_USE;

/* A whole number among the root's attributes of run.h5, as END brings them; 0 if there is none. */
int64_t run_attribute_i64(const char *path, const char *name);

#endif
