/* Rolling and torsion resistance against closed forms, the order of the scheme, angular momentum, and the energy ledger
 * with every normal law. */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/auto_time_step.h"
#include "sim/measure/measure.h"
#include "sim/measure/step_limit.h"
#include "sim/sample/energy.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"

static const double PI = 3.14159265358979323846;
static const double G = 9.81, A = 1e-3, K = 1e5; /* m/s^2; radius of the fixture's particles, m; N/m */

static double mass_of(double radius)
{
    return 4.0 / 3.0 * PI * 2000 * radius * radius * radius;
}

static struct fixture open_with(int dimension, int count, double dt, const char *material, const char *more)
{
    const struct fixture_options options = {
        .dimension = dimension, .count = count, .dt_s = dt, .material = material, .more = more};
    return fixture_open(&options);
}

/* Spin of a sphere that rolls along x on the lower wall of the last axis: omega_y, in 2D about x cross z = -y. */
static void set_rolling_spin(struct particles *p, double spin)
{
    if (p->dimension == 2)
        p->omega[0][0] = -spin;
    else
        p->omega[1][0] = spin;
}

static double rolling_spin(const struct particles *p)
{
    return p->dimension == 2 ? -p->omega[0][0] : p->omega[1][0];
}

/* A sphere that lies on the floor by its weight, and rolls along x with v. */
static struct fixture on_floor(int dimension, double dt, const char *material, const char *more, double v)
{
    struct fixture f = open_with(dimension, 1, dt, material, more);
    struct particles *p = &f.sample->particles;
    const int last = dimension - 1;
    p->x[last][0] = f.sample->walls[2 * last].x + A - mass_of(A) * G / K;
    p->v[0][0] = v;
    set_rolling_spin(p, v / A);
    f.sample->gravity[last] = -G;
    fixture_start(&f);
    return f;
}

static const char STIFF[] = "kn_n_per_m = 1e5; gamma_n_kg_per_s = 0.2; mu_s = 0.5; kt_n_per_m = 1e5; "
                            "gamma_t_kg_per_s = 0.2; mu_rolling = 0.05; kr_n_per_m = 1e5; gamma_r_kg_per_s = 0.1; "
                            "mu_torsion = 0.02; ko_n_per_m = 1e5; gamma_o_kg_per_s = 0.1;";

/* m v' = -F, I omega' = F a - mu_r a N: v' = -(5/7) mu_r g. The overlap, 8e-7 of the radius, shortens the lever. */
static void sphere_on_a_plane_slows_down(void **state)
{
    (void)state;
    static const char *const mixed[] = {"", "precision = \"mixed\";"};
    enum { SETTLE = 2000, STEPS = 4000 };
    for (int dimension = 2; dimension <= 3; dimension++)
        for (int k = 0; k < 2; k++) {
            const double dt = 1e-6;
            struct fixture f = on_floor(dimension, dt, STIFF, mixed[k], 0.1);
            const struct particles *p = &f.sample->particles;
            fixture_steps(&f, SETTLE);
            const double before = p->v[0][0];
            fixture_steps(&f, STEPS);
            assert_close("(5/7) mu_r g", (before - p->v[0][0]) / (STEPS * dt) / G, 5.0 / 7 * 0.05,
                         1e-3 * 5.0 / 7 * 0.05);
            assert_close("rolls", rolling_spin(p) * A / p->v[0][0], 1, 1e-5);
            assert_true(f.sample->ledger.contacts.rolling > 0);
            fixture_close(&f);
        }
}

/* A sphere that spins about the vertical: I omega' = -mu_o a N, omega' = -(5/2) mu_o g/a. */
static void spinning_top_slows_down(void **state)
{
    (void)state;
    enum { SETTLE = 2000, STEPS = 4000 };
    const double dt = 1e-6;
    struct fixture f = on_floor(3, dt, STIFF, "", 0);
    struct particles *p = &f.sample->particles;
    p->omega[2][0] = 100;
    time_step_forces_anew(f.sample);
    fixture_steps(&f, SETTLE);
    const double before = p->omega[2][0];
    fixture_steps(&f, STEPS);
    const double expected = 2.5 * 0.02 * G / A;
    assert_close("(5/2) mu_o g/a", (before - p->omega[2][0]) / (STEPS * dt), expected, 1e-3 * expected);
    fixture_close(&f);
}

/* The same fixture on a slope of this tangent: acceleration along it over g cos(alpha), after it came to rest on a
 * gentler one. */
