/* How well targets and coupled axes are kept, on records with known deviations. */
#include "test_analyzer_fixture.h"

#include <math.h>
#include <string.h>

#include "analyzer/control_quality.h"
#include "analyzer/judgement.h"

#define STAGE(x, y, z)                                                                                                 \
    "name = \"kept\"; dimension = 3; sample = { count = 8; radius_min_m = 1e-3; radius_max_m = 1e-3; "                 \
    "density_kg_per_m3 = 2000.0; };\nmaterial = { kn_n_per_m = 1e5; };\n"                                              \
    "walls = { x = { mode = \"stress\"; pressure_pa = 100.0; mass_kg = 1.0; }; y = { mode = \"stress\"; pressure_pa "  \
    "= 100.0; mass_kg = 1.0; }; z = { mode = \"stress\"; pressure_pa = 100.0; mass_kg = 1.0; }; };\n"                  \
    "stages = ( { name = \"s\"; dt_s = 1e-3; duration_s = 1.0; walls = { x = { " x " }; y = { " y " }; z = { " z       \
    " }; }; } );\n"
#define COUPLED(keep) "mode = \"coupled\"; keep = \"" keep "\";"
#define STRAIN        "mode = \"strain\"; strain = 0.01; frequency_hz = 1.0;"

enum { N = 5 };
static const double EPS = 2e-14; /* a few roundings of numbers of 1000 Pa and less, over 50 Pa and more */

static void samples(struct run *run, const char *config, double stress[N][3], double stretch_x)
{
    fixture_run(run, config, N);
    for (size_t i = 0; i < N; i++) {
        fixture_set(run, OBSERVABLE_STAGE_TIME, i, 0, 0.25 * (double)i);
        for (size_t k = 0; k < 3; k++)
            fixture_set(run, OBSERVABLE_STRESS_WALL, i, k, stress[i][k]);
    }
    fixture_set(run, OBSERVABLE_BOX_LENGTH, 3, 0, 0.1 * (1 + stretch_x));
}

/* The stresses as they are at five quarters of the stage, and one thing in one sample that is off. */
static void deviations(void **state)
{
    static const struct {
        const char *config;
        double stress[N][3];
        enum kept_quantity what;
        double mean, largest;
    } cases[] = {
        /* 0.5 Pa of 100 in one of 10 values */
        {STAGE("", "", STRAIN),
         {{100, 100, 100}, {100, 100, 120}, {100.5, 100, 150}, {100, 100, 170}, {100, 100, 180}},
         KEPT_STRESS,
         0.0005,
         0.005},
        /* two-way triangle of 100 Pa: at 100 + {0, 50, 0, -50, 0}; 1.5 Pa of 150 in one of 15 */
        {STAGE("", "", "target = \"triangle\"; two_way = true; amplitude_pa = 100.0; period_s = 1.0;"),
         {{100, 100, 100}, {100, 100, 150}, {100, 100, 101.5}, {100, 100, 50}, {100, 100, 100}},
         KEPT_STRESS,
         1.5 / 150 / 15,
         0.01},
        /* a table: 100, 150, 200, 200, 200 */
        {STAGE("", "", "target = \"table\"; times_s = [0.0, 0.5]; pressures_pa = [100.0, 200.0];"),
         {{100, 100, 100}, {100, 100, 150}, {100, 100, 200}, {100, 100, 202}, {100, 100, 200}},
         KEPT_STRESS,
         2.0 / 200 / 15,
         0.01},
        /* p = 100; 3 Pa in one stress are 1 Pa of p */
        {STAGE(COUPLED("p"), COUPLED("p"), STRAIN),
         {{100, 100, 100}, {95, 95, 110}, {90, 93, 120}, {80, 80, 140}, {75, 75, 150}},
         KEPT_P,
         0.01 / 5,
         0.01},
        /* q = 0, 25, 50, 75, 100 */
        {STAGE(COUPLED("volume"), COUPLED("volume"),
               COUPLED("q") " pressure_pa = 0.0; target = \"ramp\"; pressure_end_pa = 100.0; ramp_s = 1.0;"),
         {{100, 100, 100}, {90, 90, 115}, {80, 80, 130}, {70, 70, 145}, {60, 60, 158}},
         KEPT_Q,
         2.0 / 100 / 5,
         0.02},
        /* q = 3 (p - 100): sigma_z alone rises */
        {STAGE(COUPLED("path") " dq_dp = 3.0;", COUPLED("path") " dq_dp = 3.0;", STRAIN),
         {{100, 100, 100}, {100, 100, 110}, {100, 100, 120}, {100, 101, 130}, {100, 100, 140}},
         KEPT_PATH,
         1.5 / 100 / 5,
         0.015},
        /* b = (sigma_yy - sigma_xx)/(sigma_zz - sigma_xx) = 0.5; 0.04 off in one of 4, the first has no deviator */
        {STAGE("", COUPLED("b") " b = 0.5;", STRAIN),
         {{100, 100, 100}, {100, 105, 110}, {100, 110, 120}, {100, 127, 150}, {100, 130, 160}},
         KEPT_B,
         0.01,
         0.04},
    };
    (void)state;
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        struct run run;
        struct control_quality kept[KEPT_QUANTITIES];
        double stress[N][3];
        for (size_t i = 0; i < N; i++)
            for (size_t k = 0; k < 3; k++)
                stress[i][k] = cases[c].stress[i][k];
        samples(&run, cases[c].config, stress, 0);
        control_quality_find(&run, 0, 0, N, kept);
        print_message("case %zu: mean %.17g, largest %.17g\n", c, kept[cases[c].what].mean,
                      kept[cases[c].what].largest);
        assert_near(kept[cases[c].what].mean, cases[c].mean, EPS);
        assert_near(kept[cases[c].what].largest, cases[c].largest, EPS);
        run_free(&run);
    }
}

