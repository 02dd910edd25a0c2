/* Two particles in contact against closed forms: collision times, restitution, the path of the hysteretic force, the
 * order of the scheme, and the energy ledger. */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>

#include "sim/measure/measure.h"
#include "sim/sample/energy.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"

static const double PI = 3.14159265358979323846;
static const double K = 1e5; /* N/m, as in PHYSICS: scene A */

/* A damped contact: reduced mass, eta and omega of its closed form [D eq. 1]. */
struct oscillator {
    double m12, eta, omega;
};

/* Two spheres of 1 mm and 2000 kg/m^3, m_12 = 0.419e-5 kg. Background damping acts on both alike: -gamma_b/m times the
 * relative velocity, m = 2 m_12. */
static struct oscillator oscillator_of(double gamma_n, double gamma_b)
{
    struct oscillator o = {.m12 = 0.5 * 4.0 / 3.0 * PI * 2000 * 1e-9};
    o.eta = gamma_n / (2 * o.m12) + gamma_b / (4 * o.m12);
    o.omega = sqrt(K / o.m12 - o.eta * o.eta);
    return o;
}

/* Overlap and its rate after a time from overlap 0 at unit speed. */
static double overlap_at(const struct oscillator *o, double t)
{
    return exp(-o->eta * t) * sin(o->omega * t) / o->omega;
}

static double rate_at(const struct oscillator *o, double t)
{
    return exp(-o->eta * t) * (cos(o->omega * t) - o->eta / o->omega * sin(o->omega * t));
}

static struct fixture linear_pair(double gamma_n, double gamma_b, double dt, double overlap, double speed)
{
    char material[160];
    snprintf(material, sizeof material, "kn_n_per_m = %.17e; gamma_n_kg_per_s = %.17e; gamma_b_kg_per_s = %.17e;", K,
             gamma_n, gamma_b);
    struct fixture_options options = {.dimension = 2, .dt_s = dt, .material = material};
    return fixture_pair(&options, overlap, speed);
}

/* Time at which the overlap comes back to zero, by a straight line through the last two steps; approach gets the
 * (negative) speed then. */
static double collide(struct fixture *f, double *approach)
{
    double before = fixture_overlap(f), now = before;
    for (int k = 0; k < 1000000; k++) {
        fixture_steps(f, 1);
        now = fixture_overlap(f);
        if (now <= 0)
            break;
        before = now;
    }
    assert_true(now <= 0);
    *approach = fixture_approach(f);
    return f->sample->time_s - f->sample->dt * (-now / (before - now));
}

/* t_c = pi/omega to 0.1 %, for the three dampings of PHYSICS, whose numbers carry three digits, m_12 two. */
static void collision_time(void **state)
{
    static const double damping[] = {0, 0.1, 0.5}, table[] = {2.03e-5, 2.04e-5, 2.21e-5};
    (void)state;
    for (int k = 0; k < 3; k++) {
        struct oscillator o = oscillator_of(damping[k], 0);
        double expected = PI / o.omega, approach;
        struct fixture f = linear_pair(damping[k], 0, expected / 500, 0, 0.1);
        assert_close("t_c", collide(&f, &approach), expected, 1e-3 * expected);
        assert_close("t_c of PHYSICS", expected, table[k], 0.5e-2 * table[k]);
        fixture_close(&f);
    }
}

/* exp(-eta t_c). The contact opens between two steps while gamma v still acts on it: its last force may be one step too
 * long or short, a relative error in velocity of at most 2 eta dt; Verlet's own is (omega dt)^2. */
static void restitution(void **state)
{
    static const double damping[] = {0, 0.1, 0.5};
    (void)state;
    for (int k = 0; k < 3; k++) {
        struct oscillator o = oscillator_of(damping[k], 0);
        double tc = PI / o.omega, dt = tc / 10000, approach;
        struct fixture f = linear_pair(damping[k], 0, dt, 1e-14, 0.1);
        collide(&f, &approach);
        assert_close("restitution", -approach / 0.1, exp(-o.eta * tc), 2 * o.eta * dt + o.omega * o.omega * dt * dt);
        fixture_close(&f);
    }
}

/* gamma = 0, kc = 0: the elastic energy k1 d^2/2 goes in, (k1 d)^2/(2 k2) comes out. Error of second order: the force
 * is continuous; (omega dt)^2 for each of its two straight pieces. */
