/* Cyclic loading against closed forms (test_analyzer_fixture.h). */
#include "test_analyzer_fixture.h"

#include <math.h>
#include <string.h>

#include "analyzer/shakedown.h"

enum { PER_CYCLE = 64 };
static const double amplitude = 200, strain = 1e-3, lateral = 1.3; /* eps_D = 1.3 eps_x */

struct accumulation {
    double a, b;
    double *values; /* per cycle, for random ones */
};

static double none(double x, const void *context)
{
    (void)x, (void)context;
    return 0;
}

static double power(double x, const void *context)
{
    const struct accumulation *law = context;
    return law->a * pow(x, law->b);
}

static double saturating(double x, const void *context)
{
    const struct accumulation *law = context;
    return law->a * (1 - exp(-x / law->b));
}

static double growing(double x, const void *context)
{
    const struct accumulation *law = context;
    return law->a * expm1(x / law->b);
}

static double listed(double x, const void *context)
{
    const struct accumulation *law = context;
    size_t k = (size_t)x;
    double share = x - (double)k;
    return (k ? law->values[k - 1] : 0) * (1 - share) + law->values[k] * share;
}

static void evaluate(const struct cyclic_model *model, struct cycles *cycles, struct quantity *q)
{
    struct run run;
    struct curves curves;
    fixture_cyclic(&run, model);
    assert_int_equal(curves_extract(&curves, &run), STATUS_OK);
    assert_int_equal(cycles_evaluate(cycles, &curves), STATUS_OK);
    shakedown_classify(cycles, &curves, 1e-4);
    cycles_quantities(cycles, &curves, q);
    curves_free(&curves);
    run_free(&run);
}

/* The ellipse sampled at m points is a polygon of area sin(2 pi/m)/(2 pi/m) times the ellipse's pi (A/3)(1.3 e/2) sin
 * delta (semi-axes of sigma_D and eps_D). The largest strain, e/2 (1 + cos delta) above the end of the cycle, falls on
 * a sample. Exact up to the rounding of 1 - L/L0, 1e-16 of 1e-3: 1e-12, so 1e-10. */
static void loop(void **state)
{
    (void)state;
    struct cycles cycles;
    struct quantity q[QUANTITIES];
    double delta = 2 * M_PI * 4 / 64, polygon = sin(2 * M_PI / PER_CYCLE) / (2 * M_PI / PER_CYCLE);
    evaluate(&(struct cyclic_model){12, PER_CYCLE, none, NULL}, &cycles, q);
    double area = polygon * M_PI * amplitude / 3 * lateral * strain / 2 * sin(delta);
    assert_int_equal(cycles.n, 12);
    for (size_t k = 0; k < cycles.n; k++) {
        assert_near(cycles.cycle[k].loop_area_j_per_m3, area, 1e-10 * area);
        assert_near(cycles.cycle[k].damping_ratio, polygon * sin(delta) / 2, 1e-10);
        double modulus = amplitude / (strain / 2 * (1 + cos(delta)));
        assert_near(cycles.cycle[k].resilient_modulus_pa, modulus, 1e-10 * modulus);
        /* peaks of the ellipse fall on samples: 200 Pa over e, and over 2 x 1.3 e */
        assert_near(cycles.cycle[k].secant_e_pa, amplitude / strain, 1e-10 * amplitude / strain);
        assert_near(cycles.cycle[k].secant_g_pa, amplitude / strain / 2.6, 1e-10 * amplitude / strain);
        assert_near(cycles.cycle[k].amplitude, lateral * strain, 1e-10 * strain);
    }
    assert_near(q[QUANTITY_CYCLES_LOOP_AREA].value, area, 1e-10 * area);
    assert_int_equal(cycles.verdict, VERDICT_SHAKEDOWN);
    cycles_free(&cycles);
}

/* A drift of d per cycle, linear in time, adds the work of the mean stress above the ends, (A/3) d; the damping ratio's
 * elastic energy does not see it. */
static void loop_with_drift(void **state)
{
    (void)state;
    struct cycles cycles;
    struct quantity q[QUANTITIES];
    struct accumulation law = {.a = 2e-5, .b = 1};
    double delta = 2 * M_PI * 4 / 64, polygon = sin(2 * M_PI / PER_CYCLE) / (2 * M_PI / PER_CYCLE);
    double area = polygon * M_PI * amplitude / 3 * lateral * strain / 2 * sin(delta) + amplitude / 3 * lateral * law.a;
    double elastic = 2 * amplitude / 3 * lateral * strain / 8;
    evaluate(&(struct cyclic_model){12, PER_CYCLE, power, &law}, &cycles, q);
    assert_near(cycles.cycle[7].loop_area_j_per_m3, area, 1e-10 * area);
    assert_near(cycles.cycle[7].damping_ratio, area / (4 * M_PI * elastic), 1e-10);
    assert_near(q[QUANTITY_CYCLES_RATE].value, lateral * law.a, 1e-12 * lateral);
    assert_near(q[QUANTITY_CYCLES_FIRST].value, lateral * law.a, 1e-12 * lateral);
    /* eps_v = (1 - 0.6) eps_x */
    assert_near(q[QUANTITY_CYCLES_EPS_V].value, 0.4 * 12 * law.a, 1e-12);
    assert_near(q[QUANTITY_CYCLES_RATE_EXPONENT].value, 0, 1e-8);
    assert_int_equal(cycles.verdict, VERDICT_RATCHETING);
    assert_true(cycles.confidence > 0.99);
    cycles_free(&cycles);
}

