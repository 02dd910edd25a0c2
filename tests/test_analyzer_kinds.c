/* Every kind of test: what the controls did is found, and what is evaluated is the closed form's. */
#include "test_analyzer_fixture.h"

#include <math.h>
#include <string.h>

#include "analyzer/compression.h"
#include "analyzer/creep_relaxation.h"
#include "analyzer/cycles.h"
#include "analyzer/shakedown.h"
#include "analyzer/shear_strength.h"
#include "analyzer/stage_controls.h"
#include "analyzer/undrained.h"

#define SAMPLE                                                                                                         \
    "name = \"kinds\"; dimension = 3; sample = { count = 8; radius_min_m = 1e-3; radius_max_m = 1e-3; "                \
    "density_kg_per_m3 = 2000.0; };\nmaterial = { kn_n_per_m = 1e5; };\n"
#define STRESS(p) "{ mode = \"stress\"; pressure_pa = " p "; mass_kg = 1.0; }"
#define RAMP                                                                                                           \
    "{ mode = \"stress\"; target = \"ramp\"; pressure_pa = 100.0; pressure_end_pa = 900.0; ramp_s = 1.0; mass_kg = "   \
    "1.0; }"
#define STRAIN(e) "{ mode = \"strain\"; strain = " e "; frequency_hz = 1.0; }"
#define PATH      "{ mode = \"coupled\"; keep = \"path\"; dq_dp = 1.5; pressure_pa = 100.0; mass_kg = 1.0; }"
#define Q_RAMP                                                                                                         \
    "{ mode = \"coupled\"; keep = \"q\"; target = \"ramp\"; pressure_pa = 0.0; pressure_end_pa = 200.0; ramp_s = "     \
    "1.0; "                                                                                                            \
    "mass_kg = 1.0; }"
#define FIXED "{ mode = \"fixed\"; }"
#define STAGE(x, y, z)                                                                                                 \
    SAMPLE "stages = ( { name = \"s\"; dt_s = 1e-3; duration_s = 1.0; walls = { x = " x "; y = " y "; z = " z          \
           "; }; } );\n"

enum { N = 401 };

static void record(struct run *run, size_t i, const double strain_log[3], const double stress[3])
{
    run->time_s[i] = (double)i / (N - 1);
    fixture_set(run, OBSERVABLE_STAGE_TIME, i, 0, run->time_s[i]);
    double volume = 0;
    for (size_t k = 0; k < 3; k++) {
        volume += strain_log[k];
        fixture_set(run, OBSERVABLE_BOX_LENGTH, i, k, 0.1 * exp(-strain_log[k]));
        fixture_set(run, OBSERVABLE_STRESS_WALL, i, k, stress[k]);
    }
    fixture_set(run, OBSERVABLE_SOLID_FRACTION, i, 0, 0.6 * exp(volume));
}

static struct stage_controls controls_of(const struct run *run)
{
    struct stage_controls controls;
    stage_controls_find(&controls, run, 0, 0, run->n_samples);
    return controls;
}

