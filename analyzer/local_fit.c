#include "analyzer/local_fit.h"

#include <gsl/gsl_blas.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_poly.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DEGREE_MAX = 5, CANDIDATES_MAX = 96 };

static const double narrowing = 0.75;
static const double narrowest = 0.01; /* of the widest window */

/* The curves without holes, with the noise of each. */
struct clean {
    double *x; /* [n] */
    size_t n;
    int count;
    double *y[LOCAL_CURVES_MAX];
    struct local_noise noise[LOCAL_CURVES_MAX];
};

static void clean_free(struct clean *clean)
{
    free(clean->x);
}

static bool clean_make(struct clean *clean, const struct local_curves *curves)
{
    const size_t n = curves->n, parts = (size_t)curves->count + 1;
    memset(clean, 0, sizeof *clean);
    (void)gsl_set_error_handler_off(); /* failures are returned */
    clean->x = malloc((n + 1) * parts * sizeof *clean->x);
    if (!clean->x)
        return false;
    clean->count = curves->count;
    for (int c = 0; c < clean->count; c++)
        clean->y[c] = clean->x + (size_t)(c + 1) * n;
    for (size_t k = 0; k < n; k++) {
        if (!isfinite(curves->y[0][k]))
            continue;
        clean->x[clean->n] = curves->x[k];
        for (int c = 0; c < clean->count; c++)
            clean->y[c][clean->n] = curves->y[c][k];
        clean->n++;
    }
    return true;
}

/* The noise in samples [begin, end), with others around if these are few: a curve that is smooth at first and rough
 * later has two noises. */
static bool clean_noise(struct clean *clean, size_t begin, size_t end)
{
    enum { FEW = 100 };
    if (end - begin < FEW) {
        begin = begin + end > FEW ? (begin + end - FEW) / 2 : 0;
        end = begin + FEW < clean->n ? begin + FEW : clean->n;
        begin = end > FEW ? end - FEW : 0;
    }
    for (int c = 0; c < clean->count; c++)
        if (!local_noise_estimate(clean->y[c] + begin, end - begin, &clean->noise[c]))
            clean->noise[c] = (struct local_noise){NAN, 0};
    return isfinite(clean->noise[0].deviation);
}

/* Samples [begin, end) as a least squares problem in u = (x - origin)/scale, |u| <= 1, made white for a correlation. */
struct window {
    const struct clean *clean;
    size_t begin, end;
    double origin, scale, correlation;
    gsl_matrix *factor; /* QR */
    gsl_vector *tau, *right, *rest;
    int degree;
};

static void window_close(struct window *window)
{
    gsl_matrix_free(window->factor);
    gsl_vector_free(window->tau);
    gsl_vector_free(window->right);
    gsl_vector_free(window->rest);
}

static double whitened(double now, double before, double correlation)
{
    return (now - correlation * before) / sqrt(1 - correlation * correlation);
}

static double abscissa(const struct window *window, size_t row)
{
    return (window->clean->x[window->begin + row] - window->origin) / window->scale;
}

static bool window_open(struct window *window, int degree)
{
    const size_t rows = window->end - window->begin, columns = (size_t)degree + 1;
    window->degree = degree;
    window->factor = gsl_matrix_alloc(rows, columns);
    window->tau = gsl_vector_alloc(columns);
    window->right = gsl_vector_alloc(rows);
    window->rest = gsl_vector_alloc(rows);
    if (!window->factor || !window->tau || !window->right || !window->rest) {
        window_close(window);
        return false;
    }
    for (size_t r = 0; r < rows; r++) {
        double now = 1, before = 1;
        for (size_t c = 0; c < columns; c++) {
            gsl_matrix_set(window->factor, r, c, r ? whitened(now, before, window->correlation) : now);
            now *= abscissa(window, r);
            before *= r ? abscissa(window, r - 1) : 0;
        }
    }
    if (gsl_linalg_QR_decomp(window->factor, window->tau) == 0)
        return true;
    window_close(window);
    return false;
}

/* Coefficients [degree + 1] of a curve, and the sum of the squared residuals. */
static bool window_fit(struct window *window, int curve, double *coefficients, double *sum)
{
    const double *y = window->clean->y[curve] + window->begin;
    gsl_vector_view out = gsl_vector_view_array(coefficients, (size_t)window->degree + 1);
    for (size_t r = 0; r < window->rest->size; r++)
        gsl_vector_set(window->right, r, r ? whitened(y[r], y[r - 1], window->correlation) : y[r]);
    if (gsl_linalg_QR_lssolve(window->factor, window->tau, window->right, &out.vector, window->rest) != 0)
        return false;
    const double norm = gsl_blas_dnrm2(window->rest);
    *sum = norm * norm;
    return true;
}

