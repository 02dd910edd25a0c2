/* Hertz-Mindlin contacts against closed forms: duration, overlap, restitution at any speed, a closed path of overlap
 * and way, and the energy ledger of impacts and of a sample. */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>

#include "sim/measure/measure.h"
#include "sim/sample/energy.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"

static const double PI = 3.14159265358979323846;
static const double E = 1e9, NU = 0.25, RADIUS = 1e-3, DENSITY = 2000;

static double e_star(void)
{
    return E / (2 * (1 - NU * NU));
}

static double reduced_mass(void)
{
    return 0.5 * 4.0 / 3.0 * PI * DENSITY * RADIUS * RADIUS * RADIUS;
}

/* Largest overlap and duration of an impact without loss of two equal spheres (Johnson 1985, section 11.4); the number
 * is 4 sqrt(pi) Gamma(2/5)/(5 Gamma(9/10)) (15/16)^(2/5) to all digits given. */
static double overlap_max(double speed)
{
    return pow(15 * reduced_mass() * speed * speed / (16 * e_star() * sqrt(0.5 * RADIUS)), 0.4);
}

static double duration(double speed)
{
    return 2.868265 * pow(reduced_mass() * reduced_mass() / (0.5 * RADIUS * e_star() * e_star() * speed), 0.2);
}

static struct fixture hertz_pair(int dimension, double restitution, double mu, double speed, double dt)
{
    char material[200];
    snprintf(material, sizeof material,
             "law = \"hertz\"; youngs_modulus_pa = %g; poisson_ratio = %g; restitution = %g; mu_s = %g;", E, NU,
             restitution, mu);
    const struct fixture_options options = {.dimension = dimension, .dt_s = dt, .material = material};
    return fixture_pair(&options, 0, speed);
}

/* Until the contact opens; the largest overlap and the time, by straight lines. */
static double collide(struct fixture *f, double *most)
{
    double before = 0, now = fixture_overlap(f), t = 0;
    const double dt = f->sample->dt;
    *most = 0;
    for (int k = 0; k < 100000 && (k < 2 || now > 0); k++) {
        before = now;
        fixture_steps(f, 1);
        now = fixture_overlap(f);
        *most = fmax(*most, now);
        t += dt;
    }
    return t - dt * now / (now - before);
}

static void impact_without_loss(void **state)
{
    (void)state;
    for (int n = 0; n < 4; n++) {
        const double speed = pow(10, n - 3), t = duration(speed);
        double most;
        struct fixture f = hertz_pair(3, 1, 0, speed, t / 1000);
        double now = collide(&f, &most);
        /* second order in dt; the line to the opening is off by less than a step's share of the slow end */
        assert_close("largest overlap / closed form", most / overlap_max(speed), 1, 1e-4);
        assert_close("duration / closed form", now / t, 1, 1e-4);
        assert_close("speed kept", -fixture_approach(&f) / speed, 1, 1e-4);
        fixture_close(&f);
    }
}

static void restitution_at_any_speed(void **state)
{
    (void)state;
    static const double asked[] = {0.95, 0.8, 0.5, 0.2};
    for (int k = 0; k < 4; k++)
        for (int n = 0; n < 5; n++) {
            const double speed = pow(10, n - 3);
            double most;
            struct fixture f = hertz_pair(n % 2 ? 3 : 2, asked[k], 0, speed, duration(speed) / 2000);
            (void)collide(&f, &most);
            assert_close("restitution", -fixture_approach(&f) / speed, asked[k], 1e-3);
            fixture_close(&f);
        }
}

static double residual_of(struct fixture *f)
{
    struct measurement m;
    must(measure(sample_complete(f->sample), &m));
    return m.residual_j;
}

/* Oblique impact of spheres that also slide and roll: the ledger closes, and the better the shorter the step. */
static void ledger_of_oblique_impacts(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        double residual[2];
        for (int k = 0; k < 2; k++) {
            const double speed = 0.1, dt = duration(speed) / (k ? 160 : 40);
            struct fixture f = hertz_pair(dimension, 0.7, 0.4, speed, dt);
            for (int i = 0; i < 2; i++)
                f.sample->particles.v[1][i] = (i ? -1 : 1) * 0.5 * speed;
            f.sample->ledger = energy_ledger_start(sample_complete(f.sample));
            const double start = energy_kinetic_j(sample_complete(f.sample));
            fixture_steps(&f, k ? 400 : 100);
            assert_true(fixture_overlap(&f) < 0);
            assert_true(f.sample->ledger.contacts.friction > 0);
            residual[k] = fabs(residual_of(&f)) / start;
            fixture_close(&f);
        }
        print_message("%dD: residual/energy %.2g, %.2g\n", dimension, residual[0], residual[1]);
        /* the jumps of the dashpot at both ends are of first order in dt times gamma u^2; measured 2e-4 at 40 steps */
        assert_true(residual[0] < 2e-3 && residual[1] < residual[0] / 3);
    }
}