static double on_slope(int dimension, double tangent)
{
    const double dt = 1e-6;
    enum { STEPS = 5000 };
    struct fixture f = on_floor(dimension, dt, STIFF, "", 0);
    const struct particles *p = &f.sample->particles;
    for (int k = 1; k <= 10; k++) { /* by and by, so that the spring does not swing over */
        f.sample->gravity[0] = tangent * G * (0.9 + 0.01 * k);
        fixture_steps(&f, STEPS / 5);
    }
    fixture_steps(&f, STEPS);
    const double before = p->v[0][0];
    fixture_steps(&f, STEPS);
    const double rate = (p->v[0][0] - before) / (STEPS * dt) / G;
    fixture_close(&f);
    return rate;
}

/* It rests as long as m g a sin(alpha) <= mu_r a N, tan(alpha) <= mu_r; beyond, v' = (5/7) g cos(alpha) (tan(alpha) -
 * mu_r). */
static void sphere_on_a_slope(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        assert_close("rests", on_slope(dimension, 0.05 * (1 - 1e-3)), 0, 1e-9);
        assert_close("rolls", on_slope(dimension, 0.05 * (1 + 1e-2)), 5.0 / 7 * 0.05e-2, 1e-3 * 0.05);
    }
}

/* On a plane, rolling without slip: omega^2 = k_r a^2/((7/5) m a^2). The tangential spring, 5000 times as stiff, is in
 * line with it: 1e-4. 20 periods without any dashpot. */
static void rolling_oscillates(void **state)
{
    (void)state;
    static const char material[] = "kn_n_per_m = 1e5; mu_s = 50.0; kt_n_per_m = 1e5; mu_rolling = 50.0; "
                                   "kr_n_per_m = 20.0;";
    const double v0 = 1e-4, period = 2 * PI / sqrt(5.0 / 7 * 20 / mass_of(A)), dt = 1e-6;
    for (int dimension = 2; dimension <= 3; dimension++) {
        struct fixture f = on_floor(dimension, dt, material, "", v0);
        const struct particles *p = &f.sample->particles;
        fixture_steps(&f, (int)lround(20 * period / dt));
        assert_close("amplitude", p->v[0][0] / v0, 1, 1e-3);
        fixture_steps(&f, (int)lround(0.5 * period / dt));
        assert_close("half a period on", p->v[0][0] / v0, -1, 1e-3);
        fixture_close(&f);
    }
}

/* Two spheres held in place that turn against each other: omega' = -2 a'/I (k xi + gamma v), v = a' omega_rel: a damped
 * oscillator of omega_0^2 = (5/4) k/m and eta = (5/8) gamma/m. Error of the relative rotation over its start. */
static double pair_error(int dimension, bool torsion, int steps)
{
    const double k = 1e4, gamma = 0.02, m = mass_of(A), eta = 0.625 * gamma / m;
    const double omega = sqrt(1.25 * k / m - eta * eta), t = 7 / omega;
    const struct fixture_options options = {.dimension = dimension,
                                            .dt_s = t / steps,
                                            .material =
                                                "kn_n_per_m = 1e5; mu_s = 0.5; kt_n_per_m = 2e4; "
                                                "mu_rolling = 50.0; kr_n_per_m = 1e4; gamma_r_kg_per_s = 0.02; "
                                                "mu_torsion = 50.0; ko_n_per_m = 1e4; gamma_o_kg_per_s = 0.02;"};
    struct fixture f = fixture_pair(&options, 1e-5, 0);
    struct particles *p = &f.sample->particles;
    const int c = dimension == 2 ? 0 : torsion ? 0 : 2; /* n along x */
    for (int i = 0; i < 2; i++) {
        p->inv_mass[i] = 0;
        p->omega[c][i] = i == 0 ? 0.05 : -0.05;
    }
    particles_set_views(p, f.sample->verlet.skin);
    time_step_forces_anew(f.sample);
    fixture_steps(&f, steps);
    const double expected = exp(-eta * t) * (cos(omega * t) - eta / omega * sin(omega * t));
    const double error = fabs((p->omega[c][0] - p->omega[c][1]) / 0.1 - expected);
    fixture_close(&f);
    return error;
}

/* As of friction: phase error t omega^3 dt^2/24 = 7^3/(24 n^2); halving the step divides by 4. */
static void order_in_time(void **state)
{
    (void)state;
    for (int k = 0; k < 3; k++) {
        const int dimension = k == 0 ? 2 : 3;
        const double coarse = pair_error(dimension, k == 2, 256), fine = pair_error(dimension, k == 2, 512);
        print_message("%dD %s: error %.2g, %.2g\n", dimension, k == 2 ? "torsion" : "rolling", coarse, fine);
        assert_true(coarse < 4 * 343.0 / 24 / (256.0 * 256.0));
        assert_close("order", log2(coarse / fine), 2, 0.15);
    }
}

