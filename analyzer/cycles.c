#include "analyzer/cycles.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double collapse_strain = 0.1;
static const double two_sigma = 0.97725; /* one-sided probability of the normal distribution at 2 sigma */

static double period_of(const struct curves *curves)
{
    return curves->controls.period_s;
}

/* A column at stage time t, linear between samples; cut at the ends. */
static double at_time(const struct curves *curves, enum curve column, double t)
{
    const double *time = curves->column[CURVE_STAGE_TIME], *y = curves->column[column];
    size_t k = statistics_lower_bound(time, curves->n, t);
    if (k == 0 || k == curves->n)
        return y[k == 0 ? 0 : curves->n - 1];
    double span = time[k] - time[k - 1];
    return span > 0 ? y[k - 1] + (y[k] - y[k - 1]) * (t - time[k - 1]) / span : y[k];
}

/* Samples strictly inside (t0, t1); the ends of a cycle are interpolated. */
static void inner_samples(const struct curves *curves, double t0, double t1, size_t *begin, size_t *end)
{
    double slack = 1e-9 * (t1 - t0);
    *begin = statistics_lower_bound(curves->column[CURVE_STAGE_TIME], curves->n, t0 + slack);
    *end = statistics_lower_bound(curves->column[CURVE_STAGE_TIME], curves->n, t1 - slack);
}

struct extent {
    double lowest, highest;
};

static void extend(struct extent *extent, double value)
{
    extent->lowest = fmin(extent->lowest, value);
    extent->highest = fmax(extent->highest, value);
}

/* One vertex of the loop. */
struct vertex {
    double t, eps_d, sigma_d, eps_c, q;
};

static struct vertex vertex_at(const struct curves *curves, double t)
{
    struct vertex v = {t, at_time(curves, CURVE_EPS_D_LOG, t), at_time(curves, CURVE_SIGMA_D, t),
                       at_time(curves, CURVE_EPS_ZZ_LOG, t), 0};
    v.q = at_time(curves, CURVE_SIGMA_ZZ, t) - at_time(curves, CURVE_SIGMA_XX, t);
    return v;
}

/* Area, resilient modulus and damping of one cycle. */
static void loop_measure(const struct curves *curves, double t0, double t1, struct cycle *cycle)
{
    size_t begin, end;
    inner_samples(curves, t0, t1, &begin, &end);
    cycle->loop_area_j_per_m3 = cycle->resilient_modulus_pa = cycle->damping_ratio = NAN;
    if (end < begin + CYCLES_LOOP_MIN)
        return;
    struct vertex start = vertex_at(curves, t0), stop = vertex_at(curves, t1), before = start;
    struct extent eps = {0, 0}, sigma = {start.sigma_d, start.sigma_d};
    double area = 0, eps_c_max = start.eps_c, q_max = start.q;
    for (size_t k = begin; k <= end; k++) {
        struct vertex v = k < end ? vertex_at(curves, curves->column[CURVE_STAGE_TIME][k]) : stop;
        area += (v.sigma_d + before.sigma_d) / 2 * (v.eps_d - before.eps_d);
        extend(&eps, v.eps_d - start.eps_d - (stop.eps_d - start.eps_d) * (v.t - t0) / (t1 - t0));
        extend(&sigma, v.sigma_d);
        eps_c_max = fmax(eps_c_max, v.eps_c);
        q_max = fmax(q_max, v.q);
        before = v;
    }
    /* back along the straight line from the end to the start */
    area -= (stop.sigma_d + start.sigma_d) / 2 * (stop.eps_d - start.eps_d);
    double elastic = (sigma.highest - sigma.lowest) * (eps.highest - eps.lowest) / 8;
    cycle->loop_area_j_per_m3 = area;
    if (elastic > 0)
        cycle->damping_ratio = area / (4 * M_PI * elastic);
    if (eps_c_max > stop.eps_c)
        cycle->resilient_modulus_pa = (q_max - stop.q) / (eps_c_max - stop.eps_c);
}