/* Standard error of the sum of gradient[degree + 1] times the coefficients, for unit noise: |R^-T g|. */
static double window_error(const struct window *window, const double *gradient)
{
    const size_t m = (size_t)window->degree + 1;
    double copy[DEGREE_MAX + 1];
    memcpy(copy, gradient, m * sizeof *copy);
    gsl_vector_view g = gsl_vector_view_array(copy, m);
    gsl_matrix_const_view top = gsl_matrix_const_submatrix(window->factor, 0, 0, m, m);
    if (gsl_blas_dtrsv(CblasUpper, CblasTrans, CblasNonUnit, &top.matrix, &g.vector) != 0)
        return NAN;
    return gsl_blas_dnrm2(&g.vector);
}

/* Student's t for the samples that count: a correlation c leaves (1 - c)/(1 + c) of them. */
static double widening(const struct window *window)
{
    const double c = window->correlation, rows = (double)(window->end - window->begin);
    return statistics_widening(fmax(2, rows * (1 - c) / (1 + c) - window->degree - 1));
}

/* What one window and degree say: the numbers, and how well they are founded. */
struct candidate {
    double criterion;
    double window[2];
    struct estimate out[LOCAL_CURVES_MAX + 2];
    double plain[2]; /* value and slope of the lower degree */
};

struct search {
    struct clean clean;
    double centre, half; /* the widest window */
    size_t begin, end;   /* of it */
    int n;
    struct candidate candidate[CANDIDATES_MAX];
};

static void range(const struct clean *clean, double centre, double half, size_t *begin, size_t *end)
{
    const double slack = 1e-12 * (fabs(centre) + half); /* rounding of strains at the bounds */
    *begin = statistics_lower_bound(clean->x, clean->n, centre - half - slack);
    *end = statistics_lower_bound(clean->x, clean->n, centre + half + slack);
}

/* The criterion of a window and degree, and that fit's first two coefficients. */
static bool weigh(const struct search *search, struct window *window, int degree, struct candidate *candidate)
{
    const struct local_noise *noise = &search->clean.noise[0];
    double c[DEGREE_MAX + 1] = {0}, sum;
    if (!window_open(window, degree))
        return false;
    const bool good = window_fit(window, 0, c, &sum);
    window_close(window);
    const double left_out = (double)(search->end - search->begin) - (double)(window->end - window->begin);
    candidate->criterion = sum / (noise->deviation * noise->deviation) + 2 * (degree + 1) + 2 * left_out;
    candidate->plain[0] = c[0];
    candidate->plain[1] = c[1] / window->scale;
    return good;
}

typedef bool evaluate_window(struct window *window, struct candidate *candidate);

/* Tries all windows for the degrees from `low` to `high`, values from polynomials of `lift` degrees more. */
static void search_run(struct search *search, int low, int high, int lift, evaluate_window *evaluate)
{
    for (int degree = low; degree <= high; degree++)
        for (double share = 1; share > narrowest && search->n < CANDIDATES_MAX; share *= narrowing) {
            struct window window = {.clean = &search->clean, .origin = search->centre};
            struct candidate *candidate = &search->candidate[search->n];
            range(&search->clean, search->centre, search->half * share, &window.begin, &window.end);
            if (window.end < window.begin + 6 + 2 * (size_t)(degree + lift))
                break;
            const double *x = search->clean.x;
            window.correlation = search->clean.noise[0].correlation;
            window.scale = fmax(x[window.end - 1] - search->centre, search->centre - x[window.begin]);
            candidate->window[0] = x[window.begin];
            candidate->window[1] = x[window.end - 1];
            if (!weigh(search, &window, degree, candidate) || !window_open(&window, degree + lift))
                continue;
            search->n += evaluate(&window, candidate);
            window_close(&window);
        }
}

/* Normalised weights [n] of the candidates, and the heaviest. */
static int weights(const struct search *search, double *weight)
{
    double sum = 0;
    int best = 0;
    for (int k = 1; k < search->n; k++)
        if (search->candidate[k].criterion < search->candidate[best].criterion)
            best = k;
    for (int k = 0; k < search->n; k++)
        sum += weight[k] = exp((search->candidate[best].criterion - search->candidate[k].criterion) / 2);
    for (int k = 0; k < search->n; k++)
        weight[k] /= sum;
    return best;
}