/* Spheres with one rotation, whatever its axis, neither roll nor twist on each other. */
static void one_body_stores_nothing(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        const struct fixture_options options = {.dimension = dimension, .dt_s = 1e-6, .material = STIFF};
        struct fixture f = fixture_pair(&options, 1e-6, 0);
        struct particles *p = &f.sample->particles;
        for (int i = 0; i < 2; i++)
            for (int c = 0; c < p->n_rotations; c++) {
                p->omega[c][i] = 3 * c + 1;
                p->inv_mass[i] = p->inv_inertia[i] = 0;
            }
        particles_set_views(p, f.sample->verlet.skin);
        time_step_forces_anew(f.sample);
        fixture_steps(&f, 100);
        (void)sample_complete(f.sample);
        for (int c = 0; c < p->n_rotations; c++)
            assert_true(contact_list_value(&f.sample->pairs, HISTORY_ROLLING + c, 0) == 0);
        if (dimension == 3)
            assert_true(contact_list_value(&f.sample->pairs, HISTORY_TORSION, 0) == 0);
        assert_true(f.sample->ledger.contacts.rolling == 0 && f.sample->ledger.contacts.viscous_rolling == 0);
        fixture_close(&f);
    }
}

/* Spin and orbit about the origin. */
static void angular_momentum(const struct particles *p, double *sum)
{
    const int n = p->n_rotations;
    memset(sum, 0, 3 * sizeof *sum);
    for (int i = 0; i < p->count; i++)
        for (int c = 0; c < n; c++) {
            const int d = n == 1 ? 0 : (c + 1) % 3, e = n == 1 ? 1 : (c + 2) % 3;
            sum[c] += p->omega[c][i] / p->inv_inertia[i];
            sum[c] += p->mass[i] * (p->x[d][i] * p->v[e][i] - p->x[e][i] * p->v[d][i]);
        }
}

/* An oblique impact of two spinning spheres of different size. Returns the residual over the energy at first. */
static double impact(int dimension, const char *law, double contact_s, int steps_per_contact)
{
    char material[512];
    snprintf(material, sizeof material,
             "%s mu_rolling = 0.2; kr_n_per_m = 2e4; gamma_r_kg_per_s = 0.01; mu_torsion = 0.1; ko_n_per_m = 2e4; "
             "gamma_o_kg_per_s = 0.01;",
             law);
    const double speed = 0.1;
    const struct fixture_options options = {
        .dimension = dimension, .dt_s = contact_s / steps_per_contact, .material = material};
    struct fixture f = fixture_pair(&options, 0, speed);
    struct particles *p = &f.sample->particles;
    double before[3], after[3];
    p->radius[1] = 0.6 * A;
    p->x[0][1] -= 0.4 * A - 1e-9;
    particles_set_mass(p, 2000);
    particles_set_views(p, f.sample->verlet.skin);
    must(sample_build_lists(f.sample));
    for (int i = 0; i < 2; i++) {
        p->v[1][i] = (i ? -1 : 1) * 0.5 * speed;
        for (int c = 0; c < p->n_rotations; c++)
            p->omega[c][i] = (i ? -40 : 90) + 30 * c;
    }
    time_step_forces_anew(f.sample);
    f.sample->ledger = energy_ledger_start(sample_complete(f.sample));
    const double start = energy_kinetic_j(sample_complete(f.sample));
    angular_momentum(p, before);
    fixture_steps(&f, 3 * steps_per_contact);
    struct measurement m;
    must(measure(sample_complete(f.sample), &m));
    angular_momentum(p, after);
    assert_true(fixture_overlap(&f) < 0);
    /* the dashpot's share of what slides is slip against the motion where a spring comes back: both together lose */
    assert_true(f.sample->ledger.contacts.rolling > 0);
    assert_true(f.sample->ledger.contacts.rolling + f.sample->ledger.contacts.viscous_rolling > 0);
    for (int c = 0; c < p->n_rotations; c++)
        assert_close("angular momentum", after[c], before[c], 1e-12 * (fabs(before[0]) + fabs(before[c])));
    fixture_close(&f);
    return fabs(m.residual_j) / start;
}

