#include "analyzer/shakedown.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static const double collapse_strain = 0.1;
static const double range_a = 4.5e-5, range_b = 4e-4; /* Werkmeister (2003), strain from cycle 3000 to 5000 */

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

/* Sum of squares of rate - A N^m over cycles [begin, end) with the best A. */
static double misfit(const struct cycles *cycles, size_t begin, double m)
{
    double rp = 0, pp = 0, rr = 0;
    for (size_t k = begin; k < cycles->n; k++) {
        const double rate = cycles->cycle[k].rate_d, power = pow(((double)k + 0.5) / (double)cycles->n, m);
        rp += rate * power;
        pp += power * power;
        rr += rate * rate;
    }
    return rr - rp * rp / pp;
}

/* m of rate = A N^m by least squares of the rates themselves, for rates that scatter through zero; u from where the sum
 * of squares has grown by its variance. */
static struct estimate rate_exponent_scattered(const struct cycles *cycles, size_t begin)
{
    enum { STEPS = 800 };
    static const double low = -5, step = 0.01;
    double sum[STEPS];
    int best = 0, a, b;
    for (int k = 0; k < STEPS; k++) {
        sum[k] = misfit(cycles, begin, low + step * k);
        if (sum[k] < sum[best])
            best = k;
    }
    const double dof = (double)(cycles->n - begin) - 2, level = sum[best] * (1 + 1 / fmax(dof, 1));
    for (a = best; a > 0 && sum[a] < level; a--) {
    }
    for (b = best; b < STEPS - 1 && sum[b] < level; b++) {
    }
    if (a == 0 || b == STEPS - 1)
        return (struct estimate){NAN, NAN};
    return (struct estimate){low + step * best, step * (b - a) / 2 * statistics_widening(fmax(dof, 1))};
}

/* ln |rate| = c + m ln N over the last three quarters of the cycles, from means over bins of equal width in ln N: a
 * mean, unlike the logarithm of each rate, takes rates that scatter. The rates themselves are fitted where bins differ
 * in sign, or where that has the smaller uncertainty. */
