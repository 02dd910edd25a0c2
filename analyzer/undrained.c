#include "analyzer/undrained.h"

#include <math.h>

const double undrained_liquefied = 0.95;

static void plain(struct quantity *quantity, double value)
{
    quantity_set(quantity, (struct estimate){value, NAN});
}

static size_t least(const double *y, size_t n)
{
    size_t k = 0;
    for (size_t i = 1; i < n; i++)
        if (y[i] < y[k])
            k = i;
    return k;
}

/* Mean of y over samples around i, so that one sample's noise does not count as an extreme. */
static double around(const double *y, size_t n, size_t i)
{
    const size_t reach = n / 100, begin = i > reach ? i - reach : 0, end = i + reach + 1 < n ? i + reach + 1 : n;
    double sum = 0;
    for (size_t k = begin; k < end; k++)
        sum += y[k];
    return sum / (double)(end - begin);
}

/* Where p is least and rises again: from contraction to dilation (Ishihara, Tatsuoka & Yasuda 1975). */
static void phase_transformation(const struct curves *curves, struct quantity *q)
{
    const double *p = curves->column[CURVE_P], *deviator = curves->column[CURVE_Q];
    const size_t n = curves->n, k = least(p, n);
    const double low = around(p, n, k), p0 = p[0];
    if (k == 0 || !(p0 - low > 0.01 * p0) || !(around(p, n, n - 1) - low > 0.01 * p0)) {
        for (int id = QUANTITY_PT_EPS; id <= QUANTITY_PT_Q_OVER_P; id++)
            quantity_undefined(&q[id], "p does not fall and rise again by 1 %% of p0");
        return;
    }
    plain(&q[QUANTITY_PT_EPS], curves->column[CURVE_EPS_ZZ][k]);
    plain(&q[QUANTITY_PT_P], low);
    plain(&q[QUANTITY_PT_Q], around(deviator, n, k));
    plain(&q[QUANTITY_PT_Q_OVER_P], around(deviator, n, k) / low);
}

static void liquefaction(const struct curves *curves, struct quantity *quantity)
{
    const double *u = curves->column[CURVE_U], p0 = curves->column[CURVE_P][0];
    quantity_undefined(quantity, "r_u stays below %g", undrained_liquefied);
    for (size_t i = 0; i < curves->n; i++)
        if (u[i] >= undrained_liquefied * p0) {
            plain(quantity, curves->column[CURVE_EPS_ZZ][i]);
            return;
        }
}

void undrained_evaluate(const struct curves *curves, struct quantity *q)
{
    const size_t n = curves->n;
    if (n < 2 || !(curves->column[CURVE_P][0] > 0)) {
        for (int id = QUANTITY_P0; id <= QUANTITY_VOLUME_KEPT; id++)
            quantity_undefined(&q[id], "no pressure at the start of the stage");
        return;
    }
    const double p0 = curves->column[CURVE_P][0], *volume = curves->column[CURVE_EPS_V];
    const double u_max = p0 - around(curves->column[CURVE_P], n, least(curves->column[CURVE_P], n));
    double change = 0;
    for (size_t i = 0; i < n; i++)
        change = fmax(change, fabs(volume[i]));
    plain(&q[QUANTITY_P0], p0);
    plain(&q[QUANTITY_U_MAX], u_max);
    plain(&q[QUANTITY_U_END], around(curves->column[CURVE_U], n, n - 1));
    plain(&q[QUANTITY_R_U_MAX], u_max / p0);
    plain(&q[QUANTITY_VOLUME_KEPT], change);
    phase_transformation(curves, q);
    liquefaction(curves, &q[QUANTITY_LIQUEFACTION_EPS]);
}
