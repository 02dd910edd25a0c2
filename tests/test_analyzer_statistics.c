/* Estimators against closed forms, and their errors against the scatter over seeded draws. */
#include "test_analyzer_fixture.h"

#include <math.h>

#include "analyzer/curves.h"
#include "analyzer/shear_strength.h"
#include "analyzer/statistics.h"

/* Closed forms: dof 1 is Cauchy, dof 2 is 1/2 + t/(2 sqrt(2 + t^2)); 2.262157162740992 is the 97.5 % point at dof 9
 * (tables, 10 digits). The continued fraction converges to rounding: 1e-12 leaves a factor of 1000. */
static void student_cdf(void **state)
{
    (void)state;
    for (double t = -6; t <= 6; t += 0.75) {
        assert_near(statistics_student_cdf(t, 1), 0.5 + atan(t) / M_PI, 1e-12);
        assert_near(statistics_student_cdf(t, 2), 0.5 + t / (2 * sqrt(2 + t * t)), 1e-12);
    }
    assert_near(statistics_student_cdf(2.262157162740992, 9), 0.975, 1e-9);
}

/* Polynomials are reproduced; skipped points do not count. Normal equations in [-1, 1]: condition below 100, so 1e-13.
 */
static void polynomial_exact(void **state)
{
    (void)state;
    enum { N = 30 };
    double x[N], y[N], w[N], c[3];
    for (int k = 0; k < N; k++) {
        x[k] = 0.1 * k * k; /* uneven */
        y[k] = 2 - 0.5 * x[k] + 0.01 * x[k] * x[k];
    }
    y[4] = 1e6;
    y[5] = NAN;
    statistics_weights(x, w, N);
    struct points points = {x, w, N};
    assert_true(statistics_polynomial(&points, y, 4, 5, 2, 10, c));
    assert_near(c[0], 2 - 5 + 1, 1e-11);
    assert_near(c[1], -0.5 + 0.2, 1e-12);
    assert_near(c[2], 0.01, 1e-13);
    points.n = 2;
    assert_false(statistics_polynomial(&points, y, 0, 0, 2, 0, c));
}

/* The mean over an uneven abscissa is that over x, not over samples: y = x on [0, 1] with points crowded at 0 gives 1/2
 * (trapezoidal weights are exact for a straight line). */
static void mean_over_abscissa(void **state)
{
    (void)state;
    enum { N = 101 };
    double x[N], w[N];
    struct estimate mean;
    for (int k = 0; k < N; k++)
        x[k] = k * k / 1e4;
    statistics_weights(x, w, N);
    struct points points = {x, w, N};
    assert_true(statistics_mean(&points, x, &mean));
    assert_near(mean.value, 0.5, 1e-14);
    points.n = 0;
    assert_false(statistics_mean(&points, x, &mean));
}

/* Correlated errors, autoregression with 0.8: the variance of a mean of N = 1000 is (1 + 0.8)/(1 - 0.8) = 9 times the
 * naive one. Blocks of 100 samples (correlation time 4.5) lose about 2*4.5/100 = 9 % of the variance at their edges.
 * The mean of u^2 over 200 draws with 9 degrees of freedom each is known to sqrt(2/1800) = 3.3 %, the variance of the
 * means to sqrt(2/199) = 10 %: ratio in 0.91 +- 3 x 0.1. The naive error would give 1/9. */
static void mean_error_of_correlated(void **state)
{
    (void)state;
    enum { N = 1000, DRAWS = 200 };
    static double x[N], y[N], w[N];
    struct random random = {42};
    double claimed = 0, squares = 0;
    for (int k = 0; k < N; k++)
        x[k] = k;
    statistics_weights(x, w, N);
    struct points points = {x, w, N};
    for (int draw = 0; draw < DRAWS; draw++) {
        struct estimate mean;
        double error = random_normal(&random);
        for (int k = 0; k < N; k++, error = 0.8 * error + 0.6 * random_normal(&random))
            y[k] = 3 + error;
        assert_true(statistics_mean(&points, y, &mean));
        claimed += mean.error * mean.error / DRAWS;
        squares += (mean.value - 3) * (mean.value - 3) / DRAWS;
    }
    assert_near(claimed / squares, 0.91, 0.3);
}

/* Replicas 0 ... 9 without block 0 ... 9: their s.d. is sqrt(82.5/9), u = s.d. (B - 1)/sqrt(B) with B = 10. */
static bool number_of_block(const void *x, size_t begin, size_t end, double *out)
{
    out[0] = begin == end ? -1 : floor(((const double *)x)[begin] / 10);
    return true;
}

