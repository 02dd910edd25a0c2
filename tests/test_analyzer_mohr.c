/* The common tangent of Mohr circles against circles that have one. */
#include "test_analyzer_fixture.h"

#include <math.h>

#include "analyzer/mohr.h"

static const double sine = 0.5, cohesion = 100; /* 30 degrees */

/* major = minor (1 + s)/(1 - s) + 2 c sqrt((1 + s)/(1 - s)): the circle touches the line. */
static struct mohr_circle touching(double minor, double error)
{
    const double n = (1 + sine) / (1 - sine);
    return (struct mohr_circle){{n * minor + 2 * cohesion * sqrt(n), error}, {minor, error}};
}

/* Without noise the tangent is exact up to rounding, whatever the weights. */
static void exact(void **state)
{
    struct mohr mohr;
    struct mohr_circle circle[5];
    (void)state;
    for (int k = 0; k < 5; k++)
        circle[k] = touching(100 * (k + 1), k + 1);
    assert_true(mohr_fit(&mohr, circle, 5));
    assert_near(mohr.friction_angle_deg.value, 30, 1e-9);
    assert_near(mohr.cohesion_pa.value, cohesion, 1e-8);
    assert_false(mohr.curved);
    for (int k = 0; k < 5; k++)
        circle[k] = touching(100 * (k + 1), NAN);
    assert_true(mohr_fit(&mohr, circle, 5));
    assert_near(mohr.friction_angle_deg.value, 30, 1e-9);
    assert_true(isnan(mohr.friction_angle_own));
    assert_false(mohr_fit(&mohr, circle, 1));
    circle[1] = circle[0];
    assert_false(mohr_fit(&mohr, circle, 2)); /* one confining stress */
}

/* Noise of 10 Pa in both stresses, 6 circles: 2u of either kind holds the truth in 95 % of the draws; 400 of them
 * scatter by 1.1 %: at least 0.95 - 3 x 0.011 = 0.917 of the own uncertainties, which are exact; of the scatter the
 * same, for it is widened by Student's t. A straight envelope is called curved in 4.6 %: at most 0.046 + 3 x 0.0105 =
 * 0.077. */
static void covered(void **state)
{
    enum { DRAWS = 400, N = 6 };
    struct random random = {17};
    double own = 0, scatter = 0, both = 0, curved = 0;
    (void)state;
    for (int draw = 0; draw < DRAWS; draw++) {
        struct mohr mohr;
        struct mohr_circle circle[N];
        for (int k = 0; k < N; k++) {
            circle[k] = touching(100 * (k + 1), 10);
            circle[k].major_pa.value += 10 * random_normal(&random);
            circle[k].minor_pa.value += 10 * random_normal(&random);
        }
        assert_true(mohr_fit(&mohr, circle, N));
        own += (fabs(mohr.friction_angle_deg.value - 30) <= 2 * mohr.friction_angle_own) / (double)DRAWS;
        scatter += (fabs(mohr.friction_angle_deg.value - 30) <= 2 * mohr.friction_angle_deg.error) / (double)DRAWS;
        both += (fabs(mohr.cohesion_pa.value - cohesion) <= 2 * mohr.cohesion_pa.error) / (double)DRAWS;
        curved += mohr.curved / (double)DRAWS;
    }
    print_message("  angle: own %.3f, scatter %.3f; cohesion %.3f; curved %.3f\n", own, scatter, both, curved);
    assert_true(own >= 0.917 && scatter >= 0.917 && both >= 0.917 && curved <= 0.077);
}

/* t = 2 s^0.7 bends by far more than 1 Pa of noise. */
static void bent(void **state)
{
    struct mohr mohr;
    struct mohr_circle circle[6];
    (void)state;
    for (int k = 0; k < 6; k++) {
        const double s = 200.0 * (k + 1), t = 2 * pow(s, 0.7);
        circle[k] = (struct mohr_circle){{s + t, 1}, {s - t, 1}};
    }
    assert_true(mohr_fit(&mohr, circle, 6));
    assert_true(mohr.curved);
    assert_true(mohr.curvature_pa < 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(exact), cmocka_unit_test(covered), cmocka_unit_test(bent)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
