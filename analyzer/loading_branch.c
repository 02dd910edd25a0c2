#include "analyzer/loading_branch.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analyzer/local_fit.h"

static enum status allocate(struct loading *loading, size_t n)
{
    double **const arrays[] = {&loading->eps, &loading->w};
    bool good = true;
    memset(loading, 0, sizeof *loading);
    for (int k = 0; k < 2; k++)
        good = (*arrays[k] = malloc((n + 1) * sizeof(double))) && good;
    for (int k = 0; k < LOADING_CURVES; k++)
        good = (loading->y[k] = malloc((n + 1) * sizeof(double))) && good;
    if (good)
        return STATUS_OK;
    loading_free(loading);
    return status_fail(STATUS_NO_MEMORY, "out of memory for %zu samples", n);
}

static void sample_take(struct loading *loading, const struct curves *curves, size_t i, size_t k)
{
    static const enum curve from[] = {[LOADING_EPS_ZZ_LOG] = CURVE_EPS_ZZ_LOG,
                                      [LOADING_EPS_XX_LOG] = CURVE_EPS_XX_LOG,
                                      [LOADING_EPS_V_LOG] = CURVE_EPS_V_LOG,
                                      [LOADING_EPS_D_LOG] = CURVE_EPS_D_LOG,
                                      [LOADING_SIGMA_ZZ] = CURVE_SIGMA_ZZ,
                                      [LOADING_SIGMA_XX] = CURVE_SIGMA_XX,
                                      [LOADING_RATIO] = CURVE_STRESS_RATIO,
                                      [LOADING_SIN_PHI] = CURVE_SIN_PHI,
                                      [LOADING_Q_OVER_P] = CURVE_Q_OVER_P,
                                      [LOADING_P] = CURVE_P,
                                      [LOADING_Q] = CURVE_Q};
    for (int c = 0; c < LOADING_CURVES; c++)
        loading->y[c][k] = curves->column[from[c]][i];
    if (loading->sign > 0)
        return;
    loading->y[LOADING_EPS_ZZ_LOG][k] *= -1;
    loading->y[LOADING_Q][k] *= -1;
    loading->y[LOADING_RATIO][k] = 1 / loading->y[LOADING_RATIO][k];
}

enum status loading_extract(struct loading *loading, const struct curves *curves, int measure)
{
    TRY(allocate(loading, curves->n));
    loading->measure = measure;
    loading->sign = curves->controls.extension ? -1 : 1;
    const double *eps = curves->column[curve_axial_strain(measure)];
    double largest = -INFINITY;
    for (size_t i = 0; i < curves->n; i++) {
        const double strain = loading->sign * eps[i];
        if (!(strain > largest + 1e-14)) /* rounding of 1 - L/L0 is no progress */
            continue;
        largest = loading->eps[loading->n] = strain;
        loading->last = i;
        sample_take(loading, curves, i, loading->n++);
    }
    statistics_weights(loading->eps, loading->w, loading->n);
    return STATUS_OK;
}

void loading_free(struct loading *loading)
{
    free(loading->eps);
    free(loading->w);
    for (int k = 0; k < LOADING_CURVES; k++)
        free(loading->y[k]);
    memset(loading, 0, sizeof *loading);
}

struct points loading_window(const struct loading *loading, double a, double b, size_t *first)
{
    double slack = 1e-12; /* rounding of strains at the bounds */
    *first = statistics_lower_bound(loading->eps, loading->n, a - slack);
    size_t end = statistics_lower_bound(loading->eps, loading->n, b + slack);
    return (struct points){loading->eps + *first, loading->w + *first, end > *first ? end - *first : 0};
}

double loading_smooth(const struct loading *loading, const double *y, double eps, double half)
{
    size_t first;
    double c[FIT_DEGREE_MAX + 1];
    struct points points = loading_window(loading, eps - half, eps + half, &first);
    return statistics_polynomial(&points, y + first, 0, 0, 2, eps, c) ? c[0] : NAN;
}

double loading_smooth_slope(const struct loading *loading, enum loading_curve which, double eps, double half)
{
    size_t first;
    double c[FIT_DEGREE_MAX + 1];
    struct points points = loading_window(loading, eps - half, eps + half, &first);
    points.x = loading->y[LOADING_EPS_ZZ_LOG] + first;
    return statistics_polynomial(&points, loading->y[which] + first, 0, 0, 2, loading_to_log(loading, eps), c) ? c[1]
                                                                                                               : NAN;
}

double loading_to_log(const struct loading *loading, double eps)
{
    return loading->measure == STRAIN_LOGARITHMIC ? eps : -loading->sign * log1p(-loading->sign * eps);
}

double loading_from_log(const struct loading *loading, double eps_log)
{
    return loading->measure == STRAIN_LOGARITHMIC ? eps_log : -loading->sign * expm1(-loading->sign * eps_log);
}

bool loading_at(const struct loading *loading, enum loading_curve which, double eps_log, double half,
                struct estimate *value, struct estimate *slope)
{
    struct local_curves curves = {loading->y[LOADING_EPS_ZZ_LOG], loading->n, 1, {loading->y[which]}};
    return local_at(&curves, eps_log, half, value, slope);
}