static void jackknife_of_known_replicas(void **state)
{
    enum { N = 101 };
    double x[N], w[N];
    struct estimate out;
    (void)state;
    for (int k = 0; k < N; k++)
        x[k] = k;
    statistics_weights(x, w, N);
    assert_true(statistics_jackknife(&(struct points){x, w, N}, number_of_block, x, 1, &out));
    assert_true(out.value == -1);
    assert_near(out.error, sqrt(82.5 / 9) * 9 / sqrt(10) * statistics_widening(9), 1e-12);
}

/* n = 3: mean 2, s.d. 1, standard error 1/sqrt(3). */
static void plain_mean(void **state)
{
    (void)state;
    double deviation;
    struct estimate mean = statistics_plain_mean((const double[]){1, 2, 3}, 3, &deviation);
    assert_near(mean.value, 2, 1e-15);
    assert_near(deviation, 1, 1e-15);
    assert_near(mean.error, 1 / sqrt(3), 1e-15);
    assert_true(isnan(statistics_plain_mean(NULL, 0, &deviation).value));
}

/* The numbers of [LH]: +0.19 is 5 degrees, +0.44 is 10.4 (printed 11); sigma_zz/sigma_xx = 1.6 is sin phi = 0.6/2.6. */
static void soil_mechanics(void **state)
{
    (void)state;
    struct estimate angle = shear_dilatancy_angle_rad((struct estimate){0.19, 0.01}, false);
    assert_near(sin(angle.value), 0.19 / 2.19, 1e-14);
    assert_near(angle.value * 180 / M_PI, 5, 0.05);
    assert_near(shear_dilatancy_angle_rad((struct estimate){0.44, 0}, false).value * 180 / M_PI, 10.4, 0.05);
    assert_true(isnan(shear_dilatancy_angle_rad((struct estimate){-1, 0}, false).value));
    /* the propagated error is the derivative: compare with a difference quotient, whose error is O(h^2) = 1e-8 */
    double up = shear_dilatancy_angle_rad((struct estimate){0.1901, 0}, false).value;
    double down = shear_dilatancy_angle_rad((struct estimate){0.1899, 0}, false).value;
    assert_near(angle.error, 0.01 * (up - down) / 2e-4, 1e-8);
    assert_near(shear_sin_phi((struct estimate){1.6, 0}).value, 0.6 / 2.6, 1e-15);
}

/* A tensor with eigenvalues 0.5, 0.3, 0.2 turned about two axes; the trigonometric solution loses half the digits only
 * where eigenvalues coincide. */
static void eigenvalues(void **state)
{
    (void)state;
    double a = 0.7, b = 1.1, v[3], lambda[3] = {0.3, 0.5, 0.2}, t[9] = {0};
    double q[3][3] = {
        {cos(a), sin(a) * cos(b), sin(a) * sin(b)}, {-sin(a), cos(a) * cos(b), cos(a) * sin(b)}, {0, -sin(b), cos(b)}};
    for (int k = 0; k < 3; k++)
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++)
                t[3 * r + c] += lambda[k] * q[k][r] * q[k][c];
    tensor_eigenvalues(t, 3, v);
    assert_near(v[0], 0.5, 1e-14);
    assert_near(v[1], 0.3, 1e-14);
    assert_near(v[2], 0.2, 1e-14);
    tensor_eigenvalues((const double[]){1. / 3, 0, 0, 0, 1. / 3, 0, 0, 0, 1. / 3}, 3, v);
    assert_near(v[0], 1. / 3, 1e-8);
    tensor_eigenvalues((const double[]){0.5, 0.1, 0.1, 0.5}, 2, v);
    assert_near(v[0], 0.6, 1e-15);
    assert_near(v[1], 0.4, 1e-15);
}

/* The first that is not below. */
static void lower_bound(void **state)
{
    const double x[] = {1, 2, 2, 3};
    (void)state;
    assert_int_equal(statistics_lower_bound(x, 4, 0), 0);
    assert_int_equal(statistics_lower_bound(x, 4, 2), 1);
    assert_int_equal(statistics_lower_bound(x, 4, 2.5), 3);
    assert_int_equal(statistics_lower_bound(x, 4, 4), 4);
}

/* sin phi = (R - 1)/(R + 1), and its derivative 2/(R + 1)^2. */
static void sine_of_a_ratio(void **state)
{
    (void)state;
    const struct estimate sine = shear_sin_phi((struct estimate){3, 0.4});
    assert_true(sine.value == 0.5 && sine.error == 0.4 * 2 / 16);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(student_cdf),        cmocka_unit_test(polynomial_exact),
        cmocka_unit_test(mean_over_abscissa), cmocka_unit_test(mean_error_of_correlated),
        cmocka_unit_test(plain_mean),         cmocka_unit_test(soil_mechanics),
        cmocka_unit_test(eigenvalues),        cmocka_unit_test(lower_bound),
        cmocka_unit_test(sine_of_a_ratio),    cmocka_unit_test(jackknife_of_known_replicas),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