static void cycles_measure(struct cycles *cycles, const struct curves *curves)
{
    double period = period_of(curves), eps_d = 0, eps_v = 0;
    for (size_t k = 0; k < cycles->n; k++) {
        struct cycle *cycle = &cycles->cycle[k];
        double t0 = period * (double)k, t1 = period * (double)(k + 1);
        cycle->eps_d = at_time(curves, CURVE_EPS_D_LOG, t1);
        cycle->eps_v = at_time(curves, CURVE_EPS_V_LOG, t1);
        cycle->rate_d = cycle->eps_d - eps_d;
        cycle->rate_v = cycle->eps_v - eps_v;
        eps_d = cycle->eps_d;
        eps_v = cycle->eps_v;
        loop_measure(curves, t0, t1, cycle);
    }
}

/* Mean gain per cycle over cycles [begin, end), deviatoric or volumetric. */
static struct estimate mean_rate(const struct cycles *cycles, size_t begin, size_t end, bool volumetric)
{
    double mean = 0, sum = 0, count = (double)(end - begin);
    for (size_t k = begin; k < end; k++)
        mean += (volumetric ? cycles->cycle[k].rate_v : cycles->cycle[k].rate_d) / count;
    for (size_t k = begin; k < end; k++) {
        double off = (volumetric ? cycles->cycle[k].rate_v : cycles->cycle[k].rate_d) - mean;
        sum += off * off;
    }
    return (struct estimate){mean, sqrt(sum / (count - 1) / count)};
}

/* |rate| ~ N^m from the means of the third and fourth quarter: m = ln(r4/r3)/ln(N4/N3), N the middles. A mean over a
 * quarter, unlike the logarithm of each rate, takes rates that scatter around zero. */
static struct estimate rate_exponent(const struct cycles *cycles, size_t begin, size_t middle)
{
    struct estimate third = mean_rate(cycles, begin, middle, false);
    struct estimate fourth = mean_rate(cycles, middle, cycles->n, false);
    double span = log(((double)(middle + cycles->n) + 1) / ((double)(begin + middle) + 1));
    double ratio = fourth.value / third.value;
    if (!(ratio > 0))
        return (struct estimate){NAN, NAN};
    return (struct estimate){log(ratio) / span, hypot(third.error / third.value, fourth.error / fourth.value) / span};
}

/* ln |eps_D| = ln a + b ln N by least squares; every cycle weighs the same in ln N. */
static void power_law(struct cycles *cycles)
{
    cycles->factor = cycles->power = (struct estimate){NAN, NAN};
    double *x = malloc(3 * cycles->n * sizeof *x), *y = x + cycles->n, *w = y + cycles->n, c[FIT_DEGREE_MAX + 1];
    if (!x)
        return;
    bool good = true;
    for (size_t k = 0; k < cycles->n; k++) {
        x[k] = log((double)(k + 1));
        y[k] = log(fabs(cycles->cycle[k].eps_d));
        good = good && isfinite(y[k]);
    }
    statistics_weights(x, w, cycles->n);
    struct points points = {x, w, cycles->n};
    if (good && statistics_slope(&points, y, &cycles->power) && statistics_polynomial(&points, y, 0, 0, 1, 0, c))
        cycles->factor.value = exp(c[0]);
    free(x);
}

/* P(estimate > bound) by Student's t; certain where there is no scatter at all. */
static double probability_above(struct estimate estimate, double bound, double dof)
{
    double off = estimate.value - bound;
    if (!(estimate.error > 1e-12 * fabs(off)))
        return off > 0 ? 1 : off < 0 ? 0 : 0.5;
    return statistics_student_cdf(off / estimate.error, dof);
}

static void decide(struct cycles *cycles, enum cycles_verdict verdict, double confidence, const char *criterion)
{
    cycles->verdict = verdict;
    cycles->confidence = confidence;
    snprintf(cycles->criterion, sizeof cycles->criterion, "%s", criterion);
}

static bool strain_exceeded(const struct cycles *cycles)
{
    for (size_t k = 0; k < cycles->n; k++)
        if (fabs(cycles->cycle[k].eps_d) >= collapse_strain)
            return true;
    return false;
}