/* The kind follows from the configuration, and from the record where that says more. */
static void kinds(void **state)
{
    static const struct {
        const char *config;
        double strain[3], stress[3]; /* at the end; 100 Pa on all axes and no strain at the start */
        enum test_kind kind;
        const char *name;
    } cases[] = {
        {STAGE(RAMP, RAMP, RAMP), {.01, .01, .01}, {900, 900, 900}, TEST_ISOTROPIC, "isotropic compression"},
        {STAGE(STRAIN("0.01"), STRAIN("0.01"), STRAIN("0.01")),
         {.01, .01, .01},
         {900, 900, 900},
         TEST_ISOTROPIC,
         "isotropic compression"},
        {STAGE(FIXED, FIXED, STRAIN("0.01")), {0, 0, .01}, {400, 400, 900}, TEST_OEDOMETER, "oedometer"},
        {STAGE(FIXED, FIXED, RAMP), {0, 0, .01}, {400, 400, 900}, TEST_OEDOMETER, "oedometer"},
        {STAGE(STRESS("100.0"), STRESS("100.0"), STRAIN("0.02")),
         {-.006, -.006, .02},
         {100, 100, 300},
         TEST_SHEAR,
         "drained triaxial compression"},
        {STAGE(STRESS("100.0"), STRESS("100.0"), STRAIN("-0.02")),
         {.006, .006, -.02},
         {100, 100, 40},
         TEST_SHEAR,
         "drained triaxial extension"},
        {STAGE(STRESS("100.0"), STRESS("100.0"), RAMP),
         {-.006, -.006, .02},
         {100, 100, 900},
         TEST_SHEAR,
         "drained triaxial compression"},
        {STAGE(STRAIN("-0.01"), STRAIN("-0.01"), STRAIN("0.02")),
         {-.01, -.01, .02},
         {100, 100, 300},
         TEST_CONSTANT_VOLUME,
         "compression at constant volume"},
        {STAGE(RAMP, RAMP, STRAIN("0.02")),
         {-.006, -.006, .02},
         {60, 60, 180},
         TEST_SHEAR,
         "compression at constant p"},
        {STAGE(PATH, PATH, Q_RAMP),
         {-.002, -.002, .01},
         {500. / 3, 500. / 3, 1100. / 3},
         TEST_SHEAR,
         "compression on a stress path"},
        {STAGE(STRESS("100.0"), STRESS("100.0"), STRESS("100.0")),
         {.001, .001, .001},
         {100, 100, 100},
         TEST_CREEP,
         "creep"},
        {STAGE(STRESS("100.0"), STRESS("100.0"), STRESS("200.0")),
         {-.001, -.001, .002},
         {100, 100, 200},
         TEST_CREEP,
         "creep"},
        {STAGE(FIXED, FIXED, FIXED), {0, 0, 0}, {90, 90, 90}, TEST_RELAXATION, "relaxation"},
    };
    (void)state;
    const size_t n = sizeof cases / sizeof cases[0];
    for (size_t k = 0; k < 2 * n; k++) {
        const bool own = k >= n; /* a controller of the user's own, in a scene whose walls rest: the record tells */
        const size_t c = k % n;
        struct run run;
        if (own && cases[c].kind == TEST_CREEP && cases[c].stress[2] > 150)
            continue; /* that z is held at 200 Pa the configuration alone tells */
        fixture_run(&run, own ? STAGE(FIXED, FIXED, FIXED) : cases[c].config, N);
        snprintf(run.controller, sizeof run.controller, "%s", own ? "./mine" : "");
        for (size_t i = 0; i < N; i++) {
            const double share = (double)i / (N - 1);
            double strain[3], stress[3];
            for (int k = 0; k < 3; k++) {
                strain[k] = share * cases[c].strain[k];
                stress[k] = 100 + share * (cases[c].stress[k] - 100);
            }
            record(&run, i, strain, stress);
        }
        const struct stage_controls controls = controls_of(&run);
        if (controls.kind != cases[c].kind || strcmp(stage_controls_name(&controls, 3), cases[c].name) != 0)
            fail_msg("case %zu%s: kind %d, \"%s\"", c, own ? ", own controller" : "", (int)controls.kind,
                     stage_controls_name(&controls, 3));
        run_free(&run);
    }
}

static void extracted(const struct run *run, struct curves *curves, struct quantity *q)
{
    assert_int_equal(curves_extract(curves, run), STATUS_OK);
    for (int k = 0; k < QUANTITIES; k++)
        quantity_undefined(&q[k], "not made");
}

/* Up and down again: strain rises over the first half of the record, and falls to half of it over the second. */
static double there_and_back(size_t i)
{
    const size_t half = (N - 1) / 2;
    return i <= half ? (double)i / (double)half : 1 - 0.5 * (double)(i - half) / (double)half;
}

/* p = 100 + K eps_v with K = 2e5 in loading; unloading with 5e5 from the top: straight lines, so that secants and
 * tangents are K up to rounding. Void ratio from the solid fraction 0.6 e^eps_v. */
