#include "analyzer/loading.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { GRID = 400, SMOOTH_MIN = 9 };

static const double smooth_fraction = 1.0 / 40; /* half window over the strain range */
static const double peak_fraction = 1.0 / 4;    /* widest half window over the strain at the peak */

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

enum status loading_extract(struct loading *loading, const struct curves *curves, int measure)
{
    static const enum curve from[] = {[LOADING_EPS_ZZ_LOG] = CURVE_EPS_ZZ_LOG, [LOADING_EPS_XX_LOG] = CURVE_EPS_XX_LOG,
                                      [LOADING_EPS_V_LOG] = CURVE_EPS_V_LOG,   [LOADING_SIGMA_ZZ] = CURVE_SIGMA_ZZ,
                                      [LOADING_SIGMA_XX] = CURVE_SIGMA_XX,     [LOADING_RATIO] = CURVE_STRESS_RATIO,
                                      [LOADING_SIN_PHI] = CURVE_SIN_PHI,       [LOADING_Q_OVER_P] = CURVE_Q_OVER_P};
    TRY(allocate(loading, curves->n));
    const double *eps = curves->column[curve_axial_strain(measure)];
    double largest = -INFINITY;
    for (size_t i = 0; i < curves->n; i++) {
        if (!(eps[i] > largest + 1e-14)) /* rounding of 1 - L/L0 is no progress */
            continue;
        size_t k = loading->n++;
        largest = loading->eps[k] = eps[i];
        for (int c = 0; c < LOADING_Q; c++)
            loading->y[c][k] = curves->column[from[c]][i];
        loading->y[LOADING_Q][k] = curves->column[CURVE_SIGMA_ZZ][i] - curves->column[CURVE_SIGMA_XX][i];
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

struct vertex_context {
    struct points points;
    const double *y[LOADING_CURVES]; /* from the first point of the window */
    enum loading_curve which;
    double lower, upper; /* where the vertex may be */
};

enum { OUT_EPS = LOADING_CURVES, OUT_COUNT };
_Static_assert((int)OUT_COUNT <= (int)STATISTICS_OUT_MAX, "the peak has more numbers than the jackknife takes");

/* Place of the maximum of the parabola within [lower, upper]; an upward parabola has it at an end. */
static double vertex_place(const double *c, double x0, double lower, double upper)
{
    if (c[2] < 0)
        return fmax(lower, fmin(upper, x0 - c[1] / (2 * c[2])));
    double low = lower - x0, high = upper - x0;
    return c[1] * (high - low) + c[2] * (high * high - low * low) > 0 ? upper : lower;
}

static bool vertex_estimate(const void *context, size_t skip_begin, size_t skip_end, double *out)
{
    const struct vertex_context *v = context;
    double c[FIT_DEGREE_MAX + 1], x0 = (v->lower + v->upper) / 2;
    if (!statistics_polynomial(&v->points, v->y[v->which], skip_begin, skip_end, 2, x0, c))
        return false;
    out[OUT_EPS] = vertex_place(c, x0, v->lower, v->upper);
    for (int k = 0; k < LOADING_CURVES; k++) {
        if (!statistics_polynomial(&v->points, v->y[k], skip_begin, skip_end, 2, out[OUT_EPS], c))
            return false;
        out[k] = c[0];
    }
    return true;
}

static double peak_coarse(const struct loading *loading, const double *y, double half)
{
    double first = loading->eps[0], range = loading->eps[loading->n - 1] - first, best = -INFINITY, place = first;
    for (int k = 0; k <= GRID; k++) {
        double eps = first + range * k / GRID, value = loading_smooth(loading, y, eps, half);
        if (value > best) {
            best = value;
            place = eps;
        }
    }
    return place;
}

static struct vertex_context vertex_window(const struct loading *loading, enum loading_curve which, double a, double b)
{
    size_t first;
    struct vertex_context v = {.which = which, .points = loading_window(loading, a, b, &first)};
    for (int k = 0; k < LOADING_CURVES; k++)
        v.y[k] = loading->y[k] + first;
    v.lower = v.points.n ? v.points.x[0] : a;
    v.upper = v.points.n ? v.points.x[v.points.n - 1] : b;
    return v;
}

/* Standard error of the middle of a local parabola, sqrt(9/(4 n)) times the scatter about it. */
static double vertex_scatter(const struct vertex_context *v)
{
    double c[FIT_DEGREE_MAX + 1], x0 = (v->lower + v->upper) / 2, sum = 0, used = 0;
    if (!statistics_polynomial(&v->points, v->y[v->which], 0, 0, 2, x0, c))
        return 0;
    for (size_t k = 0; k < v->points.n; k++) {
        double x = v->points.x[k] - x0, off = v->y[v->which][k] - (c[0] + x * (c[1] + x * c[2]));
        if (!isfinite(off))
            continue;
        sum += off * off;
        used++;
    }
    return used > 3 ? sqrt(sum / (used - 3)) * sqrt(9 / (4 * used)) : 0;
}

/* What the coarse step found, and what a wider parabola must agree with. */
struct summit {
    double place, value;
    double tolerance;   /* of the value */
    double first, last; /* ends of the data */
};

/* Does the parabola over centre +- half describe the summit? Its vertex lies inside the window (or at an end of the
 * data), not far from the summit, and as high. *v and value[OUT_COUNT] are set only if so. */
static bool parabola_agrees(const struct loading *loading, const struct summit *summit, double centre, double half,
                            struct vertex_context *v, double *value)
{
    double out[OUT_COUNT];
    struct vertex_context trial = vertex_window(loading, v->which, centre - half, centre + half);
    if (trial.points.n < SMOOTH_MIN || !vertex_estimate(&trial, 0, 0, out))
        return false;
    bool low = out[OUT_EPS] <= trial.lower && trial.lower > summit->first;
    bool high = out[OUT_EPS] >= trial.upper && trial.upper < summit->last;
    if (low || high || fabs(out[OUT_EPS] - summit->place) > half / 2 ||
        fabs(out[v->which] - summit->value) > summit->tolerance)
        return false;
    *v = trial;
    memcpy(value, out, sizeof out);
    return true;
}

bool loading_peak_find(const struct loading *loading, enum loading_curve which, struct loading_peak *peak)
{
    struct estimate out[STATISTICS_OUT_MAX];
    double value[OUT_COUNT];
    if (loading->n < SMOOTH_MIN)
        return false;
    double first = loading->eps[0], last = loading->eps[loading->n - 1];
    double narrow = fmax((last - first) * smooth_fraction, (last - first) * SMOOTH_MIN / 2 / (double)loading->n);
    double place = peak_coarse(loading, loading->y[which], narrow);
    struct vertex_context v = vertex_window(loading, which, place - narrow, place + narrow);
    if (!vertex_estimate(&v, 0, 0, value))
        return false;
    /* the largest of some 40 independent windows lies about 2 standard errors above the truth: allow 4 */
    struct summit summit = {value[OUT_EPS], value[which], 4 * vertex_scatter(&v) + 1e-9 * fabs(value[which]), first,
                            last};
    double half = peak_fraction * place;
    while (half > narrow && !parabola_agrees(loading, &summit, place, half, &v, value))
        half *= 0.7;
    if (half > narrow) /* recentre; if that does not agree, the window stands as it was found */
        (void)parabola_agrees(loading, &summit, value[OUT_EPS], half, &v, value);
    if (!statistics_jackknife(&v.points, vertex_estimate, &v, OUT_COUNT, out))
        return false;
    *peak = (struct loading_peak){.window = {v.lower, v.upper}, .eps = out[OUT_EPS], .value = out[which]};
    memcpy(peak->along, out, sizeof peak->along);
    peak->at_end = peak->eps.value >= last ? 1 : peak->eps.value <= first ? -1 : 0;
    return true;
}