static void hysteretic_restitution(void **state)
{
    static const double ratio[] = {1, 0.5, 0.1};
    (void)state;
    for (int k = 0; k < 3; k++) {
        char material[160];
        snprintf(material, sizeof material, "law = \"hysteretic\"; k1_n_per_m = %.17e; k2_n_per_m = %.17e;",
                 ratio[k] * K, K);
        struct oscillator o = oscillator_of(0, 0);
        double dt = PI / o.omega / 2000, approach;
        struct fixture_options options = {.dimension = 3, .dt_s = dt, .material = material};
        struct fixture f = fixture_pair(&options, 0, 0.1);
        collide(&f, &approach);
        assert_close("sqrt(k1/k2)", -approach / 0.1, sqrt(ratio[k]), 2 * o.omega * o.omega * dt * dt);
        fixture_close(&f);
    }
}

/* One point of the path of [LH fig. 1.2], in units of the largest overlap d and of k1 d, with k2 = 2 k1 and kc = k1/2:
 * delta_0 = 1/2, delta_min = (k2 - k1)/(k2 + kc) = 0.4, and on the adhesion branch the history is 2.5 times delta. */
struct path_point {
    const char *what;
    double overlap, force, history;
};
static const struct path_point path[] = {
    {"loading", 0.3, 0.3, 0.3},
    {"loading to the top", 1, 1, 1},
    {"unloading", 0.75, 0.5, 1},
    {"unloading to delta_0", 0.5, 0, 1},
    {"unloading below delta_0", 0.45, -0.1, 1},
    {"the strongest attraction", 0.4, -0.2, 1},
    {"the adhesion branch", 0.2, -0.1, 0.5},
    {"reloading from the branch", 0.25, 0, 0.5},
    {"reloading", 0.4, 0.3, 0.5},
    {"back to the loading line", 0.5, 0.5, 0.5},
    {"loading beyond", 0.6, 0.6, 0.6},
    {"unloading from there", 0.3, 0, 0.6},
    {"the branch again", 0.1, -0.05, 0.25},
    {"back on a line of slope k2", 0.12, -0.01, 0.25},
    {"and down again", 0.1, -0.05, 0.25},
    {"almost open", 0.001, -0.0005, 0.0025},
    {"open", -0.01, 0, 0},
    {"loading anew: the history is forgotten", 0.2, 0.2, 0.2},
};

/* The force at overlap, the history that results: forces evaluated anew, no time passes. */
static void force_path(void **state)
{
    const double d = 1e-5, k1 = 5e4;
    struct fixture_options options = {
        .dimension = 2,
        .dt_s = 1e-7,
        .material = "law = \"hysteretic\"; k1_n_per_m = 5e4; k2_n_per_m = 1e5; kc_n_per_m = 2.5e4;"};
    struct fixture f = fixture_pair(&options, -1e-9, 0);
    struct sample *sample = f.sample;
    double middle = 0.5 * (sample->particles.x[0][0] + sample->particles.x[0][1]);
    (void)state;
    assert_int_equal(sample->pairs.count, 1);
    for (size_t k = 0; k < sizeof path / sizeof *path; k++) {
        double half = 1e-3 - 0.5 * path[k].overlap * d;
        sample->particles.x[0][0] = middle - half;
        sample->particles.x[0][1] = middle + half;
        time_step_forces_anew(sample);
        /* positions of about 0.2 m carry a rounding of 3e-17 m, that is 3e-12 of d */
        double force = -sample->particles.mass[0] * sample->particles.a[0][0];
        assert_close(path[k].what, force / (k1 * d), path[k].force, 1e-10);
        assert_close(path[k].what, contact_list_value(&sample->pairs, HISTORY_MAX_OVERLAP, 0) / d, path[k].history,
                     1e-10);
    }
    fixture_close(&f);
}

/* Energy between two points of the path is the area under it: what the ledger says is lost is what does not come back.
 * Round trip 0 -> d -> adhesion branch -> open at k2 = 2 k1, kc = k1/2: the loop's area in units of k1 d^2 is
 * 1/2 (loading) - 1/4 (k2 line down to delta_0) + 1/2 0.1 0.2 (down to delta_min) + 1/2 0.4 0.2 (the branch) = 0.3. */