/* A deviator that is there all the time is no loss: a loop that drifts is closed along a straight line. */
static void loop_on_a_deviator(void **state)
{
    (void)state;
    struct accumulation law = {.a = 2e-5, .b = 1};
    double area[2];
    for (int k = 0; k < 2; k++) {
        struct run run;
        struct curves curves;
        struct cycles cycles;
        fixture_cyclic(&run, &(struct cyclic_model){12, PER_CYCLE, power, &law});
        assert_int_equal(curves_extract(&curves, &run), STATUS_OK);
        for (size_t n = 0; n < curves.n; n++)
            curves.column[CURVE_SIGMA_D][n] += k * amplitude;
        assert_int_equal(cycles_evaluate(&cycles, &curves), STATUS_OK);
        area[k] = cycles.cycle[7].loop_area_j_per_m3;
        cycles_free(&cycles);
        curves_free(&curves);
        run_free(&run);
    }
    /* two sums of 64 terms of the order of the area, and the amplitude times strains that are known to 1e-16 */
    assert_near(area[1], area[0], 1e-12 * area[0] + 64 * amplitude * 1e-16);
}

/* Water that takes a tenth of the pressure in each cycle: so r_u at its end, and liquefied (0.95) in the tenth. */
static void pressure_of_the_water(void **state)
{
    (void)state;
    struct run run;
    struct curves curves;
    struct cycles cycles;
    fixture_cyclic(&run, &(struct cyclic_model){12, PER_CYCLE, none, NULL});
    assert_int_equal(curves_extract(&curves, &run), STATUS_OK);
    const double p0 = curves.column[CURVE_P][0] = 500;
    for (size_t n = 0; n < curves.n; n++)
        curves.column[CURVE_U][n] = 0.1 * p0 * curves.column[CURVE_STAGE_TIME][n] / curves.controls.period_s;
    assert_int_equal(cycles_evaluate(&cycles, &curves), STATUS_OK);
    for (size_t k = 0; k < cycles.n; k++)
        assert_near(cycles.cycle[k].r_u, 0.1 * (double)(k + 1), 1e-12); /* times are sums of at most 768 steps */
    assert_int_equal(cycles.to_liquefaction, 10);
    cycles_free(&cycles);
    curves_free(&curves);
    run_free(&run);
}

/* a N^b at the ends of the cycles is a straight line in double logarithm: recovered to rounding, 1e-16/1e-4 = 1e-12
 * times the slope's condition, 1e-9. The rate falls as N^(b-1), slower than 1/N: ratcheting. */
static void accumulation_power_law(void **state)
{
    (void)state;
    struct cycles cycles;
    struct quantity q[QUANTITIES];
    struct accumulation law = {.a = 1e-4, .b = 0.5};
    evaluate(&(struct cyclic_model){100, PER_CYCLE, power, &law}, &cycles, q);
    for (size_t k = 0; k < 100; k++)
        assert_near(cycles.cycle[k].eps_d, lateral * law.a * sqrt((double)k + 1), 1e-13);
    assert_near(q[QUANTITY_CYCLES_ACCUMULATION_EXPONENT].value, 0.5, 1e-9);
    assert_near(q[QUANTITY_CYCLES_ACCUMULATION_FACTOR].value, lateral * law.a, 1e-9 * lateral);
    /* gains fall as N^(-1/2), of which bins of a few cycles miss (1/N)^2/24 at N = 25 */
    assert_near(q[QUANTITY_CYCLES_RATE_EXPONENT].value, -0.5, 1e-3);
    /* axial strain 1e-4 (sqrt(5000) - sqrt(3000)) = 1.6e-3: range C */
    assert_int_equal(cycles.range, 'C');
    assert_int_equal(cycles.verdict, VERDICT_RATCHETING);
    cycles_free(&cycles);
}

static enum cycles_verdict verdict_of(double (*accumulated)(double, const void *), const struct accumulation *law,
                                      size_t n)
{
    struct cycles cycles;
    struct quantity q[QUANTITIES];
    evaluate(&(struct cyclic_model){n, 16, accumulated, law}, &cycles, q);
    enum cycles_verdict verdict = cycles.verdict;
    assert_true(verdict == VERDICT_UNDETERMINED ? isnan(cycles.confidence)
                                                : cycles.confidence >= 0 && cycles.confidence <= 1);
    cycles_free(&cycles);
    return verdict;
}