static struct estimate rate_exponent(const struct cycles *cycles)
{
    const size_t begin = cycles->n / 4;
    const double low = log((double)begin + 1), width = (log((double)cycles->n + 1) - low) / CYCLES_BINS;
    double x[CYCLES_BINS], y[CYCLES_BINS], w[CYCLES_BINS], sign = 0;
    size_t n = 0, k = begin;
    for (int bin = 0; bin < CYCLES_BINS; bin++) {
        double sum = 0, place = 0, count = 0;
        for (; k < cycles->n && (bin + 1 == CYCLES_BINS || log((double)k + 1) < low + width * (bin + 1)); k++) {
            sum += cycles->cycle[k].rate_d;
            place += log((double)k + 0.5);
            count++;
        }
        if (count == 0)
            continue;
        if (sum == 0 || sum * sign < 0)
            return rate_exponent_scattered(cycles, begin);
        sign = sum;
        x[n] = place / count;
        y[n] = log(fabs(sum / count));
        w[n++] = 1;
    }
    struct points points = {x, w, n};
    const struct estimate scattered = rate_exponent_scattered(cycles, begin);
    struct estimate slope;
    return statistics_slope(&points, y, &slope) && !(slope.error > scattered.error) ? slope : scattered;
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

static void decide(struct cycles *cycles, enum cycles_verdict verdict, double confidence, const char *format, ...)
    PRINTF_LIKE(4, 5);

static void decide(struct cycles *cycles, enum cycles_verdict verdict, double confidence, const char *format, ...)
{
    va_list arguments;
    cycles->verdict = verdict;
    cycles->confidence = confidence;
    va_start(arguments, format);
    vsnprintf(cycles->criterion, sizeof cycles->criterion, format, arguments);
    va_end(arguments);
}

/* P(estimate > bound) by Student's t; certain where there is no scatter at all. */
static double probability_above(struct estimate estimate, double bound, double dof)
{
    double off = estimate.value - bound;
    if (!(estimate.error > 1e-12 * fabs(off)))
        return off > 0 ? 1 : off < 0 ? 0 : 0.5;
    return statistics_student_cdf(off / estimate.error, dof);
}

static bool strain_exceeded(const struct cycles *cycles)
{
    for (size_t k = 0; k < cycles->n; k++)
        if (fabs(cycles->cycle[k].eps_d) >= collapse_strain)
            return true;
    return false;
}

/* Growth of the rate by a factor of 2 or more from the third to the last quarter, at the exponent's lower bound of 0.
 */
static bool grows(const struct cycles *cycles)
{
    return cycles->exponent.value - 2 * cycles->exponent.error > 0 && exp(cycles->exponent.value * log(7.0 / 5)) > 2;
}

static void classify(struct cycles *cycles)
{
    const double dof = (double)(cycles->last - cycles->first), rate = fabs(cycles->rate_d.value);
    const double reach = 2 * cycles->rate_d.error * statistics_widening(dof), bound = cycles->negligible;
    const struct estimate size = {rate, cycles->rate_d.error}, m = cycles->exponent;
    const double above = probability_above(size, bound, dof), slow = probability_above(m, -1, CYCLES_BINS - 2);
    if (grows(cycles))
        decide(cycles, VERDICT_COLLAPSE, probability_above(m, 0, CYCLES_BINS - 2),
               "the rate grows, and more than doubles within the second half");
    else if (rate + reach <= bound)
        decide(cycles, VERDICT_SHAKEDOWN, 1 - above,
               "the rate is below %.2g per cycle, which has no practical meaning beside the cycle's amplitude", bound);
    else if (m.value + 2 * m.error < -1)
        decide(cycles, VERDICT_SHAKEDOWN, 1 - slow,
               "the rate falls as N^(%.3g +- %.1g), faster than 1/N: the strain stays bounded", m.value, m.error);
    else if (rate - reach > bound && m.value - 2 * m.error > -1)
        decide(cycles, VERDICT_RATCHETING, fmin(above, slow),
               "the rate is above %.2g per cycle and falls as N^(%.3g +- %.1g), not faster than 1/N", bound, m.value,
               m.error);
    else if (!(rate - reach > bound))
        decide(cycles, VERDICT_UNDETERMINED, NAN,
               "the rate's uncertainty reaches across %.2g per cycle: more cycles are needed", bound);
    else
        decide(cycles, VERDICT_UNDETERMINED, NAN,
               "whether the rate falls faster than 1/N is open: more cycles are needed");
}

/* Axial strain at the end of a cycle, counted from 1. */
static double axial_strain(const struct curves *curves, size_t cycle)
{
    const double t = curves->controls.period_s * (double)cycle;
    const size_t k = statistics_lower_bound(curves->column[CURVE_STAGE_TIME], curves->n, t * (1 - 1e-9));
    return curves->column[CURVE_EPS_ZZ_LOG][k < curves->n ? k : curves->n - 1];
}

static char range_of(double gain)
{
    return gain < range_a ? 'A' : gain <= range_b ? 'B' : 'C';
}

/* Gain of a N^b from 3000 to 5000, b at one end of its uncertainty and the strain at the last cycle kept. */
static double extrapolated(const struct cycles *cycles, double strain, double power)
{
    const double n = (double)cycles->n;
    return fabs(strain) * (pow(5000 / n, power) - pow(3000 / n, power));
}

static void werkmeister(struct cycles *cycles, const struct curves *curves)
{
    enum { FROM = 3000, TO = 5000 };
    char *text = cycles->range_criterion;
    const size_t size = sizeof cycles->range_criterion;
    cycles->range = '?';
    if (cycles->n >= TO) {
        const double gain = fabs(axial_strain(curves, TO) - axial_strain(curves, FROM));
        cycles->range = range_of(gain);
        snprintf(text, size, "%.3g of axial strain from cycle 3000 to 5000", gain);
        return;
    }
    if (cycles->n < CYCLES_MIN || isnan(cycles->power.value) || isnan(cycles->power.error)) {
        snprintf(text, size, "fewer than 5000 cycles, and no power law to go on with");
        return;
    }
    const double strain = axial_strain(curves, cycles->n), u = 2 * cycles->power.error;
    const double low = extrapolated(cycles, strain, cycles->power.value - u);
    const double high = extrapolated(cycles, strain, cycles->power.value + u);
    if (range_of(low) == range_of(high))
        cycles->range = range_of(high);
    snprintf(text, size, "%.3g to %.3g of axial strain from cycle 3000 to 5000, extrapolated with N^(%.3g +- %.1g)",
             low, high, cycles->power.value, cycles->power.error);
}

static double mean_amplitude(const struct cycles *cycles)
{
    double sum = 0, count = 0;
    for (size_t k = 0; k < cycles->n; k++)
        if (isfinite(cycles->cycle[k].amplitude)) {
            sum += cycles->cycle[k].amplitude;
            count++;
        }
    return count > 0 ? sum / count : 0;
}

void shakedown_classify(struct cycles *cycles, const struct curves *curves, double negligible)
{
    const size_t begin = cycles->n / 2;
    cycles->first = begin + 1;
    cycles->last = cycles->n;
    cycles->rate_d = cycles->rate_v = cycles->exponent = (struct estimate){NAN, NAN};
    cycles->factor = cycles->power = (struct estimate){NAN, NAN};
    cycles->negligible = negligible * mean_amplitude(cycles);
    cycles->range = '?';
    decide(cycles, VERDICT_UNDETERMINED, NAN, "no finished cycle");
    if (cycles->n == 0)
        return;
    power_law(cycles);
    werkmeister(cycles, curves);
    if (cycles->n >= CYCLES_MIN) {
        cycles->rate_d = mean_rate(cycles, begin, cycles->n, false);
        cycles->rate_v = mean_rate(cycles, begin, cycles->n, true);
        cycles->exponent = rate_exponent(cycles);
    }
    if (strain_exceeded(cycles))
        decide(cycles, VERDICT_COLLAPSE, 1, "the accumulated strain reached %g", collapse_strain);
    else if (cycles->n < CYCLES_MIN)
        decide(cycles, VERDICT_UNDETERMINED, NAN, "fewer than %d cycles", (int)CYCLES_MIN);
    else
        classify(cycles);
}

const char *shakedown_verdict_name(enum cycles_verdict verdict)
{
    static const char *const names[] = {"undetermined", "shakedown", "ratcheting", "collapse"};
    return names[verdict];
}
