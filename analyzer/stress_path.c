#include "analyzer/stress_path.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>

#include "analyzer/local_fit.h"

/* A path is straight if no sample is farther from it than this part of its length; it yields if its stiffness falls by
 * this factor at the bend. The last part of the way is left out: at a peak, stress says nothing about strain. */
static const double STRAIGHT = 0.02, YIELD_RATIO = 1.5, WAY = 0.9;
static const double DEGREES = 180 / M_PI;

/* The path and the strain along it, s and e: ds = n . (dp, dq), de = n . (deps_V, (D-1)/D deps_D), so that along a
 * straight path s de is the work beyond that of the stress at its start. */
struct path {
    double p0_pa, q0_pa, n_p, n_q, length_pa;
    bool stress_led; /* then the strain is the one that scatters: e over s, else s over e */
    size_t n;
    double *x, *y, *weight, *eps; /* [n]; x, the one that leads, strictly increasing */
};

static void direction_find(struct path *path, const struct loading *loading)
{
    const double *p = loading->y[LOADING_P], *q = loading->y[LOADING_Q];
    double farthest = 0;
    path->p0_pa = p[0];
    path->q0_pa = loading->sign * q[0];
    for (size_t k = 1; k < loading->n; k++) {
        const double dp = p[k] - p[0], dq = loading->sign * (q[k] - q[0]);
        if (!(hypot(dp, dq) > farthest))
            continue;
        farthest = hypot(dp, dq);
        path->n_p = dp / farthest;
        path->n_q = dq / farthest;
    }
    path->length_pa = farthest;
}

/* Largest distance of a sample from the line. */
static double off_line(const struct path *path, const struct loading *loading)
{
    double off = 0;
    for (size_t k = 0; k < loading->n; k++) {
        const double dp = loading->y[LOADING_P][k] - path->p0_pa,
                     dq = loading->sign * loading->y[LOADING_Q][k] - path->q0_pa;
        off = fmax(off, fabs(path->n_p * dq - path->n_q * dp));
    }
    return off;
}

static double along(const struct path *path, const struct loading *loading, size_t k)
{
    return path->n_p * (loading->y[LOADING_P][k] - path->p0_pa) +
           path->n_q * (loading->sign * loading->y[LOADING_Q][k] - path->q0_pa);
}

static double strain_along(const struct path *path, const struct loading *loading, size_t k, int dimension)
{
    const double *volume = loading->y[LOADING_EPS_V_LOG], *shear = loading->y[LOADING_EPS_D_LOG];
    return path->n_p * (volume[k] - volume[0]) + path->n_q * (dimension - 1) / dimension * (shear[k] - shear[0]);
}

/* Samples of the stage, up to WAY of the whole length, that reach a new largest value of what leads. */
static enum status way_extract(struct path *path, const struct curves *curves, const struct loading *loading)
{
    const double *p = curves->column[CURVE_P], *q = curves->column[CURVE_Q], *volume = curves->column[CURVE_EPS_V_LOG],
                 *shear = curves->column[CURVE_EPS_D_LOG];
    const double part = (curves->dimension - 1.0) / curves->dimension;
    double **const arrays[] = {&path->x, &path->y, &path->weight, &path->eps};
    for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++)
        if (!(*arrays[k] = malloc((curves->n + 1) * sizeof(double))))
            return status_fail(STATUS_NO_MEMORY, "out of memory for %zu samples", curves->n);
    path->stress_led = curves->controls.stress_led;
    for (size_t k = 0; k <= loading->last; k++) {
        const double s_pa = path->n_p * (p[k] - path->p0_pa) + path->n_q * (q[k] - path->q0_pa);
        const double e = path->n_p * (volume[k] - volume[0]) + path->n_q * part * (shear[k] - shear[0]);
        const double x = path->stress_led ? s_pa : e;
        if (s_pa > WAY * path->length_pa)
            break;
        if (path->n > 0 && !(x > path->x[path->n - 1]))
            continue;
        path->x[path->n] = x;
        path->y[path->n] = path->stress_led ? e : s_pa;
        path->eps[path->n++] = curves->column[CURVE_EPS_ZZ][k];
    }
    statistics_weights(path->x, path->weight, path->n);
    return STATUS_OK;
}

static void path_free(struct path *path)
{
    free(path->x);
    free(path->y);
    free(path->weight);
    free(path->eps);
}

/* Weighted least squares of y over {1, x, max(0, x - b)}, by normal equations. Returns the sum of squares that is left;
 * INFINITY if the three are not independent. GSL's error handler is off. */