static void isotropic(void **state)
{
    struct quantity q[QUANTITIES];
    struct curves curves;
    struct run run;
    (void)state;
    fixture_run(&run, STAGE(RAMP, RAMP, RAMP), N);
    for (size_t i = 0; i < N; i++) {
        const double share = there_and_back(i);
        const double volume = i <= (N - 1) / 2 ? 4e-3 * share : 4e-3 - (1 - share) * 2e-3;
        const double p = i <= (N - 1) / 2 ? 100 + 2e5 * volume : 900 - 5e5 * (4e-3 - volume);
        record(&run, i, (const double[]){volume / 3, volume / 3, volume / 3}, (const double[]){p, p, p});
    }
    extracted(&run, &curves, q);
    assert_int_equal(curves.controls.kind, TEST_ISOTROPIC);
    assert_int_equal(compression_evaluate(&curves, q), STATUS_OK);
    assert_near(q[QUANTITY_K_LOADING].value, 2e5, 2e5 * 1e-8);
    assert_near(q[QUANTITY_K_TANGENT].value, 2e5, 2e5 * 1e-8);
    assert_near(q[QUANTITY_K_UNLOADING].value, 5e5, 5e5 * 1e-8);
    /* solid fraction at p = 0 on the unloading: eps_v = 4e-3 - 900/5e5; the curve is an exponential of 1e-3, which
     * polynomials of degree 2 miss by (900/5e5)^3/6 = 1e-9 */
    assert_near(q[QUANTITY_JAMMING_FRACTION].value, 0.6 * exp(4e-3 - 900 / 5e5), 1e-8);
    curves_free(&curves);
    run_free(&run);
}

/* Strains are those of lengths and of the volume at any strain, to rounding: axially a quarter shorter, wider by 1.1
 * and 1.2. The sum of axial strains would be -0.05; the volume is 0.99 of what it was. */
static void strains_of_the_box(void **state)
{
    struct quantity q[QUANTITIES];
    struct curves curves;
    struct run run;
    (void)state;
    fixture_run(&run, STAGE(STRESS("100.0"), STRESS("100.0"), STRAIN("0.25")), N);
    for (size_t i = 0; i < N; i++) {
        const double share = (double)i / (N - 1), sigma = 100 + 200 * share;
        record(&run, i, (const double[]){-log(1 + 0.1 * share), -log(1 + 0.2 * share), -log(1 - 0.25 * share)},
               (const double[]){100, 100, sigma});
    }
    extracted(&run, &curves, q);
    for (size_t i = 0; i < N; i += N - 1) {
        const double share = (double)i / (N - 1), z = 1 - 0.25 * share, x = 1 + 0.1 * share, y = 1 + 0.2 * share;
        const double lateral = 1 - 0.5 * (x + y), rounding = 1e-14;
        assert_near(curves.column[CURVE_EPS_ZZ][i], 1 - z, rounding);
        assert_near(curves.column[CURVE_EPS_XX][i], lateral, rounding);
        assert_near(curves.column[CURVE_EPS_V][i], 1 - x * y * z, rounding);
        assert_near(curves.column[CURVE_EPS_D][i], 1 - z - lateral, rounding);
        assert_near(curves.column[CURVE_EPS_ZZ_LOG][i], -log(z), rounding);
        assert_near(curves.column[CURVE_EPS_XX_LOG][i], -0.5 * log(x * y), rounding);
        assert_near(curves.column[CURVE_EPS_V_LOG][i], -log(x * y * z), rounding);
    }
    curves_free(&curves);
    run_free(&run);
}

/* e = e1 - Cc log10(p/100) with Cc = 0.3 in loading, Cs = 0.05 in unloading: recovered to rounding. */
static void indices(void **state)
{
    struct quantity q[QUANTITIES];
    struct curves curves;
    struct run run;
    (void)state;
    fixture_run(&run, STAGE(RAMP, RAMP, RAMP), N);
    for (size_t i = 0; i < N; i++) {
        const double share = there_and_back(i), p = 100 * pow(9, share);
        const double top = 0.7 - 0.3 * log10(9);
        const double e = i <= (N - 1) / 2 ? 0.7 - 0.3 * log10(p / 100) : top - 0.05 * log10(p / 900);
        const double volume = -log((1 + e) / 1.7);
        record(&run, i, (const double[]){volume / 3, volume / 3, volume / 3}, (const double[]){p, p, p});
        fixture_set(&run, OBSERVABLE_SOLID_FRACTION, i, 0, 1 / (1 + e));
    }
    extracted(&run, &curves, q);
    assert_int_equal(compression_evaluate(&curves, q), STATUS_OK);
    assert_near(q[QUANTITY_CC].value, 0.3, 1e-10);
    assert_near(q[QUANTITY_CS].value, 0.05, 1e-10);
    curves_free(&curves);
    run_free(&run);
}

/* M = 1e5 in loading from 100 Pa, 4e5 in unloading; sigma_xx = 0.4 sigma_zz, then held back: 360 - 0.2 (900 -
 * sigma_zz). K0 in unloading is a mean over the last tenth of it, from 289/545 = 0.530 to 280/500 = 0.560. No angle of
 * dilatancy. */
