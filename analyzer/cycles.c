#include "analyzer/cycles.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double liquefied = 0.95; /* r_u */

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

/* What a cycle spans, strains without their linear drift in it. */
struct spans {
    struct extent eps_d, eps_c, sigma, q;
};

static void spans_extend(struct spans *spans, const struct vertex *start, const struct vertex *stop,
                         const struct vertex *v)
{
    const double share = (v->t - start->t) / (stop->t - start->t);
    extend(&spans->eps_d, v->eps_d - start->eps_d - (stop->eps_d - start->eps_d) * share);
    extend(&spans->eps_c, v->eps_c - start->eps_c - (stop->eps_c - start->eps_c) * share);
    extend(&spans->sigma, v->sigma_d);
    extend(&spans->q, v->q);
}

static double length(const struct extent *extent)
{
    return extent->highest - extent->lowest;
}

static void moduli_set(struct cycle *cycle, const struct spans *spans, double area)
{
    const double elastic = length(&spans->sigma) * length(&spans->eps_d) / 8;
    cycle->loop_area_j_per_m3 = area;
    cycle->amplitude = length(&spans->eps_d);
    if (elastic > 0)
        cycle->damping_ratio = fabs(area) / (4 * M_PI * elastic);
    if (length(&spans->eps_c) > 0)
        cycle->secant_e_pa = length(&spans->q) / length(&spans->eps_c);
    if (length(&spans->eps_d) > 0)
        cycle->secant_g_pa = length(&spans->q) / (2 * length(&spans->eps_d));
}

/* Area, moduli and damping of one cycle. */
static void loop_measure(const struct curves *curves, double t0, double t1, struct cycle *cycle)
{
    size_t begin, end;
    inner_samples(curves, t0, t1, &begin, &end);
    cycle->loop_area_j_per_m3 = cycle->resilient_modulus_pa = cycle->damping_ratio = NAN;
    cycle->secant_e_pa = cycle->secant_g_pa = cycle->amplitude = NAN;
    if (end < begin + CYCLES_LOOP_MIN)
        return;
    struct vertex start = vertex_at(curves, t0), stop = vertex_at(curves, t1), before = start;
    struct spans spans = {.sigma = {start.sigma_d, start.sigma_d}, .q = {start.q, start.q}};
    double area = 0, eps_c_max = start.eps_c;
    for (size_t k = begin; k <= end; k++) {
        struct vertex v = k < end ? vertex_at(curves, curves->column[CURVE_STAGE_TIME][k]) : stop;
        area += (v.sigma_d + before.sigma_d) / 2 * (v.eps_d - before.eps_d);
        spans_extend(&spans, &start, &stop, &v);
        eps_c_max = fmax(eps_c_max, v.eps_c);
        before = v;
    }
    /* back along the straight line from the end to the start */
    area -= (stop.sigma_d + start.sigma_d) / 2 * (stop.eps_d - start.eps_d);
    moduli_set(cycle, &spans, area);
    if (eps_c_max > stop.eps_c)
        cycle->resilient_modulus_pa = (spans.q.highest - stop.q) / (eps_c_max - stop.eps_c);
}

static void pressure_measure(const struct curves *curves, double t0, double t1, struct cycle *cycle)
{
    const double p0 = curves->column[CURVE_P][0];
    size_t begin, end;
    inner_samples(curves, t0, t1, &begin, &end);
    cycle->r_u = p0 > 0 ? at_time(curves, CURVE_U, t1) / p0 : NAN;
    for (size_t k = begin; k < end && p0 > 0; k++)
        cycle->r_u = fmax(cycle->r_u, curves->column[CURVE_U][k] / p0);
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
        pressure_measure(curves, t0, t1, cycle);
    }
}