static double bilinear_at(const struct points *points, const double *y, size_t skip_begin, size_t skip_end, double b,
                          double c[3])
{
    enum { M = 3 };
    double a[M * M] = {0}, right[M] = {0}, sum = 0;
    const double x0 = points->x[0];
    for (size_t k = 0; k < points->n; k++) {
        if (k >= skip_begin && k < skip_end)
            continue;
        const double basis[M] = {1, points->x[k] - x0, fmax(0, points->x[k] - b)};
        for (int i = 0; i < M; i++) {
            for (int j = 0; j < M; j++)
                a[M * i + j] += points->w[k] * basis[i] * basis[j];
            right[i] += points->w[k] * basis[i] * y[k];
        }
    }
    gsl_matrix_view matrix = gsl_matrix_view_array(a, M, M);
    gsl_vector_const_view of = gsl_vector_const_view_array(right, M);
    gsl_vector_view solution = gsl_vector_view_array(c, M);
    if (gsl_linalg_cholesky_decomp1(&matrix.matrix) != 0 ||
        gsl_linalg_cholesky_solve(&matrix.matrix, &of.vector, &solution.vector) != 0)
        return INFINITY;
    for (size_t k = 0; k < points->n; k++) {
        const double x = points->x[k], off = y[k] - c[0] - c[1] * (x - x0) - c[2] * fmax(0, x - b);
        sum += k < skip_begin || k >= skip_end ? points->w[k] * off * off : 0;
    }
    return sum;
}

bool stress_path_bilinear(const struct points *points, const double *y, size_t skip_begin, size_t skip_end,
                          struct bilinear *fit)
{
    enum { GRID = 36, STEPS = 24, POINTS_MIN = 6 };
    static const double golden = 0.6180339887498949;
    double c[3], best = INFINITY, place = NAN;
    if (points->n - (skip_end - skip_begin) < POINTS_MIN)
        return false;
    (void)gsl_set_error_handler_off(); /* failures are returned */
    const double first = points->x[0], span = points->x[points->n - 1] - first, step = 0.9 * span / GRID;
    for (int k = 0; k <= GRID; k++) {
        const double b = first + 0.05 * span + k * step;
        const double sum = bilinear_at(points, y, skip_begin, skip_end, b, c);
        if (sum < best) {
            best = sum;
            place = b;
        }
    }
    if (!isfinite(place))
        return false;
    double low = fmax(place - step, first + 0.05 * span), high = fmin(place + step, first + 0.95 * span);
    for (int k = 0; k < STEPS; k++) { /* golden section */
        const double left = high - golden * (high - low), right = low + golden * (high - low);
        if (bilinear_at(points, y, skip_begin, skip_end, left, c) <
            bilinear_at(points, y, skip_begin, skip_end, right, c))
            high = right;
        else
            low = left;
    }
    place = (low + high) / 2;
    if (!isfinite(bilinear_at(points, y, skip_begin, skip_end, place, c)))
        return false;
    *fit = (struct bilinear){place, c[0] + c[1] * (place - first), c[1], c[1] + c[2]};
    return true;
}

struct yield_fit {
    const struct points *points;
    const struct path *path;
};

static bool yield_estimator(const void *context, size_t skip_begin, size_t skip_end, double *out)
{
    const struct yield_fit *fit = context;
    struct bilinear bilinear;
    const bool stress_led = fit->path->stress_led;
    if (!stress_path_bilinear(fit->points, fit->path->y, skip_begin, skip_end, &bilinear))
        return false;
    out[0] = stress_led ? bilinear.place : bilinear.value;
    out[1] = stress_led ? bilinear.after / bilinear.before : bilinear.before / bilinear.after;
    out[2] = bilinear.place;
    return true;
}

static void yield_undefined(struct quantity *q, const char *reason)
{
    for (int id = QUANTITY_YIELD_P; id <= QUANTITY_YIELD_STIFFNESS_RATIO; id++)
        quantity_undefined(&q[id], "%s", reason);
}