static void hysteresis_loss_is_the_area(void **state)
{
    enum { STEPS = 4000 };
    const double d = 1e-5, k1 = 5e4;
    struct fixture_options options = {
        .dimension = 2,
        .dt_s = 1e-7,
        .material = "law = \"hysteretic\"; k1_n_per_m = 5e4; k2_n_per_m = 1e5; kc_n_per_m = 2.5e4;"};
    struct fixture f = fixture_pair(&options, -1e-9, 0);
    struct sample *sample = f.sample;
    double middle = 0.5 * (sample->particles.x[0][0] + sample->particles.x[0][1]);
    (void)state;
    for (int k = 1; k <= 2 * STEPS + 1; k++) {
        double overlap = k <= STEPS ? (double)k / STEPS : 2 - (double)k / STEPS;
        sample->particles.x[0][0] = middle - (1e-3 - 0.5 * overlap * d);
        sample->particles.x[0][1] = middle + (1e-3 - 0.5 * overlap * d);
        time_step_forces_anew(sample);
    }
    /* the loss depends on the history alone; the adhesion branch is entered within one of the STEPS */
    assert_close("loss", sample->ledger.contacts.hysteresis / (k1 * d * d), 0.3, 1.0 / STEPS);
    fixture_close(&f);
}

/* log2 of the ratio of the errors at dt and dt/2. */
static double order_of(double coarse, double fine)
{
    return log2(coarse / fine);
}

/* Largest error of overlap (omega delta) and rate, in units of the starting speed, at 0.4 t_c inside the contact. */
static double contact_error(double gamma_n, double gamma_b, int steps)
{
    struct oscillator o = oscillator_of(gamma_n, gamma_b);
    double start = 0.1 * PI / o.omega, end = 0.5 * PI / o.omega, dt = (end - start) / steps, v = 0.1;
    struct fixture f = linear_pair(gamma_n, gamma_b, dt, v * overlap_at(&o, start), v * rate_at(&o, start));
    fixture_steps(&f, steps);
    double in_overlap = fabs(fixture_overlap(&f) / v - overlap_at(&o, end)) * o.omega;
    double in_rate = fabs(fixture_approach(&f) / v - rate_at(&o, end));
    fixture_close(&f);
    return fmax(in_overlap, in_rate);
}

/* Second order, also with forces that depend on velocity. At 64 steps in 0.4 t_c omega dt = 0.02: the next term of the
 * error is of this relative size, which moves the order by 0.03; 0.1 leaves room for a cancelling leading term. */
static void second_order_in_a_contact(void **state)
{
    static const double damping[][2] = {{0, 0}, {0.5, 0}, {0, 0.5}, {0.3, 0.3}};
    (void)state;
    for (int k = 0; k < 4; k++) {
        double coarse = contact_error(damping[k][0], damping[k][1], 64);
        double fine = contact_error(damping[k][0], damping[k][1], 128);
        assert_close("order", order_of(coarse, fine), 2, 0.1);
    }
}

enum { OBLIQUE_VALUES = 6 };

/* An oblique contact that sticks (mu far above need), with both dampings and rotation: velocities after 0.4 t_c. */
static void oblique(int dimension, int steps, double *value)
{
    const double end = 8e-6, v = 0.1;
    struct fixture_options options = {.dimension = dimension,
                                      .dt_s = end / steps,
                                      .material = "kn_n_per_m = 1e5; gamma_n_kg_per_s = 0.1; mu_s = 50.0; kt_n_per_m = "
                                                  "5e4; gamma_t_kg_per_s = 0.05; gamma_b_kg_per_s = 0.1; "
                                                  "gamma_br_kg_per_s = 0.1;"};
    struct fixture f = fixture_pair(&options, 1e-6, v);
    struct particles *p = &f.sample->particles;
    int last = dimension - 1;
    p->v[last][0] = 0.5 * v;
    p->omega[0][1] = 30;
    time_step_forces_anew(f.sample);
    fixture_steps(&f, steps);
    assert_false(contact_list_slides(&f.sample->pairs, 0));
    for (int i = 0; i < 2; i++) {
        value[3 * i] = p->v[0][i];
        value[3 * i + 1] = p->v[last][i];
        value[3 * i + 2] = p->radius[i] * p->omega[dimension == 2 ? 0 : 1][i];
    }
    fixture_close(&f);
}