static const struct {
    const char *name, *material;
    double contact_s;
} laws[] = {
    {"linear", "kn_n_per_m = 1e5; mu_s = 0.4; kt_n_per_m = 3e4;", 2e-5},
    {"linear, e", "kn_n_per_m = 1e5; restitution = 0.8; mu_s = 0.4; kt_n_per_m = 3e4;", 2e-5},
    {"hysteretic", "law = \"hysteretic\"; k1_n_per_m = 5e4; k2_n_per_m = 1e5; mu_s = 0.4; kt_n_per_m = 3e4;", 2e-5},
    {"elastoplastic", "law = \"elastoplastic\"; k1_n_per_m = 5e4; kp_n_per_m = 1e5; mu_s = 0.4; kt_n_per_m = 3e4;",
     2e-5},
    {"hertz", "law = \"hertz\"; youngs_modulus_pa = 1e9; poisson_ratio = 0.25; mu_s = 0.4;", 3e-5}};

/* Closes with every law, and the better the shorter the step. */
static void ledger_of_impacts(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++)
        for (size_t k = 0; k < sizeof laws / sizeof laws[0]; k++) {
            const double coarse = impact(dimension, laws[k].material, laws[k].contact_s, 80),
                         fine = impact(dimension, laws[k].material, laws[k].contact_s, 320);
            print_message("%dD %s: residual/energy %.2g, %.2g\n", dimension, laws[k].name, coarse, fine);
            assert_true(fine < 1e-4);
            assert_true(fine < coarse / 8); /* second order, kinks aside: 16 */
        }
}

/* The largest spin about the vertical, over that at first, of a top on a floor whose torsion spring is what is stiffest
 * there is: I omega' = -a'^2 k_o theta with a' = a. */
static double largest_twist(const char *law, double dt)
{
    char material[256];
    snprintf(material, sizeof material, "%s mu_s = 0.5; mu_torsion = 100; ko_n_per_m = 1e7;", law);
    struct fixture f = on_floor(3, dt, material, "", 0);
    struct particles *p = &f.sample->particles;
    const double start = 1e-5;
    double largest = 0;
    p->omega[2][0] = start;
    time_step_forces_anew(f.sample);
    for (int k = 0; k < 2000 && largest < 1e3; k++) {
        fixture_steps(&f, 1);
        largest = fmax(largest, fabs(p->omega[2][0]) / start);
    }
    fixture_close(&f);
    return largest;
}

/* omega^2 = k_o a^2/I = 2.5 k_o/m: a step of 0.98 times 2/omega keeps the swing (the discrete one of a step that long
 * is at most 1/sqrt(1 - 0.98^2) = 5 times as wide), one of 1.02 times lets it grow. In a packing, with twice the
 * contacts on half the mass, it is half of that; `dt_s` that is longer is refused, and "auto" is a third, with every
 * law. */
static void stiffest_spring_of_torsion_limits_the_step(void **state)
{
    static const char *const normal[] = {"kn_n_per_m = 1e5; kt_n_per_m = 1e4;",
                                         "law = \"hertz\"; youngs_modulus_pa = 1e8; poisson_ratio = 0.25;"};
    const double bound = 2 / sqrt(2.5 * 1e7 / mass_of(A));
    (void)state;
    for (int k = 0; k < 2; k++) {
        char material[256];
        snprintf(material, sizeof material, "%s mu_s = 0.5; mu_torsion = 100; ko_n_per_m = 1e7;", normal[k]);
        const double below = largest_twist(normal[k], 0.98 * bound), above = largest_twist(normal[k], 1.02 * bound);
        print_message("%s: %.3g below, %.3g above\n", normal[k], below, above);
        assert_true(below < 6 && above > 60); /* until it slips */
        struct fixture f = open_with(3, 1, bound, material, "");
        const struct step_limit limit = step_limit_of(f.sample, &f.scene->stage[0]);
        assert_true(limit.tangential);
        assert_close("packing", limit.stable_s / bound, 0.5, 1e-2); /* k_t, a hundredth, counts too */
        assert_int_equal(step_limit_check(f.sample), STATUS_CONFIG);
        f.scene->stage[0].dt_s = time_step_of_stage_s(f.scene, &f.scene->stage[0]);
        assert_close("auto", f.scene->stage[0].dt_s / bound, 0.5 / 3, 5e-3);
        must(step_limit_check(f.sample));
        fixture_close(&f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sphere_on_a_plane_slows_down),
        cmocka_unit_test(spinning_top_slows_down),
        cmocka_unit_test(sphere_on_a_slope),
        cmocka_unit_test(rolling_oscillates),
        cmocka_unit_test(order_in_time),
        cmocka_unit_test(one_body_stores_nothing),
        cmocka_unit_test(ledger_of_impacts),
        cmocka_unit_test(stiffest_spring_of_torsion_limits_the_step),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
