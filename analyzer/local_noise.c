#include <math.h>

#include "analyzer/local_fit.h"

enum { HALF_MAX = 25, WIDTH_MAX = 2 * HALF_MAX + 1 };

static const double correlation_max = 0.95;

/* What a sample keeps of its neighbours when the cubic over them is taken off: row[2 half + 1]. Even and odd powers do
 * not mix, so that the value in the middle is that of the parabola: weights (a + b k^2), sum 1, second moment 0. */
static void residual_row(int half, double *row)
{
    double m0 = 0, m2 = 0, m4 = 0;
    for (int k = -half; k <= half; k++) {
        const double square = (double)k * k;
        m0 += 1;
        m2 += square;
        m4 += square * square;
    }
    const double determinant = m0 * m4 - m2 * m2;
    for (int k = -half; k <= half; k++)
        row[k + half] = (k == 0) - (m4 - m2 * (double)k * k) / determinant;
}

/* Covariance of the residuals `lag` samples apart, for an autoregression of unit variance. */
static double response(const double *row, int width, double correlation, int lag)
{
    double power[2 * WIDTH_MAX] = {1}, sum = 0;
    for (int k = 1; k < 2 * width; k++)
        power[k] = power[k - 1] * correlation;
    for (int a = 0; a < width; a++)
        for (int b = 0; b < width; b++)
            sum += row[a] * row[b] * power[a > b + lag ? a - b - lag : b + lag - a];
    return sum;
}

/* The correlation whose residuals are correlated by `ratio`, by bisection. */
static double correlation_find(const double *row, int width, double ratio)
{
    enum { STEPS = 12 };
    double low = 0, high = correlation_max;
    for (int k = 0; k < STEPS; k++) {
        const double middle = (low + high) / 2;
        if (response(row, width, middle, 1) < ratio * response(row, width, middle, 0))
            low = middle;
        else
            high = middle;
    }
    return low < correlation_max / (1 << STEPS) ? 0 : low;
}

bool local_noise_estimate(const double *y, size_t n, struct local_noise *noise)
{
    double row[WIDTH_MAX], square = 0, product = 0, before = 0, largest = 0;
    if (n < LOCAL_POINTS_MIN)
        return false;
    const int half = n >= 6 * HALF_MAX ? HALF_MAX : n < 24 ? 4 : (int)(n / 6), width = 2 * half + 1;
    const size_t places = n - (size_t)width + 1;
    residual_row(half, row);
    for (size_t i = 0; i < places; i++) {
        double residual = 0;
        for (int k = 0; k < width; k++) {
            residual += row[k] * y[i + (size_t)k];
            largest = fmax(largest, fabs(y[i + (size_t)k]));
        }
        square += residual * residual / (double)places;
        product += i ? residual * before / (double)(places - 1) : 0;
        before = residual;
    }
    noise->correlation = square > 0 ? correlation_find(row, width, product / square) : 0;
    noise->deviation = sqrt(square / response(row, width, noise->correlation, 0));
    noise->deviation = fmax(noise->deviation, 1e-14 * largest + 1e-300); /* rounding, for curves without noise */
    return isfinite(noise->deviation);
}
