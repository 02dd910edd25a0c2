#include "analyzer/statistics.h"

#include <math.h>

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

/* Gaussian elimination with row pivoting of a[m][m] c = b; false if singular to rounding. */
static bool solve(int m, double a[][FIT_DEGREE_MAX + 1], double *b)
{
    for (int k = 0; k < m; k++) {
        int pivot = k;
        for (int r = k + 1; r < m; r++)
            if (fabs(a[r][k]) > fabs(a[pivot][k]))
                pivot = r;
        if (!(fabs(a[pivot][k]) > 1e-12))
            return false;
        for (int c = 0; c < m; c++) {
            double keep = a[k][c];
            a[k][c] = a[pivot][c];
            a[pivot][c] = keep;
        }
        double keep = b[k];
        b[k] = b[pivot];
        b[pivot] = keep;
        for (int r = k + 1; r < m; r++) {
            double factor = a[r][k] / a[k][k];
            for (int c = k; c < m; c++)
                a[r][c] -= factor * a[k][c];
            b[r] -= factor * b[k];
        }
    }
    for (int k = m - 1; k >= 0; k--) {
        for (int c = k + 1; c < m; c++)
            b[k] -= a[k][c] * b[c];
        b[k] /= a[k][k];
    }
    return true;
}

/* Normal equations of the polynomial in u = (x - centre)/scale, |u| <= 1, weights divided by their sum. Returns the
 * number of points in them. */
static size_t normal_equations(const struct points *points, const double *y, size_t skip_begin, size_t skip_end,
                               int degree, double centre, double scale, double a[][FIT_DEGREE_MAX + 1], double *b)
{
    double moment[2 * FIT_DEGREE_MAX + 1] = {0}, right[FIT_DEGREE_MAX + 1] = {0};
    size_t used = 0;
    for (size_t k = 0; k < points->n; k++) {
        if ((k >= skip_begin && k < skip_end) || !isfinite(y[k]))
            continue;
        double u = (points->x[k] - centre) / scale, power = points->w[k];
        for (int d = 0; d <= 2 * degree; d++, power *= u) {
            moment[d] += power;
            if (d <= degree)
                right[d] += power * y[k];
        }
        used++;
    }
    for (int r = 0; r <= degree; r++) {
        for (int c = 0; c <= degree; c++)
            a[r][c] = moment[r + c] / moment[0];
        b[r] = right[r] / moment[0];
    }
    return used;
}

bool statistics_polynomial(const struct points *points, const double *y, size_t skip_begin, size_t skip_end, int degree,
                           double x0, double c[FIT_DEGREE_MAX + 1])
{
    double a[FIT_DEGREE_MAX + 1][FIT_DEGREE_MAX + 1], b[FIT_DEGREE_MAX + 1] = {0};
    c[0] = c[1] = c[2] = 0;
    if (points->n == 0)
        return false;
    double centre = (points->x[0] + points->x[points->n - 1]) / 2;
    double scale = (points->x[points->n - 1] - points->x[0]) / 2;
    if (!(scale > 0))
        scale = 1;
    size_t used = normal_equations(points, y, skip_begin, skip_end, degree, centre, scale, a, b);
    if (used <= (size_t)degree || !solve(degree + 1, a, b))
        return false;
    /* shift from the centre to x0 and undo the scale */
    double s = (x0 - centre) / scale;
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
        out[k].error = deviation(replica[k], used) * (used - 1) / sqrt(used);
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
        mean->error = deviation(block, used) / sqrt(used);
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

/* Continued fraction of the incomplete beta function by Lentz's method. */
static double beta_fraction(double a, double b, double x)
{
    enum { TERMS = 500 };
    static const double tiny = 1e-300;
    double c = 1, d = 1 - (a + b) * x / (a + 1);
    d = 1 / (fabs(d) < tiny ? tiny : d);
    double fraction = d;
    for (int m = 1; m <= TERMS; m++) {
        double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        double terms[2] = {even, odd}, step = 1;
        for (int k = 0; k < 2; k++) {
            d = 1 + terms[k] * d;
            c = 1 + terms[k] / c;
            d = 1 / (fabs(d) < tiny ? tiny : d);
            c = fabs(c) < tiny ? tiny : c;
            step = c * d;
            fraction *= step;
        }
        if (fabs(step - 1) < 1e-15)
            break;
    }
    return fraction;
}

/* Regularised incomplete beta function I_x(a, b). */
static double beta_regularised(double a, double b, double x)
{
    if (x <= 0 || x >= 1)
        return x <= 0 ? 0 : 1;
    double front = exp(lgamma(a + b) - lgamma(a) - lgamma(b) + a * log(x) + b * log1p(-x));
    if (x < (a + 1) / (a + b + 2))
        return front * beta_fraction(a, b, x) / a;
    return 1 - front * beta_fraction(b, a, 1 - x) / b;
}

double statistics_student_cdf(double t, double dof)
{
    double tail = beta_regularised(dof / 2, 0.5, dof / (dof + t * t)) / 2;
    return t > 0 ? 1 - tail : tail;
}