static void oedometer(void **state)
{
    struct quantity q[QUANTITIES];
    struct curves curves;
    struct run run;
    (void)state;
    fixture_run(&run, STAGE(FIXED, FIXED, RAMP), N);
    for (size_t i = 0; i < N; i++) {
        const double share = there_and_back(i);
        const double eps = i <= (N - 1) / 2 ? 8e-3 * share : 8e-3 - (1 - share) * 2e-3;
        const double zz = i <= (N - 1) / 2 ? 100 + 1e5 * eps : 900 - 4e5 * (8e-3 - eps);
        const double xx = i <= (N - 1) / 2 ? 0.4 * zz : 360 - 0.2 * (900 - zz);
        record(&run, i, (const double[]){0, 0, eps}, (const double[]){xx, xx, zz});
    }
    extracted(&run, &curves, q);
    assert_int_equal(curves.controls.kind, TEST_OEDOMETER);
    assert_int_equal(compression_evaluate(&curves, q), STATUS_OK);
    assert_near(q[QUANTITY_M_LOADING].value, 1e5, 1e5 * 1e-8);
    assert_near(q[QUANTITY_M_UNLOADING].value, 4e5, 4e5 * 1e-8);
    assert_near(q[QUANTITY_K0_LOADING].value, 0.4, 1e-12);
    assert_near(q[QUANTITY_K0_UNLOADING].value, 0.545, 0.016);
    assert_false(quantity_belongs(QUANTITY_DILATANCY_ANGLE, TEST_OEDOMETER));
    curves_free(&curves);
    run_free(&run);
}

/* Extension at a lateral 100 Pa: sigma_zz falls by E |eps|, E = 2000; nu = 0.2, so -d eps_v/d|eps| = 1 - 2 nu = 0.6 and
 * sin psi = 0.6/(2 - 0.6). The larger stress is the lateral one. */
static void extension(void **state)
{
    struct quantity q[QUANTITIES];
    struct stiffness stiffness;
    struct curves curves;
    struct run run;
    (void)state;
    fixture_run(&run, STAGE(STRESS("100.0"), STRESS("100.0"), STRAIN("-0.02")), N);
    run.scene->analysis.strain = STRAIN_LOGARITHMIC;
    for (size_t i = 0; i < N; i++) {
        const double eps = -0.02 * (double)i / (N - 1);
        record(&run, i, (const double[]){-0.2 * eps, -0.2 * eps, eps}, (const double[]){100, 100, 100 + 2000 * eps});
    }
    extracted(&run, &curves, q);
    assert_true(curves.controls.extension);
    assert_int_equal(shear_strength_evaluate(&curves, run.scene, q, &stiffness), STATUS_OK);
    assert_near(q[QUANTITY_E_INITIAL].value, 2000, 2000 * 1e-8);
    assert_near(q[QUANTITY_NU].value, 0.2, 1e-8);
    assert_near(q[QUANTITY_DILATANCY_SLOPE].value, 0.6, 1e-9);
    assert_near(q[QUANTITY_DILATANCY_ANGLE].value, asin(0.6 / 1.4) * 180 / M_PI, 1e-7);
    assert_near(q[QUANTITY_PEAK_STRESS_RATIO].value, 100.0 / 60, 1e-6);
    assert_near(q[QUANTITY_PEAK_EPS_ZZ].value, -0.02, 1e-12);
    assert_non_null(strstr(q[QUANTITY_PEAK_STRESS_RATIO].text, "still rises"));
    curves_free(&curves);
    run_free(&run);
}

/* Compression that starts at a deviator of 50 Pa: secants begin there. */
static void secant_from_a_deviator(void **state)
{
    struct quantity q[QUANTITIES];
    struct stiffness stiffness;
    struct curves curves;
    struct run run;
    (void)state;
    fixture_run(&run, STAGE(STRESS("100.0"), STRESS("100.0"), STRAIN("0.02")), N);
    run.scene->analysis.strain = STRAIN_LOGARITHMIC;
    for (size_t i = 0; i < N; i++) {
        const double eps = 0.02 * (double)i / (N - 1);
        record(&run, i, (const double[]){-0.2 * eps, -0.2 * eps, eps}, (const double[]){100, 100, 150 + 2000 * eps});
    }
    extracted(&run, &curves, q);
    assert_int_equal(shear_strength_evaluate(&curves, run.scene, q, &stiffness), STATUS_OK);
    assert_true(stiffness.n > 2);
    for (int k = 0; k < (int)stiffness.n; k++)
        assert_near(stiffness.row[k].secant_pa, 2000, 2000 * 1e-6); /* a straight line: exact but for rounding */
    curves_free(&curves);
    run_free(&run);
}