/* A box that is 1e-3 longer in one of five samples has that much more volume; nothing else is asked for. */
static void volume(void **state)
{
    struct run run;
    struct control_quality kept[KEPT_QUANTITIES];
    struct quantity quantity[QUANTITIES];
    double stress[N][3] = {{100, 100, 100}, {0, 7, 100}, {100, 100, 200}, {100, 100, 300}, {100, 100, 400}};
    (void)state;
    samples(&run, STAGE(COUPLED("volume"), COUPLED("volume"), STRAIN), stress, 1e-3);
    control_quality_find(&run, 0, 0, N, kept);
    assert_near(kept[KEPT_VOLUME].largest, 1e-3, EPS);
    assert_near(kept[KEPT_VOLUME].mean, 2e-4, EPS);
    for (int k = 0; k < KEPT_QUANTITIES; k++)
        assert_true(k == KEPT_VOLUME || isnan(kept[k].largest));
    control_quality_quantities(&run, 0, quantity);
    assert_false(quantity[QUANTITY_KEPT_VOLUME].absent);
    assert_true(quantity[QUANTITY_KEPT_P].absent);
    assert_false(quantity_is_reported(QUANTITY_KEPT_P, TEST_SHEAR, &quantity[QUANTITY_KEPT_P]));
    snprintf(run.controller, sizeof run.controller, "./mine"); /* which has targets of its own */
    control_quality_quantities(&run, 0, quantity);
    assert_true(quantity[QUANTITY_KEPT_VOLUME].absent);
    run_free(&run);
}

/* 0.5 Pa of 100 where 0.4 % and 0.6 % are asked of x, the smaller of which counts; nothing is where nothing is asked.
 */
static void a_tolerance_that_is_missed_makes_a_doubt(void **state)
{
    static const struct {
        const char *config;
        double tolerance;
        bool doubt;
    } cases[] = {{STAGE("tolerance = 4e-3;", "tolerance = 6e-3;", STRAIN), 4e-3, true},
                 {STAGE("tolerance = 6e-3;", "", STRAIN), 6e-3, false},
                 {STAGE("", "", STRAIN), 0, false}};
    double stress[N][3] = {{100, 100, 100}, {100, 100, 120}, {100.5, 100, 150}, {100, 100, 170}, {100, 100, 180}};
    (void)state;
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        struct run run;
        struct control_quality kept[KEPT_QUANTITIES];
        struct judgement judgement;
        bool doubt = false;
        samples(&run, cases[c].config, stress, 0);
        control_quality_find(&run, 0, 0, N, kept);
        assert_true(kept[KEPT_STRESS].tolerance == cases[c].tolerance);
        judgement_make(&judgement, &run, 0);
        for (size_t k = 0; k < judgement.n; k++)
            doubt |=
                judgement.note[k].severity == WORTH_DOUBTFUL && strstr(judgement.note[k].text, "a stress was kept");
        assert_true(doubt == cases[c].doubt);
        run_free(&run);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(deviations), cmocka_unit_test(volume),
                                       cmocka_unit_test(a_tolerance_that_is_missed_makes_a_doubt)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
