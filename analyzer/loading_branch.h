/* The loading branch of a strain-controlled stage, and local fits on it. */
#ifndef SHAKEDOWN_ANALYZER_LOADING_BRANCH_H
#define SHAKEDOWN_ANALYZER_LOADING_BRANCH_H

#include <stddef.h>

#include "analyzer/curves.h"
#include "analyzer/statistics.h"
#include "common/status.h"

/* The curves that are evaluated against axial strain. */
enum loading_curve {
    LOADING_EPS_ZZ_LOG, /* positive, also in extension */
    LOADING_EPS_XX_LOG,
    LOADING_EPS_V_LOG,
    LOADING_EPS_D_LOG,
    LOADING_SIGMA_ZZ,
    LOADING_SIGMA_XX,
    LOADING_RATIO, /* of the larger to the smaller stress as the test has them: sigma_xx/sigma_zz in extension */
    LOADING_SIN_PHI,
    LOADING_Q_OVER_P,
    LOADING_P,
    LOADING_Q, /* positive, also in extension */
    LOADING_CURVES
};

struct loading {
    int measure; /* enum strain_measure */
    double sign; /* -1 in extension: the axial strain and q are those of the record times it */
    size_t n;
    size_t last;               /* sample of the curves that is the last here */
    double *eps;               /* [n], axial strain in the measure asked for times sign, strictly increasing */
    double *w;                 /* [n], the strain a sample stands for */
    double *y[LOADING_CURVES]; /* [n] each; NaN where undefined */
};

/* Takes those samples that reach a new largest axial strain (`measure`: enum strain_measure): the wall rests after its
 * motion, and samples at rest carry no information about slopes. Release with loading_free. STATUS_NO_MEMORY. */
enum status loading_extract(struct loading *loading, const struct curves *curves, int measure) MUST_USE;

void loading_free(struct loading *loading);

/* The samples with eps in [a, b] (up to rounding), as points over eps; *first is the index of the first of them. */
struct points loading_window(const struct loading *loading, double a, double b, size_t *first);

/* Value of curve y[n] at `eps` by a local quadratic over [eps - half, eps + half], cut at the ends of the data
 * (Savitzky-Golay for uneven samples). NaN if there are too few points. */
double loading_smooth(const struct loading *loading, const double *y, double eps, double half);

/* The same against logarithmic axial strain: slope. */
double loading_smooth_slope(const struct loading *loading, enum loading_curve which, double eps, double half);

/* Axial strain in the measure of `eps` as a logarithmic one, and back. */
double loading_to_log(const struct loading *loading, double eps);
double loading_from_log(const struct loading *loading, double eps_log);

/* Value of a curve and its slope against logarithmic axial strain at `eps_log`, from windows of at most +- half
 * (local_at). False if there are too few samples. */
bool loading_at(const struct loading *loading, enum loading_curve which, double eps_log, double half,
                struct estimate *value, struct estimate *slope);

#endif