static void classify(struct cycles *cycles)
{
    double dof = (double)(cycles->last - cycles->first);
    double positive = probability_above(cycles->rate_d, 0, dof), nonzero = fmax(positive, 1 - positive);
    double growing = probability_above(cycles->exponent, 0, dof),
           decaying = 1 - probability_above(cycles->exponent, -1, dof);
    double growth = exp(cycles->exponent.value * log(7.0 / 5)); /* of the rate from the third to the fourth quarter */
    if (strain_exceeded(cycles))
        decide(cycles, VERDICT_COLLAPSE, 1, "the accumulated strain reached 0.1");
    else if (nonzero < two_sigma)
        decide(cycles, VERDICT_SHAKEDOWN, 2 * (1 - nonzero),
               "rate over the second half not distinguishable from 0 at 2 sigma; confidence is its two-sided p-value");
    else if (isnan(cycles->exponent.value))
        decide(cycles, VERDICT_SHAKEDOWN, 0.5, "the rate changes sign within the second half");
    else if (growth > 2 && growing >= two_sigma)
        decide(cycles, VERDICT_COLLAPSE, growing, "the rate grows, and more than doubles within the second half");
    else if (decaying >= two_sigma)
        decide(cycles, VERDICT_SHAKEDOWN, decaying,
               "the rate falls faster than 1/N at 2 sigma: the strain stays bounded");
    else
        decide(cycles, VERDICT_RATCHETING, fmin(nonzero, 1 - decaying),
               "rate over the second half differs from 0 at 2 sigma and does not fall faster than 1/N");
}

static void trends(struct cycles *cycles)
{
    size_t begin = cycles->n / 2, middle = begin + (cycles->n - begin) / 2;
    cycles->first = begin + 1;
    cycles->last = cycles->n;
    cycles->rate_d = cycles->rate_v = cycles->exponent = (struct estimate){NAN, NAN};
    power_law(cycles);
    if (cycles->n < CYCLES_MIN) {
        decide(cycles, VERDICT_UNDETERMINED, NAN, strain_exceeded(cycles) ? "" : "too few cycles to tell");
        if (strain_exceeded(cycles))
            decide(cycles, VERDICT_COLLAPSE, 1, "the accumulated strain reached 0.1");
        return;
    }
    cycles->rate_d = mean_rate(cycles, begin, cycles->n, false);
    cycles->rate_v = mean_rate(cycles, begin, cycles->n, true);
    cycles->exponent = rate_exponent(cycles, begin, middle);
    classify(cycles);
}

enum status cycles_evaluate(struct cycles *cycles, const struct curves *curves)
{
    memset(cycles, 0, sizeof *cycles);
    cycles->confidence = NAN;
    if (curves->controls.kind != TEST_CYCLIC || curves->n < 2)
        return STATUS_OK;
    double last = curves->column[CURVE_STAGE_TIME][curves->n - 1];
    const double finished = floor(last / period_of(curves) + 1e-6);                    /* times are sums of steps */
    cycles->n = finished >= 1 && finished <= (double)curves->n ? (size_t)finished : 0; /* a cycle has samples */
    if (cycles->n == 0)
        return STATUS_OK;
    cycles->cycle = calloc(cycles->n, sizeof *cycles->cycle);
    if (!cycles->cycle)
        return status_fail(STATUS_NO_MEMORY, "out of memory for %zu cycles", cycles->n);
    cycles_measure(cycles, curves);
    trends(cycles);
    return STATUS_OK;
}

void cycles_free(struct cycles *cycles)
{
    free(cycles->cycle);
    memset(cycles, 0, sizeof *cycles);
}

/* Mean of one of the loop's numbers over the second half of the cycles, those without it left out. */
static void loop_quantity(const struct cycles *cycles, size_t offset, struct quantity *quantity)
{
    double sum = 0, squares = 0, count = 0;
    for (size_t k = cycles->first - 1; k < cycles->last; k++) {
        double value = *(const double *)((const char *)&cycles->cycle[k] + offset);
        if (!isfinite(value))
            continue;
        sum += value;
        squares += value * value;
        count++;
    }
    if (count == 0) {
        quantity_undefined(quantity, "fewer than %d samples per cycle, or no strain comes back", CYCLES_LOOP_MIN);
        return;
    }
    double mean = sum / count, variance = count > 1 ? fmax(0, squares / count - mean * mean) / (count - 1) : NAN;
    quantity_set(quantity, (struct estimate){mean, sqrt(variance)});
    quantity_window(quantity, (double)cycles->first, (double)cycles->last);
}

