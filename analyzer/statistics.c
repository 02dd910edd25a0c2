#include "analyzer/statistics.h"

#include <gsl/gsl_cdf.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit.h>
#include <math.h>
#include <stdlib.h>

void statistics_weights(const double *x, double *w, size_t n)
{
    for (size_t k = 0; k < n; k++) {
        double lower = k > 0 ? x[k - 1] : x[k];
        double upper = k + 1 < n ? x[k + 1] : x[k];
        w[k] = n > 1 ? (upper - lower) / 2 : 1;
    }
}

size_t statistics_lower_bound(const double *x, size_t n, double bound)
{
    size_t low = 0, high = n;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (x[middle] < bound)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* The design of a polynomial in u = (x - centre)/scale, |u| <= 1, over the points that count: [used][degree + 1]. */
struct design {
    double centre, scale;
    size_t used;
    double *row, *y, *w; /* owned by row */
};

static bool design_make(struct design *design, const struct points *points, const double *y, size_t skip_begin,
                        size_t skip_end, int degree)
{
    const size_t columns = (size_t)degree + 1, n = points->n;
    design->centre = (points->x[0] + points->x[n - 1]) / 2;
    design->scale = (points->x[n - 1] - points->x[0]) / 2;
    design->used = 0;
    design->row = malloc(n * (columns + 2) * sizeof *design->row);
    if (!design->row)
        return false;
    if (!(design->scale > 0))
        design->scale = 1;
    design->y = design->row + n * columns;
    design->w = design->y + n;
    for (size_t k = 0; k < n; k++) {
        if ((k >= skip_begin && k < skip_end) || !isfinite(y[k]))
            continue;
        double power = 1, u = (points->x[k] - design->centre) / design->scale;
        for (size_t c = 0; c < columns; c++, power *= u)
            design->row[design->used * columns + c] = power;
        design->y[design->used] = y[k];
        design->w[design->used++] = points->w[k];
    }
    return true;
}

static bool design_solve(const struct design *design, int degree, double *b)
{
    const size_t columns = (size_t)degree + 1;
    double covariance[(FIT_DEGREE_MAX + 1) * (FIT_DEGREE_MAX + 1)], misfit;
    gsl_matrix_view x = gsl_matrix_view_array(design->row, design->used, columns);
    gsl_matrix_view c = gsl_matrix_view_array(covariance, columns, columns);
    gsl_vector_view w = gsl_vector_view_array(design->w, design->used), out = gsl_vector_view_array(b, columns);
    gsl_vector_view y = gsl_vector_view_array(design->y, design->used);
    gsl_multifit_linear_workspace *room = gsl_multifit_linear_alloc(design->used, columns);
    size_t rank = 0;
    if (!room)
        return false;
    int failed =
        gsl_multifit_wlinear_tsvd(&x.matrix, &w.vector, &y.vector, 1e-12, &out.vector, &c.matrix, &misfit, &rank, room);
    gsl_multifit_linear_free(room);
    return !failed && rank == columns;
}

bool statistics_polynomial(const struct points *points, const double *y, size_t skip_begin, size_t skip_end, int degree,
                           double x0, double c[FIT_DEGREE_MAX + 1])
{
    double b[FIT_DEGREE_MAX + 1] = {0};
    struct design design;
    c[0] = c[1] = c[2] = 0;
    (void)gsl_set_error_handler_off(); /* failures are returned */
    if (points->n == 0 || !design_make(&design, points, y, skip_begin, skip_end, degree))
        return false;
    bool good = design.used > (size_t)degree && design_solve(&design, degree, b);
    free(design.row);
    if (!good)
        return false;
    /* shift from the centre to x0 and undo the scale */
    double scale = design.scale, s = (x0 - design.centre) / scale;
    c[0] = b[0] + s * (b[1] + s * b[2]);
    c[1] = (b[1] + 2 * s * b[2]) / scale;
    c[2] = b[2] / (scale * scale);
    return true;
}

static int block_count(size_t n)
{
    if (n >= 2 * STATISTICS_BLOCKS)
        return STATISTICS_BLOCKS;
    return n >= 8 ? (int)(n / 2) : (int)n;
}

/* End of block b of `blocks` of equal length in x. */
static size_t block_end(const struct points *points, int b, int blocks)
{
    if (b + 1 == blocks)
        return points->n;
    double first = points->x[0], last = points->x[points->n - 1];
    return statistics_lower_bound(points->x, points->n, first + (last - first) * (b + 1) / blocks);
}

/* Standard deviation (n - 1) of v[n]. */
static double deviation(const double *v, int n)
{
    double mean = 0, sum = 0;
    for (int k = 0; k < n; k++)
        mean += v[k] / n;
    for (int k = 0; k < n; k++)
        sum += (v[k] - mean) * (v[k] - mean);
    return n > 1 ? sqrt(sum / (n - 1)) : NAN;
}

bool statistics_jackknife(const struct points *points, statistics_estimator *estimator, const void *context, int n_out,
                          struct estimate *out)
{
    double value[STATISTICS_OUT_MAX], replica[STATISTICS_OUT_MAX][STATISTICS_BLOCKS];
    if (!estimator(context, 0, 0, value))
        return false;
    for (int k = 0; k < n_out; k++)
        out[k] = (struct estimate){value[k], NAN};
    int blocks = block_count(points->n), used = 0;
    size_t begin = 0;
    for (int b = 0; blocks >= 4 && b < blocks; b++) {
        size_t end = block_end(points, b, blocks);
        if (end > begin) { /* sparse data leave blocks empty */
            if (!estimator(context, begin, end, value))
                return true;
            for (int k = 0; k < n_out; k++)
                replica[k][used] = value[k];
            used++;
        }
        begin = end;
    }
    for (int k = 0; k < n_out && used >= 4; k++)
        out[k].error = deviation(replica[k], used) * (used - 1) / sqrt(used) * statistics_widening(used - 1);
    return true;
}

struct line_context {
    const struct points *points;
    const double *y;
};

static bool line_slope(const void *context, size_t skip_begin, size_t skip_end, double *out)
{
    const struct line_context *line = context;
    double c[FIT_DEGREE_MAX + 1];
    bool good = statistics_polynomial(line->points, line->y, skip_begin, skip_end, 1, 0, c);
    out[0] = c[1];
    return good;
}

bool statistics_slope(const struct points *points, const double *y, struct estimate *slope)
{
    struct line_context line = {points, y};
    *slope = (struct estimate){NAN, NAN};
    return points->n >= 3 && statistics_jackknife(points, line_slope, &line, 1, slope);
}

/* Weighted sum and weight of the finite y in [begin, end). */
static double partial_mean(const struct points *points, const double *y, size_t begin, size_t end)
{
    double sum = 0, weight = 0;
    for (size_t k = begin; k < end; k++) {
        if (!isfinite(y[k]))
            continue;
        sum += points->w[k] * y[k];
        weight += points->w[k];
    }
    return sum / weight; /* NaN for an empty range */
}

bool statistics_mean(const struct points *points, const double *y, struct estimate *mean)
{
    double block[STATISTICS_BLOCKS];
    *mean = (struct estimate){partial_mean(points, y, 0, points->n), NAN};
    if (!isfinite(mean->value))
        return false;
    int blocks = block_count(points->n), used = 0;
    size_t begin = 0;
    for (int b = 0; blocks >= 4 && b < blocks; b++) {
        size_t end = block_end(points, b, blocks);
        double value = partial_mean(points, y, begin, end);
        if (isfinite(value))
            block[used++] = value;
        begin = end;
    }
    if (used >= 4)
        mean->error = deviation(block, used) / sqrt(used) * statistics_widening(used - 1);
    return true;
}

struct estimate statistics_plain_mean(const double *v, size_t n, double *standard_deviation)
{
    struct estimate mean = {n ? 0 : NAN, NAN};
    for (size_t k = 0; k < n; k++)
        mean.value += v[k] / (double)n;
    *standard_deviation = n ? deviation(v, (int)n) : NAN;
    mean.error = *standard_deviation / sqrt((double)n);
    return mean;
}

double statistics_student_cdf(double t, double dof)
{
    return gsl_cdf_tdist_P(t, dof);
}

double statistics_widening(double dof)
{
    return gsl_cdf_tdist_Pinv(gsl_cdf_ugaussian_P(2), dof) / 2;
}