static double largest_difference(const double *a, const double *b)
{
    double largest = 0;
    for (int k = 0; k < OBLIQUE_VALUES; k++)
        largest = fmax(largest, fabs(a[k] - b[k]));
    return largest;
}

/* No closed form: differences between dt, dt/2 and dt/4 fall by 4. */
static void second_order_while_sticking(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        double a[OBLIQUE_VALUES], b[OBLIQUE_VALUES], c[OBLIQUE_VALUES];
        oblique(dimension, 64, a);
        oblique(dimension, 128, b);
        oblique(dimension, 256, c);
        double order = order_of(largest_difference(a, b), largest_difference(b, c));
        assert_close("order while sticking", order, 2, 0.15);
    }
}

/* Ledger residual over the kinetic energy of a collision that loads, turns, detaches along the adhesion branch and
 * opens. */
static double ledger_residual(int steps)
{
    struct measurement m;
    struct fixture_options options = {.dimension = 2,
                                      .dt_s = 3e-5 / steps,
                                      .material =
                                          "law = \"hysteretic\"; k1_n_per_m = 5e4; k2_n_per_m = 1e5; kc_n_per_m "
                                          "= 5e3; gamma_n_kg_per_s = 0.01;"};
    struct fixture f = fixture_pair(&options, 0, 0.1);
    double kinetic = energy_kinetic_j(sample_complete(f.sample)), approach;
    collide(&f, &approach);
    fixture_steps(&f, 1);
    must(measure(sample_complete(f.sample), &m));
    assert_true(m.kinetic_j < 0.9 * kinetic && f.sample->ledger.contacts.hysteresis > 0.3 * kinetic);
    assert_true(m.n_contacts == 0 && approach < 0);
    fixture_close(&f);
    return fabs(m.residual_j) / kinetic;
}

/* Between the kinks of the force the scheme is of second order; a kink or the opening within a step costs one step's
 * worth there, so that the whole is at least of first order: 16 times the steps leave at most 1/16 of the error. At 500
 * steps of omega dt = 0.01 it is of the order (omega dt)^2 = 1e-4. */
static void ledger_converges(void **state)
{
    double coarse = ledger_residual(500), fine = ledger_residual(8000);
    (void)state;
    print_message("ledger residual: %.3g at 500 steps, %.3g at 8000\n", coarse, fine);
    assert_true(coarse < 1e-4);
    assert_true(fine < coarse / 16);
}

/* Gross sliding against a wall [Chung & Ooi 2011]: e_t = 1 - mu (1 + e)/tan theta, a omega' = -(5/2) mu (1 + e) V_n.
 * The sphere comes at 60 degrees, mu = 0.1; at 0.1 it slides throughout. */
static void gross_sliding(void **state)
{
    const double vn = 0.05, vt = vn * tan(PI / 3), mu = 0.1;
    struct fixture_options options = {
        .dimension = 3, .count = 1, .dt_s = 1e-8, .material = "kn_n_per_m = 1e5; mu_s = 0.1; kt_n_per_m = 1e5;"};
    struct fixture f = fixture_open(&options);
    struct particles *p = &f.sample->particles;
    (void)state;
    p->x[2][0] = f.sample->walls[4].x + p->radius[0];
    p->v[0][0] = vt;
    p->v[2][0] = -vn;
    fixture_start(&f);
    fixture_steps(&f, 5000);
    assert_int_equal(f.sample->walls[4].force, 0);
    /* kt v_t > mu kn v_n: it slides from the first instant to the last but one, where the force goes to zero with
     * the spring. What sticks then is a part kt/kn v_n mu/v_t of the impulse; dt/t_c = 3e-4 at either end */
    assert_close("e", p->v[2][0] / vn, 1, 1e-3);
    assert_close("e_t", p->v[0][0] / vt, 1 - mu * 2 / tan(PI / 3), 1e-3);
    assert_close("spin", p->omega[1][0] * p->radius[0], 2.5 * mu * 2 * vn, 2e-3 * vn);
    fixture_close(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(collision_time),
        cmocka_unit_test(restitution),
        cmocka_unit_test(hysteretic_restitution),
        cmocka_unit_test(force_path),
        cmocka_unit_test(hysteresis_loss_is_the_area),
        cmocka_unit_test(second_order_in_a_contact),
        cmocka_unit_test(second_order_while_sticking),
        cmocka_unit_test(ledger_converges),
        cmocka_unit_test(gross_sliding),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