/* p falls from 100 to 40 at eps = 0.01 along a parabola, and rises to 100 at 0.02; q = 60 (1 - e^(-eps/0.002)). 2G is
 * dq/d(1.5 eps). Means over 9 samples around the least: the parabola's 0.6 (4/200)^2 x 2/3... below 0.02 Pa. */
static void constant_volume(void **state)
{
    struct quantity q[QUANTITIES];
    struct stiffness stiffness;
    struct curves curves;
    struct run run;
    (void)state;
    fixture_run(&run, STAGE(STRAIN("-0.01"), STRAIN("-0.01"), STRAIN("0.02")), N);
    for (size_t i = 0; i < N; i++) {
        const double eps = 0.02 * (double)i / (N - 1), p = 40 + 60 * pow((eps - 0.01) / 0.01, 2);
        const double deviator = 30 * (1 - exp(-eps / 0.002));
        record(&run, i, (const double[]){-eps / 2, -eps / 2, eps},
               (const double[]){p - deviator / 3, p - deviator / 3, p + 2 * deviator / 3});
    }
    extracted(&run, &curves, q);
    assert_int_equal(curves.controls.kind, TEST_CONSTANT_VOLUME);
    undrained_evaluate(&curves, q);
    assert_int_equal(shear_strength_evaluate(&curves, run.scene, q, &stiffness), STATUS_OK);
    assert_near(q[QUANTITY_P0].value, 100, 1e-10);
    assert_near(q[QUANTITY_R_U_MAX].value, 0.6, 2e-4);
    assert_near(q[QUANTITY_PT_EPS].value, 0.01, 1e-4); /* engineering strain, on the grid of samples */
    assert_near(q[QUANTITY_PT_Q].value, 30 * (1 - exp(-5)), 0.02);
    assert_near(q[QUANTITY_G_INITIAL].value, 30 / 0.002 / 3, 2 * q[QUANTITY_G_INITIAL].uncertainty);
    assert_true(isnan(q[QUANTITY_LIQUEFACTION_EPS].value));
    assert_true(isnan(q[QUANTITY_NU].value) && isnan(q[QUANTITY_DILATANCY_ANGLE].value));
    curves_free(&curves);
    run_free(&run);
}

/* Strain cycles of 0.25 s at constant volume that break off at 0.97 s, in the fourth cycle: p = 100 (1 - t) falls to 5
 * % of p0 in it, at 0.95 s. q = 20 sin: CSR = 20/200, to the largest distance of a sample from a maximum, 1/800 s: 1 -
 * cos(2 pi/200). */
static void liquefied_within_a_cycle(void **state)
{
    struct quantity q[QUANTITIES];
    struct cycles cycles;
    struct curves curves;
    struct run run;
    (void)state;
    fixture_run(&run,
                STAGE("{ mode = \"coupled\"; keep = \"volume\"; }", "{ mode = \"coupled\"; keep = \"volume\"; }",
                      "{ mode = \"strain\"; course = \"cosine\"; two_way = true; strain = 1e-3; frequency_hz = 4.0; }"),
                N);
    for (size_t i = 0; i < N; i++) {
        const double t = (double)i / (N - 1), wave = sin(8 * M_PI * t), eps = 1e-3 * wave, p = 100 * (1 - t);
        record(&run, i, (const double[]){-eps / 2, -eps / 2, eps},
               (const double[]){p - 20 * wave / 3, p - 20 * wave / 3, p + 40 * wave / 3});
    }
    run.n_samples = 389;
    extracted(&run, &curves, q);
    assert_int_equal(curves.controls.kind, TEST_CYCLIC);
    assert_int_equal(cycles_evaluate(&cycles, &curves), STATUS_OK);
    shakedown_classify(&cycles, &curves, 1e-4);
    cycles_quantities(&cycles, &curves, q);
    assert_int_equal(cycles.n, 3);
    assert_near(q[QUANTITY_CYCLES_LIQUEFACTION].value, 4, 0);
    assert_near(q[QUANTITY_CYCLES_R_U].value, 0.97, 1e-12);
    assert_near(q[QUANTITY_CYCLES_STRESS_RATIO].value, 0.1, 0.1 * (1 - cos(2 * M_PI / 200)));
    cycles_free(&cycles);
    curves_free(&curves);
    run_free(&run);
}