/* The same in a stage without friction of a scene with friction: the tangential dashpot takes nothing either. */
static void ledger_without_friction_yet(void **state)
{
    (void)state;
    const double speed = 0.1;
    struct fixture f = hertz_pair(3, 0.7, 0.4, speed, duration(speed) / 160);
    const struct scene_material smooth = {
        .law = LAW_HERTZ, .youngs_modulus_pa = E, .poisson_ratio = NU, .restitution = 0.7};
    f.sample->law = contact_law_constants_of(&smooth, f.sample->pairs.model.normal);
    for (int i = 0; i < 2; i++)
        f.sample->particles.v[1][i] = (i ? -1 : 1) * 0.5 * speed;
    f.sample->ledger = energy_ledger_start(sample_complete(f.sample));
    const double start = energy_kinetic_j(sample_complete(f.sample));
    fixture_steps(&f, 400);
    assert_true(fixture_overlap(&f) < 0);
    assert_true(f.sample->ledger.contacts.viscous_tangential == 0 && f.sample->ledger.contacts.friction == 0);
    assert_true(fabs(residual_of(&f)) / start < 2e-3 / 9); /* as above, second order */
    fixture_close(&f);
}

/* Force of the contact on particle 1 along x and y. */
static void force_on_second(struct fixture *f, double *force)
{
    struct contact_measurement contact;
    assert_int_equal(measure_contacts(sample_complete(f->sample), &contact), 1);
    for (int c = 0; c < 2; c++)
        force[c] = -contact.normal_force_n * contact.normal[c] - contact.tangential_force_n[c];
}

/* Leads particle 1 by dx in n steps; returns the work done on the contact, by the trapezoidal rule. */
static double lead(struct fixture *f, const double *dx, int n)
{
    double before[2], after[2], work = 0;
    for (int c = 0; c < 2; c++)
        f->sample->particles.v[c][1] = dx[c] / (n * f->sample->dt);
    f->sample->kicked_s = 0;
    force_on_second(f, before);
    for (int k = 0; k < n; k++) {
        fixture_steps(f, 1);
        force_on_second(f, after);
        for (int c = 0; c < 2; c++) {
            work -= 0.5 * (before[c] + after[c]) * dx[c] / n;
            before[c] = after[c];
        }
    }
    return work;
}

/* Two spheres are led around a rectangle of overlap and way, in both directions, without sliding: no work is ever won,
 * and what is spent is what the contact holds more and what the ledger says that the changing stiffness took. */
static void closed_path_makes_no_energy(void **state)
{
    (void)state;
    static const int corner[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
    const double low = 1e-6, deep = 1e-6, way = 2e-8;
    enum { N = 4000 };
    for (int turn = 0; turn < 2; turn++) {
        struct fixture f = hertz_pair(3, 1, 100, 0, 1e-6);
        struct particles *p = &f.sample->particles;
        double work = 0;
        for (int i = 0; i < 2; i++)
            p->inv_mass[i] = p->inv_inertia[i] = 0;
        p->x[0][1] = p->x[0][0] + 2 * RADIUS - low;
        particles_set_views(p, f.sample->verlet.skin);
        time_step_forces_anew(f.sample);
        f.sample->ledger = energy_ledger_start(sample_complete(f.sample));
        const double start = energy_held(sample_complete(f.sample)).elastic_j;
        for (int side = 0; side < 4; side++) {
            const int *from = corner[turn ? 4 - side : side], *to = corner[turn ? 3 - side : side + 1];
            const double dx[2] = {-deep * (to[0] - from[0]), way * (to[1] - from[1])};
            work += lead(&f, dx, N);
        }
        const double held = energy_held(sample_complete(f.sample)).elastic_j - start;
        const double lost = f.sample->ledger.contacts.stiffness;
        print_message("turn %d: work %.4g J, held %.4g J, lost by the changing stiffness %.4g J\n", turn, work, held,
                      lost);
        assert_true(work > 0 && lost > 0);
        /* the ways are a few steps wide in their last digits, 1e-16/2e-8 each, and 4 N of them; the normal work of
         * 1e-8 J, of which 1e-3 of a step's part is left, is the larger one: 1e-8 (1/N)^2 */
        assert_close("work", work, held + lost, 1e-14);
        fixture_close(&f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(impact_without_loss),         cmocka_unit_test(restitution_at_any_speed),
        cmocka_unit_test(ledger_of_oblique_impacts),   cmocka_unit_test(ledger_without_friction_yet),
        cmocka_unit_test(closed_path_makes_no_energy),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