/* saturating: rate ~ exp(-N/5), 40 cycles. growing: x 1.4 per cycle at first. */
static void verdicts(void **state)
{
    (void)state;
    assert_int_equal(verdict_of(saturating, &(struct accumulation){.a = 1e-3, .b = 5}, 40), VERDICT_SHAKEDOWN);
    assert_int_equal(verdict_of(power, &(struct accumulation){.a = -1e-5, .b = 1}, 40), VERDICT_RATCHETING);
    assert_int_equal(verdict_of(growing, &(struct accumulation){.a = 1e-6, .b = 4}, 24), VERDICT_COLLAPSE);
    assert_int_equal(verdict_of(power, &(struct accumulation){.a = 5e-3, .b = 1}, 40), VERDICT_COLLAPSE);
    assert_int_equal(verdict_of(power, &(struct accumulation){.a = 1e-5, .b = 1}, 7), VERDICT_UNDETERMINED);
}

/* A random walk without drift, independent gains, 20 of them in the second half: whether the rate is above 1.3e-7
 * cannot be told, and is not. P(|t| > its 2-sigma point) = 4.55 %; 300 draws scatter by 1.2 %: at most 0.0455 + 3 x
 * 0.012 = 0.082 may be called ratcheting. With a drift of 1.5 s.d. per cycle (t of 6.7) the rate is told, its exponent
 * to about 0.3: almost never shakedown, ratcheting in most draws, else undetermined. */
static void verdicts_of_noise(void **state)
{
    (void)state;
    enum { CYCLES = 40, DRAWS = 300 };
    struct random random = {5};
    for (int drifting = 0; drifting < 2; drifting++) {
        double values[CYCLES + 1], share[4] = {0};
        for (int draw = 0; draw < DRAWS; draw++) {
            double sum = 0;
            for (int k = 0; k <= CYCLES; k++)
                values[k] = sum += 1e-5 * (random_normal(&random) + 1.5 * drifting);
            share[verdict_of(listed, &(struct accumulation){.values = values}, CYCLES)] += 1.0 / DRAWS;
        }
        print_message("  drift %d: undetermined %.3f, shakedown %.3f, ratcheting %.3f, collapse %.3f\n", drifting,
                      share[0], share[1], share[2], share[3]);
        if (drifting)
            assert_true(share[VERDICT_SHAKEDOWN] <= 0.02 && share[VERDICT_RATCHETING] > 0.6);
        else
            assert_true(share[VERDICT_UNDETERMINED] >= 1 - 0.082);
    }
}

/* Gains of 1e-8 per cycle beside 1.3e-3 of amplitude have no practical meaning, however exactly they are known. Gains
 * that fall as N^-1.87 with 3 % of noise stay bounded. */
static void practical_meaning(void **state)
{
    (void)state;
    enum { CYCLES = 200 };
    struct random random = {6};
    double values[CYCLES + 1], sum = 0;
    assert_int_equal(verdict_of(power, &(struct accumulation){.a = 1e-8, .b = 1}, 40), VERDICT_SHAKEDOWN);
    assert_int_equal(verdict_of(power, &(struct accumulation){.a = 1e-6, .b = 1}, 40), VERDICT_RATCHETING);
    for (int k = 0; k <= CYCLES; k++)
        values[k] = sum += 5e-3 * pow(k + 1, -1.87) * (1 + 0.03 * random_normal(&random));
    struct cycles cycles;
    struct quantity q[QUANTITIES];
    evaluate(&(struct cyclic_model){CYCLES, 16, listed, &(struct accumulation){.values = values}}, &cycles, q);
    assert_int_equal(cycles.verdict, VERDICT_SHAKEDOWN);
    assert_near(cycles.exponent.value, -1.87, 2 * cycles.exponent.error);
    assert_true(cycles.exponent.error < 0.1);
    cycles_free(&cycles);
}

/* 5 samples per cycle: no loops, but the accumulation is there. Less than a cycle: nothing. */
static void sparse(void **state)
{
    (void)state;
    struct cycles cycles;
    struct quantity q[QUANTITIES];
    struct accumulation law = {.a = 1e-5, .b = 1};
    evaluate(&(struct cyclic_model){20, 5, power, &law}, &cycles, q);
    assert_true(isnan(q[QUANTITY_CYCLES_LOOP_AREA].value));
    assert_non_null(strstr(q[QUANTITY_CYCLES_LOOP_AREA].text, "samples per cycle"));
    assert_near(q[QUANTITY_CYCLES_EPS_D].value, 20 * lateral * law.a, 1e-12);
    cycles_free(&cycles);
    evaluate(&(struct cyclic_model){0, 64, none, NULL}, &cycles, q);
    assert_int_equal(cycles.n, 0);
    assert_string_equal(q[QUANTITY_CYCLES_RATE].text, "no finished cycle");
    cycles_free(&cycles);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loop),
        cmocka_unit_test(loop_with_drift),
        cmocka_unit_test(loop_on_a_deviator),
        cmocka_unit_test(pressure_of_the_water),
        cmocka_unit_test(accumulation_power_law),
        cmocka_unit_test(verdicts),
        cmocka_unit_test(verdicts_of_noise),
        cmocka_unit_test(practical_meaning),
        cmocka_unit_test(sparse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