/* Rowe's law itself: R = 3 D with D = 1 - d eps_v/d eps_zz rising from 1/3 + to 1.2. K = 3: sin phi = 1/2, 30 degrees.
 * The hyperbola of the degradation curve: q = E eps/(1 + eps/r) with r = 0.01: half of E at eps = r. */
static void stress_dilatancy(void **state)
{
    struct quantity q[QUANTITIES];
    struct stiffness stiffness;
    struct curves curves;
    struct run run;
    (void)state;
    fixture_run(&run, STAGE(STRESS("100.0"), STRESS("100.0"), STRAIN("0.05")), N);
    run.scene->analysis.strain = STRAIN_LOGARITHMIC;
    for (size_t i = 0; i < N; i++) {
        /* R = 1 + 3 x/(1 + x), x = eps/0.01; D = R/3; eps_v = integral of (1 - D) = eps 2/3 - 0.01 (x - ln(1 + x)) */
        const double eps = 0.05 * (double)i / (N - 1), x = eps / 0.01, ratio = 1 + 3 * x / (1 + x);
        const double volume = 2 * eps / 3 - 0.01 * (x - log1p(x)), lateral = (volume - eps) / 2;
        record(&run, i, (const double[]){lateral, lateral, eps}, (const double[]){100, 100, 100 * ratio});
    }
    run.scene->analysis.modulus_strain = 0.01;
    extracted(&run, &curves, q);
    assert_int_equal(shear_strength_evaluate(&curves, run.scene, q, &stiffness), STATUS_OK);
    /* local parabolas over 1/20 of the range see the bend of the curve: 1 % */
    assert_near(q[QUANTITY_ROWE_K].value, 3, 0.03);
    assert_near(q[QUANTITY_ROWE_ANGLE].value, 30, 0.3);
    assert_near(q[QUANTITY_HALF_STIFFNESS].value, 0.01, 0.01 * 0.02);
    curves_free(&curves);
    run_free(&run);
}

/* eps = 0.01 (1 - e^(-t/0.1)): its time, and no rate at the end; sigma = 900 + 100 e^(-t/0.2). The fit is exact for
 * curves without noise: 1e-6 leaves room for the iteration's end. */
static void held(void **state)
{
    struct quantity q[QUANTITIES];
    struct curves curves;
    struct run run;
    (void)state;
    fixture_run(&run, STAGE(STRESS("100.0"), STRESS("100.0"), STRESS("200.0")), N);
    for (size_t i = 0; i < N; i++) {
        const double eps = 0.01 * (1 - exp(-(double)i / (N - 1) / 0.1));
        record(&run, i, (const double[]){0, 0, eps}, (const double[]){100, 100, 200});
    }
    extracted(&run, &curves, q);
    assert_int_equal(curves.controls.kind, TEST_CREEP);
    creep_relaxation_evaluate(&curves, q);
    assert_near(q[QUANTITY_HELD_TIME].value, 0.1, 1e-6);
    assert_near(q[QUANTITY_HELD_RATE].value, 0, 1e-4);
    curves_free(&curves);
    run_free(&run);
    fixture_run(&run, STAGE(FIXED, FIXED, FIXED), N);
    for (size_t i = 0; i < N; i++) {
        const double sigma = 900 + 100 * exp(-(double)i / (N - 1) / 0.2);
        record(&run, i, (const double[]){0, 0, 0}, (const double[]){500, 500, sigma});
    }
    extracted(&run, &curves, q);
    assert_int_equal(curves.controls.kind, TEST_RELAXATION);
    creep_relaxation_evaluate(&curves, q);
    assert_near(q[QUANTITY_RELAXATION_TIME].value, 0.2, 1e-6);
    assert_near(q[QUANTITY_RELAXATION_DROP].value, 1 - (900 + 100 * exp(-5)) / 1000, 1e-12);
    curves_free(&curves);
    run_free(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kinds),
        cmocka_unit_test(isotropic),
        cmocka_unit_test(indices),
        cmocka_unit_test(strains_of_the_box),
        cmocka_unit_test(oedometer),
        cmocka_unit_test(extension),
        cmocka_unit_test(secant_from_a_deviator),
        cmocka_unit_test(constant_volume),
        cmocka_unit_test(held),
        cmocka_unit_test(liquefied_within_a_cycle),
        cmocka_unit_test(stress_dilatancy),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
