/* Values, slopes and maxima of a noisy curve by local polynomials, without a window that somebody has to choose.
 *
 * Every estimate is an average over windows and degrees. The weight of a candidate is exp(-C/2), C = chi^2 + 2 (number
 * of coefficients) + 2 (samples that its window leaves out): Akaike's criterion with the choice of data in it (Jay &
 * Neil 2021, Phys. Rev. D 103, 114502). A candidate's value comes from a polynomial of higher degree over its window
 * than the one that is weighed, so that what bends within the window is not a bias (Calonico, Cattaneo & Titiunik 2014,
 * Econometrica 82, 2295). The variance is the mean of the candidates' own plus their scatter: the choice of the window
 * is in it.
 *
 * Errors of successive samples are taken as an autoregression of first order. Its two numbers come from the residuals
 * of a moving cubic over 51 samples, whose response to such a series is known in closed form. */
#ifndef SHAKEDOWN_ANALYZER_LOCAL_FIT_H
#define SHAKEDOWN_ANALYZER_LOCAL_FIT_H

#include <stdbool.h>
#include <stddef.h>

#include "analyzer/statistics.h"

enum { LOCAL_CURVES_MAX = 16, LOCAL_POINTS_MIN = 12 };

/* Curves over one abscissa. Samples at which the leading curve, y[0], is not finite are left out; the other curves must
 * be finite at the rest of the samples, or their results are NaN. */
struct local_curves {
    const double *x; /* [n], strictly increasing */
    size_t n;
    int count;                         /* 1 ... LOCAL_CURVES_MAX */
    const double *y[LOCAL_CURVES_MAX]; /* [count][n] */
};

struct local_noise {
    double deviation;   /* of one sample */
    double correlation; /* of successive ones, 0 ... 0.95 */
};

/* Noise of y[n]; false below LOCAL_POINTS_MIN samples. */
bool local_noise_estimate(const double *y, size_t n, struct local_noise *noise);

/* Value and slope of the leading curve at x0, from windows of at most x0 +- half, cut at the ends of the data. Tried:
 * degrees 1 to 3 (values from 2 to 4), windows narrowed by 0.75. The difference between the averages of both degrees is
 * in the error too. False if the widest window has too few samples. */
bool local_at(const struct local_curves *curves, double x0, double half, struct estimate *value,
              struct estimate *slope);

struct local_peak {
    struct estimate place;
    struct estimate value[LOCAL_CURVES_MAX]; /* of every curve at the place of the leading one's maximum */
    double window[2];                        /* of the heaviest candidate */
    int at_end; /* 0: a maximum; 1: the leading curve still rises at its last sample; -1: it falls from the first */
};

/* The maximum of the leading curve. Its rough place is the largest value of a moving parabola of half width `narrow`;
 * the candidates are windows of at most half of that place's distance from x = 0 to either side, degrees 2 and 3
 * (values from 4 and 5). False with too few samples. */
bool local_peak_find(const struct local_curves *curves, double narrow, struct local_peak *peak);

#endif