static struct estimate average(const struct search *search, const double *weight, int which)
{
    double mean = 0, variance = 0;
    for (int k = 0; k < search->n; k++)
        mean += weight[k] * search->candidate[k].out[which].value;
    for (int k = 0; k < search->n; k++) {
        const struct estimate *out = &search->candidate[k].out[which];
        variance += weight[k] * (out->error * out->error + (out->value - mean) * (out->value - mean));
    }
    return (struct estimate){mean, sqrt(variance)};
}

static bool evaluate_at(struct window *window, struct candidate *candidate)
{
    const double value[DEGREE_MAX + 1] = {1}, slope[DEGREE_MAX + 1] = {0, 1};
    const double deviation = window->clean->noise[0].deviation * widening(window);
    double c[DEGREE_MAX + 1], sum;
    if (!window_fit(window, 0, c, &sum))
        return false;
    candidate->out[0] = (struct estimate){c[0], deviation * window_error(window, value)};
    candidate->out[1] =
        (struct estimate){c[1] / window->scale, deviation * window_error(window, slope) / window->scale};
    return isfinite(candidate->out[1].error);
}

bool local_at(const struct local_curves *curves, double x0, double half, struct estimate *value, struct estimate *slope)
{
    struct search *search = calloc(1, sizeof *search);
    struct estimate *const out[] = {value, slope};
    double weight[CANDIDATES_MAX];
    if (!search || !clean_make(&search->clean, curves)) {
        free(search);
        return false;
    }
    search->centre = x0;
    search->half = half;
    range(&search->clean, x0, half, &search->begin, &search->end);
    if (clean_noise(&search->clean, search->begin, search->end))
        search_run(search, 1, 3, 1, evaluate_at);
    if (search->n > 0)
        (void)weights(search, weight);
    for (int which = 0; search->n > 0 && which < 2; which++) {
        double plain = 0;
        *out[which] = average(search, weight, which);
        for (int k = 0; k < search->n; k++)
            plain += weight[k] * search->candidate[k].plain[which];
        out[which]->error = hypot(out[which]->error, plain - out[which]->value);
    }
    const bool good = search->n > 0;
    clean_free(&search->clean);
    free(search);
    return good;
}

/* Highest inner maximum of c[degree + 1] for u in [a, b]; NaN if there is none. A grid, then Newton's method. */
static double maximum_place(const double *c, int degree, double a, double b)
{
    enum { GRID = 200, STEPS = 6 };
    const size_t m = (size_t)degree + 1;
    double best = -INFINITY, place = NAN, before = gsl_poly_eval(c, (int)m, a), step = (b - a) / GRID;
    double now = gsl_poly_eval(c, (int)m, a + step), d[3];
    for (int k = 1; k < GRID; k++) {
        const double after = gsl_poly_eval(c, (int)m, a + step * (k + 1));
        if (now > before && now >= after && now > best) {
            best = now;
            place = a + step * k;
        }
        before = now;
        now = after;
    }
    for (int k = 0; isfinite(place) && k < STEPS; k++) {
        if (gsl_poly_eval_derivs(c, m, place, d, 3) != 0 || !(d[2] < 0))
            return NAN;
        place -= d[1] / d[2];
    }
    return place > a && place < b ? place : NAN;
}

/* Value of every curve at u, into out[1...]; the errors are those at a given place. */
static bool values_at(struct window *window, double u, struct candidate *candidate)
{
    double gradient[DEGREE_MAX + 1], c[DEGREE_MAX + 1], sum;
    for (int d = 0; d <= window->degree; d++)
        gradient[d] = d ? gradient[d - 1] * u : 1;
    const double error = window_error(window, gradient) * widening(window);
    for (int k = 0; k < window->clean->count; k++) {
        if (!window_fit(window, k, c, &sum))
            return false;
        candidate->out[k + 1] =
            (struct estimate){gsl_poly_eval(c, window->degree + 1, u), window->clean->noise[k].deviation * error};
    }
    return true;
}

/* The place's error moves the other curves along their slopes; at the maximum the leading one has none. */
static void place_error_add(struct window *window, double u, struct candidate *candidate)
{
    for (int k = 1; k < window->clean->count; k++) {
        double c[DEGREE_MAX + 1], d[2], sum;
        if (!window_fit(window, k, c, &sum) || gsl_poly_eval_derivs(c, (size_t)window->degree + 1, u, d, 2) != 0)
            continue;
        struct estimate *out = &candidate->out[k + 1];
        out->error = hypot(out->error, candidate->out[0].error * d[1] / window->scale);
    }
}