/* Two lines through stress and strain along the path (Graham, Noonan & Lew 1983): where they meet. */
static void yield_point(const struct path *path, struct quantity *q)
{
    const struct points points = {path->x, path->weight, path->n};
    const struct yield_fit fit = {&points, path};
    struct estimate out[3]; /* s, stiffness before over after, place in x */
    if (path->n < 2 * STATISTICS_BLOCKS || !statistics_jackknife(&points, yield_estimator, &fit, 3, out)) {
        yield_undefined(q, "too few samples on the way");
        return;
    }
    const double first = path->x[0], last = path->x[path->n - 1], part = (out[2].value - first) / (last - first);
    if (!(out[1].value > YIELD_RATIO) || part < 0.06 || part > 0.94) {
        yield_undefined(q, "nowhere along the path does the stiffness fall to less than 1/1.5");
        return;
    }
    const size_t k = statistics_lower_bound(path->x, path->n - 1, out[2].value);
    quantity_set(&q[QUANTITY_YIELD_P],
                 (struct estimate){path->p0_pa + path->n_p * out[0].value, fabs(path->n_p) * out[0].error});
    quantity_set(&q[QUANTITY_YIELD_Q],
                 (struct estimate){path->q0_pa + path->n_q * out[0].value, fabs(path->n_q) * out[0].error});
    quantity_set(&q[QUANTITY_YIELD_EPS], (struct estimate){path->eps[k], NAN});
    quantity_set(&q[QUANTITY_YIELD_STIFFNESS_RATIO], out[1]);
    for (int id = QUANTITY_YIELD_P; id <= QUANTITY_YIELD_STIFFNESS_RATIO; id++)
        quantity_window(&q[id], fabs(path->eps[0]), fabs(path->eps[path->n - 1]));
}

/* Ratio of two initial slopes over the axial strain. */
static bool slopes_ratio(const struct loading *loading, const double *up, const double *down, double window,
                         struct estimate *ratio)
{
    const double *x = loading->y[LOADING_EPS_ZZ_LOG], half = loading_to_log(loading, window) - x[0];
    const struct local_curves over = {.x = x, .n = loading->n, .count = 1, .y = {up}},
                              under = {.x = x, .n = loading->n, .count = 1, .y = {down}};
    struct estimate value, a, b;
    if (!local_at(&over, x[0], half, &value, &a) || !local_at(&under, x[0], half, &value, &b) || b.value == 0)
        return false;
    ratio->value = a.value / b.value;
    ratio->error = fabs(ratio->value) * hypot(a.error / a.value, b.error / b.value);
    return true;
}

/* ds/de, and dp/deps_V where p changes along the path. */
static enum status stiffness_along(const struct path *path, const struct loading *loading, int dimension, double window,
                                   struct quantity *q)
{
    double *s_pa = malloc(2 * loading->n * sizeof *s_pa), *strain = s_pa + loading->n;
    struct estimate ratio;
    if (!s_pa)
        return status_fail(STATUS_NO_MEMORY, "out of memory for %zu samples", loading->n);
    for (size_t k = 0; k < loading->n; k++) {
        s_pa[k] = along(path, loading, k);
        strain[k] = strain_along(path, loading, k, dimension);
    }
    const struct {
        enum quantity_id id;
        const double *up, *down;
        bool there;
    } slopes[] = {{QUANTITY_PATH_STIFFNESS, s_pa, strain, true},
                  {QUANTITY_PATH_K, loading->y[LOADING_P], loading->y[LOADING_EPS_V_LOG], fabs(path->n_p) > 0.1}};
    for (size_t k = 0; k < sizeof slopes / sizeof slopes[0]; k++) {
        if (!slopes[k].there) {
            quantity_undefined(&q[slopes[k].id], "p does not change along the path");
        } else if (!slopes_ratio(loading, slopes[k].up, slopes[k].down, window, &ratio)) {
            quantity_undefined(&q[slopes[k].id], "too few samples with axial strain up to %g", window);
        } else {
            quantity_set(&q[slopes[k].id], ratio);
            quantity_window(&q[slopes[k].id], 0, window);
        }
    }
    free(s_pa);
    return STATUS_OK;
}

static void all_undefined(struct quantity *q, const char *reason)
{
    for (int id = QUANTITY_PATH_DIRECTION; id <= QUANTITY_YIELD_STIFFNESS_RATIO; id++)
        quantity_undefined(&q[id], "%s", reason);
}

enum status stress_path_evaluate(const struct curves *curves, const struct loading *loading, double window,
                                 struct quantity *q)
{
    struct path path = {0};
    if (loading->n < LOCAL_POINTS_MIN) {
        all_undefined(q, "too few samples with a new largest axial strain");
        return STATUS_OK;
    }
    direction_find(&path, loading);
    if (!(path.length_pa > 0) || off_line(&path, loading) > STRAIGHT * path.length_pa) {
        all_undefined(q, "the path in (p, q) is not straight");
        return STATUS_OK;
    }
    quantity_set(&q[QUANTITY_PATH_DIRECTION], (struct estimate){atan2(path.n_q, path.n_p) * DEGREES, NAN});
    enum status status = stiffness_along(&path, loading, curves->dimension, window, q);
    if (status == STATUS_OK)
        status = way_extract(&path, curves, loading);
    if (status == STATUS_OK)
        yield_point(&path, q);
    path_free(&path);
    return status;
}
