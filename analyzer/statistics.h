/* Estimates with errors that allow for correlated samples. Pure functions of arrays.
 *
 * Samples of a run are correlated in time and not evenly spaced in strain (the walls start and stop softly). So every
 * estimate weights a sample by the strain it stands for, and every error comes from blocks of equal strain: it is right
 * as soon as a block is longer than the correlation. */
#ifndef SHAKEDOWN_ANALYZER_STATISTICS_H
#define SHAKEDOWN_ANALYZER_STATISTICS_H

#include <stdbool.h>
#include <stddef.h>

enum { STATISTICS_BLOCKS = 10, STATISTICS_OUT_MAX = 10, FIT_DEGREE_MAX = 2 };

struct estimate {
    double value;
    double error; /* standard uncertainty (one sigma); NaN if it cannot be told */
};

/* One or several curves over the same abscissa. Points whose y is not finite are left out of fits. */
struct points {
    const double *x; /* [n], strictly increasing */
    const double *w; /* [n], weights > 0 */
    size_t n;
};

/* Weights of the trapezoidal rule: w[n] from strictly increasing x[n]; w = 1 for n = 1. */
void statistics_weights(const double *x, double *w, size_t n);

/* First index of x[n] (increasing) with x >= bound; n if none. */
size_t statistics_lower_bound(const double *x, size_t n, double bound);

/* Weighted least squares of y[n] by c[0] + c[1] (x - x0) + c[2] (x - x0)^2 up to `degree` (0 to 2; the other
 * coefficients are set to 0), without the points [skip_begin, skip_end). False if there are too few distinct points. */
bool statistics_polynomial(const struct points *points, const double *y, size_t skip_begin, size_t skip_end, int degree,
                           double x0, double c[FIT_DEGREE_MAX + 1]);

/* Computes out[n_out] from all points but [skip_begin, skip_end); false if it cannot. */
typedef bool statistics_estimator(const void *context, size_t skip_begin, size_t skip_end, double *out);

/* The estimate from all points, and its delete-a-block jackknife error,
 *   u^2 = (B-1)/B sum_b (theta_b - mean theta)^2,
 * times statistics_widening(B - 1), with STATISTICS_BLOCKS blocks of equal length in x (fewer below 20 points; error
 * NaN below 4). n_out <= STATISTICS_OUT_MAX. False if the estimator fails on all points. */
bool statistics_jackknife(const struct points *points, statistics_estimator *estimator, const void *context, int n_out,
                          struct estimate *out);

/* Slope of y[n] against x by statistics_polynomial and statistics_jackknife. False with fewer than 3 points. */
bool statistics_slope(const struct points *points, const double *y, struct estimate *slope);

/* Mean of y[n] over x (weighted) with its error from the scatter of block means, u = sd(block means)/sqrt(B), widened:
 * blocks as above. False with no points. */
bool statistics_mean(const struct points *points, const double *y, struct estimate *mean);

/* Mean and standard error of v[n] taken as independent, and the standard deviation (n - 1); NaN where n is too small.
 */
struct estimate statistics_plain_mean(const double *v, size_t n, double *standard_deviation);

/* P(T <= t) of Student's distribution with `dof` > 0 degrees of freedom. */
double statistics_student_cdf(double t, double dof);

/* Factor by which a standard deviation that is known from `dof` degrees of freedom is multiplied, so that twice the
 * product holds the truth as often as two sigma of the normal distribution do, 95.45 %: t(0.97725, dof)/2. */
double statistics_widening(double dof);

#endif