static bool evaluate_peak(struct window *window, struct candidate *candidate)
{
    const size_t rows = window->end - window->begin;
    double c[DEGREE_MAX + 1], gradient[DEGREE_MAX + 1] = {0, 1}, d[3], sum;
    if (!window_fit(window, 0, c, &sum))
        return false;
    const double u = maximum_place(c, window->degree, abscissa(window, 0), abscissa(window, rows - 1));
    if (isnan(u) || gsl_poly_eval_derivs(c, (size_t)window->degree + 1, u, d, 3) != 0)
        return false;
    for (int k = 2; k <= window->degree; k++)
        gradient[k] = k * pow(u, k - 1);
    const double deviation = window->clean->noise[0].deviation * widening(window);
    candidate->out[0] = (struct estimate){window->origin + u * window->scale,
                                          deviation * window_error(window, gradient) / fabs(d[2]) * window->scale};
    if (!values_at(window, u, candidate))
        return false;
    place_error_add(window, u, candidate);
    return isfinite(candidate->out[0].error);
}

static bool evaluate_end(struct window *window, struct candidate *candidate)
{
    candidate->out[0] = (struct estimate){window->origin, NAN};
    return values_at(window, 0, candidate);
}

/* Largest value of a moving parabola on a grid of 401 places. */
static double coarse_place(const struct clean *clean, double narrow)
{
    enum { GRID = 400 };
    const double first = clean->x[0], span = clean->x[clean->n - 1] - first;
    double best = -INFINITY, place = first; /* the correlation is not known yet, and does not matter here */
    for (int k = 0; k <= GRID; k++) {
        struct window window = {.clean = clean, .origin = first + span * k / GRID, .scale = narrow};
        double c[3], sum;
        range(clean, window.origin, narrow, &window.begin, &window.end);
        if (window.end < window.begin + 4 || !window_open(&window, 2))
            continue;
        const bool good = window_fit(&window, 0, c, &sum);
        window_close(&window);
        if (good && c[0] > best) {
            best = c[0];
            place = window.origin;
        }
    }
    return place;
}

/* Where no window has a maximum, the curve is largest at an end: its value there. */
static void search_end(struct search *search, double narrow, struct local_peak *peak)
{
    const double *x = search->clean.x, first = x[0], last = x[search->clean.n - 1];
    peak->at_end = search->centre - first < last - search->centre ? -1 : 1;
    search->centre = peak->at_end > 0 ? last : first;
    const size_t some = search->clean.n < 16 ? search->clean.n - 1 : 16;
    search->half = fmax(4 * narrow, peak->at_end > 0 ? last - x[search->clean.n - 1 - some] : x[some] - first);
    range(&search->clean, search->centre, search->half, &search->begin, &search->end);
    search_run(search, 1, 2, 1, evaluate_end);
}

static bool search_peak(struct search *search, double narrow, struct local_peak *peak)
{
    if (search->clean.n < LOCAL_POINTS_MIN)
        return false;
    const double *x = search->clean.x, first = x[0], last = x[search->clean.n - 1];
    double weight[CANDIDATES_MAX];
    search->centre = coarse_place(&search->clean, narrow);
    search->half = fmax(narrow, search->centre / 2);
    range(&search->clean, search->centre, search->half, &search->begin, &search->end);
    peak->at_end = 0;
    if (!clean_noise(&search->clean, search->begin, search->end))
        return false;
    if (search->centre > first + narrow / 4 && search->centre < last - narrow / 4)
        search_run(search, 2, 3, 2, evaluate_peak);
    if (search->n == 0)
        search_end(search, narrow, peak);
    if (search->n == 0)
        return false;
    const int best = weights(search, weight);
    memcpy(peak->window, search->candidate[best].window, sizeof peak->window);
    peak->place = average(search, weight, 0);
    for (int k = 0; k < search->clean.count; k++)
        peak->value[k] = average(search, weight, k + 1);
    return true;
}

bool local_peak_find(const struct local_curves *curves, double narrow, struct local_peak *peak)
{
    struct search *search = calloc(1, sizeof *search);
    memset(peak, 0, sizeof *peak);
    if (!search || !clean_make(&search->clean, curves)) {
        free(search);
        return false;
    }
    const bool good = search_peak(search, narrow, peak);
    clean_free(&search->clean);
    free(search);
    return good;
}
