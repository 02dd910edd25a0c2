#include "analyzer/stiffness.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const double degrees = 180 / M_PI;

/* Half window of local slopes: a quarter of the strain, at most 1/40 of the range, at least some samples. */
static double half_window(const struct loading *loading, double eps)
{
    const double span = loading->eps[loading->n - 1] - loading->eps[0];
    size_t k = statistics_lower_bound(loading->eps, loading->n, eps), reach = 6;
    const size_t low = k > reach ? k - reach : 0, high = k + reach < loading->n ? k + reach : loading->n - 1;
    const double samples = fmin(eps - loading->eps[low], loading->eps[high] - eps);
    return fmax(fmin(eps / 4, span / 40), samples);
}

static void rows_fill(struct stiffness *stiffness, const struct loading *loading)
{
    const double *q = loading->y[LOADING_Q], first = loading->eps[0], last = loading->eps[loading->n - 1];
    const size_t begin = loading->n > 8 ? 8 : loading->n - 1; /* a few samples lie before the first row */
    const double low = fmax(loading->eps[begin], last * 1e-4), factor = pow(last / low, 1.0 / (STIFFNESS_ROWS - 1));
    if (!(low > first) || !(low < last))
        return;
    for (double eps = low; stiffness->n < STIFFNESS_ROWS; eps *= factor) {
        struct stiffness_row *row = &stiffness->row[stiffness->n];
        const double half = half_window(loading, eps),
                     x = loading_to_log(loading, eps) - loading_to_log(loading, first);
        row->eps = eps;
        row->q_pa = loading_smooth(loading, q, eps, half) - q[0];
        row->secant_pa = row->q_pa / x;
        row->tangent_pa = loading_smooth_slope(loading, LOADING_Q, eps, fmax(half, fmin(eps / 2, last / 10)));
        row->ratio = loading_smooth(loading, loading->y[LOADING_RATIO], eps, half);
        row->dilatancy =
            loading->sign > 0 ? 1 - loading_smooth_slope(loading, LOADING_EPS_V_LOG, eps, fmax(half, last / 40)) : NAN;
        stiffness->n++;
    }
}

/* Strain at which the secant modulus falls to half of the initial one, between rows in the logarithm of strain. */
static void half_stiffness(const struct stiffness *stiffness, struct quantity *q)
{
    const double level = q[QUANTITY_E_INITIAL].value / 2;
    struct quantity *out = &q[QUANTITY_HALF_STIFFNESS];
    quantity_undefined(out, "the secant modulus does not fall to half of E_initial");
    for (size_t k = 1; k < stiffness->n; k++) {
        const struct stiffness_row *a = &stiffness->row[k - 1], *b = &stiffness->row[k];
        if (!(a->secant_pa >= level) || !(b->secant_pa < level))
            continue;
        const double share = (a->secant_pa - level) / (a->secant_pa - b->secant_pa);
        quantity_set(out, (struct estimate){a->eps * pow(b->eps / a->eps, share), NAN});
        return;
    }
}

/* R = K D by least squares through the origin, from the least volume to the peak. */
static bool rowe_fit(const struct stiffness *stiffness, double low, double high, struct estimate *k)
{
    double rd = 0, dd = 0, rest = 0, n = 0;
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0; i < stiffness->n; i++) {
            const struct stiffness_row *row = &stiffness->row[i];
            if (row->eps < low || row->eps > high || !isfinite(row->ratio) || !isfinite(row->dilatancy))
                continue;
            if (pass == 0) {
                rd += row->ratio * row->dilatancy;
                dd += row->dilatancy * row->dilatancy;
                n++;
            } else {
                rest += pow(row->ratio - rd / dd * row->dilatancy, 2);
            }
        }
    if (n < 5)
        return false;
    /* neighbouring rows share samples: their scatter counts as that of a third of them */
    *k = (struct estimate){rd / dd, sqrt(rest / (n - 1) / dd * 3) * statistics_widening(fmax(2, n / 3 - 1))};
    return true;
}

static void rowe(const struct stiffness *stiffness, const struct curves *curves, struct quantity *q)
{
    struct estimate k;
    double low = 0, least = -INFINITY;
    const double high = fabs(q[QUANTITY_PEAK_EPS_ZZ].value);
    const double *eps = curves->column[CURVE_EPS_ZZ], *volume = curves->column[CURVE_EPS_V];
    for (size_t i = 0; i < curves->n; i++)
        if (volume[i] > least) {
            least = volume[i];
            low = eps[i];
        }
    if (low > high / 2)
        low = high / 4; /* a loose sample contracts all the way */
    if (curves->controls.extension || curves->controls.kind == TEST_CONSTANT_VOLUME || !isfinite(high) ||
        !rowe_fit(stiffness, low, high, &k)) {
        quantity_undefined(&q[QUANTITY_ROWE_K], "needs a drained compression with five strains before the peak");
        quantity_undefined(&q[QUANTITY_ROWE_ANGLE], "needs a drained compression with five strains before the peak");
        return;
    }
    quantity_set(&q[QUANTITY_ROWE_K], k);
    quantity_window(&q[QUANTITY_ROWE_K], low, high);
    /* K = tan^2(45 deg + phi/2), so sin phi = (K - 1)/(K + 1) */
    const double sine = (k.value - 1) / (k.value + 1), slope = 2 / pow(k.value + 1, 2) / sqrt(1 - sine * sine);
    quantity_set(&q[QUANTITY_ROWE_ANGLE], (struct estimate){asin(sine) * degrees, k.error * slope * degrees});
    quantity_window(&q[QUANTITY_ROWE_ANGLE], low, high);
}

void stiffness_evaluate(struct stiffness *stiffness, const struct curves *curves, const struct loading *loading,
                        struct quantity *quantities)
{
    *stiffness = (struct stiffness){0};
    rows_fill(stiffness, loading);
    half_stiffness(stiffness, quantities);
    rowe(stiffness, curves, quantities);
}

enum status stiffness_write_csv(const struct stiffness *stiffness, const char *path)
{
    FILE *out = fopen(path, "w");
    if (!out)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    fprintf(out, "eps_zz,q_pa,secant_pa,tangent_pa,stress_ratio,dilatancy\n");
    for (size_t k = 0; k < stiffness->n; k++) {
        const struct stiffness_row *row = &stiffness->row[k];
        fprintf(out, "%.12g,%.12g,%.12g,%.12g,%.12g,%.12g\n", row->eps, row->q_pa, row->secant_pa, row->tangent_pa,
                row->ratio, row->dilatancy);
    }
    int failed = ferror(out); /* sticky: covers every write above */
    if (fclose(out) != 0 || failed)
        return status_fail(STATUS_IO, "%s: cannot be written: %s", path, strerror(errno));
    return STATUS_OK;
}