static void rate_quantity(const struct cycles *cycles, struct estimate estimate, size_t first,
                          struct quantity *quantity)
{
    if (isnan(estimate.value)) {
        quantity_undefined(quantity, cycles->n < CYCLES_MIN ? "fewer than %d cycles" : "the sign of the strain changes",
                           CYCLES_MIN);
        return;
    }
    quantity_set(quantity, estimate);
    quantity_window(quantity, (double)first, (double)cycles->last);
}

void cycles_quantities(const struct cycles *cycles, const struct curves *curves, struct quantity *q)
{
    for (int k = 0; k < QUANTITIES; k++)
        if (quantity_belongs((enum quantity_id)k, TEST_CYCLIC) && !quantity_belongs((enum quantity_id)k, TEST_NONE))
            quantity_undefined(&q[k], "%s",
                               curves->controls.kind == TEST_CYCLIC ? "no finished cycle" : "no cyclic stress control");
    if (cycles->n == 0)
        return;
    const struct cycle *last = &cycles->cycle[cycles->n - 1];
    quantity_set(&q[QUANTITY_CYCLES_FIRST], (struct estimate){cycles->cycle[0].eps_d, NAN});
    quantity_window(&q[QUANTITY_CYCLES_FIRST], 1, 1);
    quantity_set(&q[QUANTITY_CYCLES_EPS_D], (struct estimate){last->eps_d, NAN});
    quantity_window(&q[QUANTITY_CYCLES_EPS_D], 1, (double)cycles->n);
    quantity_set(&q[QUANTITY_CYCLES_EPS_V], (struct estimate){last->eps_v, NAN});
    quantity_window(&q[QUANTITY_CYCLES_EPS_V], 1, (double)cycles->n);
    rate_quantity(cycles, cycles->rate_d, cycles->first, &q[QUANTITY_CYCLES_RATE]);
    rate_quantity(cycles, cycles->rate_v, cycles->first, &q[QUANTITY_CYCLES_EPS_V_RATE]);
    rate_quantity(cycles, cycles->exponent, cycles->first, &q[QUANTITY_CYCLES_RATE_EXPONENT]);
    rate_quantity(cycles, cycles->factor, 1, &q[QUANTITY_CYCLES_ACCUMULATION_FACTOR]);
    rate_quantity(cycles, cycles->power, 1, &q[QUANTITY_CYCLES_ACCUMULATION_EXPONENT]);
    loop_quantity(cycles, offsetof(struct cycle, loop_area_j_per_m3), &q[QUANTITY_CYCLES_LOOP_AREA]);
    loop_quantity(cycles, offsetof(struct cycle, resilient_modulus_pa), &q[QUANTITY_CYCLES_RESILIENT_MODULUS]);
    loop_quantity(cycles, offsetof(struct cycle, damping_ratio), &q[QUANTITY_CYCLES_DAMPING_RATIO]);
}

const char *cycles_verdict_name(enum cycles_verdict verdict)
{
    static const char *const names[] = {NULL, "shakedown", "ratcheting", "collapse"};
    return names[verdict];
}

enum status cycles_write_csv(const struct cycles *cycles, const char *path)
{
    FILE *out = fopen(path, "w");
    if (!out)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    fprintf(out, "cycle,eps_d,eps_v,rate_d,rate_v,loop_area_j_per_m3,resilient_modulus_pa,damping_ratio\n");
    for (size_t k = 0; k < cycles->n; k++) {
        const struct cycle *cycle = &cycles->cycle[k];
        fprintf(out, "%zu,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g\n", k + 1, cycle->eps_d, cycle->eps_v,
                cycle->rate_d, cycle->rate_v, cycle->loop_area_j_per_m3, cycle->resilient_modulus_pa,
                cycle->damping_ratio);
    }
    int failed = ferror(out); /* sticky: covers every write above */
    if (fclose(out) != 0 || failed)
        return status_fail(STATUS_IO, "%s: cannot be written: %s", path, strerror(errno));
    return STATUS_OK;
}