/* Over all samples: a test that ends there does so within a cycle. */
static size_t cycles_to_liquefaction(const struct curves *curves)
{
    const double *u = curves->column[CURVE_U], *t = curves->column[CURVE_STAGE_TIME], p0 = curves->column[CURVE_P][0];
    for (size_t k = 0; k < curves->n && p0 > 0; k++)
        if (u[k] >= liquefied * p0)
            return (size_t)fmax(1, ceil(t[k] / period_of(curves) - 1e-6)); /* times are sums of steps */
    return 0;
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
    cycles->to_liquefaction = cycles_to_liquefaction(curves);
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
        quantity_undefined(quantity, "too few cycles, or the sign of the strain changes");
        return;
    }
    quantity_set(quantity, estimate);
    quantity_window(quantity, (double)first, (double)cycles->last);
}

/* CSR = q_cyc/(2 p0), q_cyc half of q from peak to peak, in the first cycle: of stress cycles the same in all of them.
 */
static void stress_ratio(const struct curves *curves, struct quantity *quantity)
{
    const double p0 = curves->column[CURVE_P][0], *q = curves->column[CURVE_Q];
    double low = INFINITY, high = -INFINITY;
    for (size_t k = 0; k < curves->n && curves->column[CURVE_STAGE_TIME][k] <= period_of(curves); k++) {
        low = fmin(low, q[k]);
        high = fmax(high, q[k]);
    }
    quantity_set(quantity, (struct estimate){p0 > 0 ? (high - low) / 2 / (2 * p0) : NAN, NAN});
    quantity_window(quantity, 1, 1);
}

static void pressure_quantities(const struct cycles *cycles, const struct curves *curves, struct quantity *q)
{
    double largest = -INFINITY;
    if (!curves->controls.volume_kept) {
        quantity_undefined(&q[QUANTITY_CYCLES_R_U], "the volume is not kept");
        quantity_undefined(&q[QUANTITY_CYCLES_LIQUEFACTION], "the volume is not kept");
        return;
    }
    for (size_t k = 0; k < curves->n; k++)
        largest = fmax(largest, curves->column[CURVE_U][k] / curves->column[CURVE_P][0]);
    quantity_set(&q[QUANTITY_CYCLES_R_U], (struct estimate){largest, NAN});
    if (cycles->to_liquefaction)
        quantity_set(&q[QUANTITY_CYCLES_LIQUEFACTION], (struct estimate){(double)cycles->to_liquefaction, NAN});
    else
        quantity_undefined(&q[QUANTITY_CYCLES_LIQUEFACTION], "r_u stays below %g", liquefied);
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
    loop_quantity(cycles, offsetof(struct cycle, secant_e_pa), &q[QUANTITY_CYCLES_SECANT_E]);
    loop_quantity(cycles, offsetof(struct cycle, secant_g_pa), &q[QUANTITY_CYCLES_SECANT_G]);
    pressure_quantities(cycles, curves, q);
    stress_ratio(curves, &q[QUANTITY_CYCLES_STRESS_RATIO]);
    loop_quantity(cycles, offsetof(struct cycle, damping_ratio), &q[QUANTITY_CYCLES_DAMPING_RATIO]);
}

enum status cycles_write_csv(const struct cycles *cycles, const char *path)
{
    FILE *out = fopen(path, "w");
    if (!out)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    fprintf(out, "cycle,eps_d,eps_v,rate_d,rate_v,loop_area_j_per_m3,resilient_modulus_pa,damping_ratio,secant_e_pa,"
                 "secant_g_pa,amplitude,r_u\n");
    for (size_t k = 0; k < cycles->n; k++) {
        const struct cycle *cycle = &cycles->cycle[k];
        fprintf(out, "%zu,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g\n", k + 1, cycle->eps_d,
                cycle->eps_v, cycle->rate_d, cycle->rate_v, cycle->loop_area_j_per_m3, cycle->resilient_modulus_pa,
                cycle->damping_ratio, cycle->secant_e_pa, cycle->secant_g_pa, cycle->amplitude, cycle->r_u);
    }
    int failed = ferror(out); /* sticky: covers every write above */
    if (fclose(out) != 0 || failed)
        return status_fail(STATUS_IO, "%s: cannot be written: %s", path, strerror(errno));
    return STATUS_OK;
}
