/* Contacts whose k2 grows with the largest overlap (Luding 2008), and linear contacts with a given restitution, against
 * closed forms. */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>

#include "sim/measure/measure.h"
#include "sim/sample/energy.h"
#include "sim/sample/step_completion.h"

static const double PI = 3.14159265358979323846;
static const double RADIUS = 1e-3, DENSITY = 2000, K1 = 5e4, KP = 2e5;

static double mass(void)
{
    return 4.0 / 3.0 * PI * DENSITY * RADIUS * RADIUS * RADIUS;
}

/* Until the contact opens; the largest overlap on the way. */
static double collide(struct fixture *f)
{
    double most = 0, now = fixture_overlap(f);
    for (int k = 0; k < 1000000 && (k < 2 || now > 0); k++) {
        fixture_steps(f, 1);
        now = fixture_overlap(f);
        most = fmax(most, now);
    }
    return most;
}

static struct fixture pair_of(const char *law, double speed)
{
    char material[300];
    snprintf(material, sizeof material, "k1_n_per_m = %g; kp_n_per_m = %g; %s", K1, KP, law);
    const struct fixture_options options = {.dimension = 3, .dt_s = 2e-8, .material = material};
    return fixture_pair(&options, 0, speed);
}

/* Loaded along k1 delta, unloaded along k2(delta_max), e = sqrt(k1/k2), below delta_p and beyond it; k2 is reached at
 * the turning point, delta_max = v sqrt(m_ij/k1). */
static void restitution_follows_the_history(void **state)
{
    (void)state;
    const double phi_f = 0.05, reduced_radius = 0.5 * RADIUS;
    const double plastic = KP / (KP - K1) * phi_f * 2 * reduced_radius;
    static const double part[] = {0.1, 0.5, 0.9, 1.5};
    for (int k = 0; k < 4; k++) {
        const double speed = part[k] * plastic * sqrt(K1 / (0.5 * mass()));
        struct fixture f = pair_of("law = \"hysteretic\"; phi_f = 0.05;", speed);
        const double most = collide(&f), k2 = fmin(KP, K1 + (KP - K1) * most / plastic);
        assert_close("largest overlap / closed form", most / (part[k] * plastic), 1, 1e-4);
        /* the time step is 1/500 and less of the duration: (omega dt)^2/24 and what the last step passes beyond */
        assert_close("restitution", -fixture_approach(&f) / speed, sqrt(K1 / k2), 1e-4);
        fixture_close(&f);
    }
}

/* With adhesion, drawn apart and pushed together again: the ledger names what is lost. */
static void ledger_with_adhesion(void **state)
{
    (void)state;
    double residual[2];
    for (int k = 0; k < 2; k++) {
        char material[300];
        snprintf(material, sizeof material,
                 "law = \"elastoplastic\"; k1_n_per_m = %g; kp_n_per_m = %g; kc_n_per_m = %g; phi_f = 0.05;", K1, KP,
                 4 * K1);
        const struct fixture_options options = {.dimension = 2, .dt_s = k ? 2.5e-8 : 1e-7, .material = material};
        struct fixture f = fixture_pair(&options, 0, 1);
        const double start = 0.25 * mass();
        struct measurement m;
        fixture_steps(&f, k ? 8000 : 2000); /* swings many times, on all branches */
        assert_true(f.sample->ledger.contacts.hysteresis > 0.3 * start);
        must(measure(sample_complete(f.sample), &m));
        residual[k] = fabs(m.residual_j) / start;
        fixture_close(&f);
    }
    print_message("residual/energy %.2g, %.2g\n", residual[0], residual[1]);
    /* losses are exact functions of the history; what is left is the integrator's, (omega dt)^2/24 < 1e-4 */
    assert_true(residual[0] < 1e-4 && residual[1] < 1e-4);
}

/* e as asked for, also of two spheres of unequal size. */
static void linear_restitution(void **state)
{
    (void)state;
    static const double asked[] = {0.95, 0.5, 0.1};
    for (int k = 0; k < 3; k++)
        for (int unequal = 0; unequal < 2; unequal++) {
            char material[200];
            snprintf(material, sizeof material, "kn_n_per_m = %g; restitution = %g;", K1, asked[k]);
            const struct fixture_options options = {.dimension = 3, .dt_s = 1e-8, .material = material};
            struct fixture f = fixture_pair(&options, 0, 0.1);
            if (unequal) {
                struct particles *p = &f.sample->particles;
                fixture_close(&f);
                f = fixture_open(
                    &(struct fixture_options){.dimension = 3, .dt_s = 1e-8, .material = material, .count = 2});
                p = &f.sample->particles;
                p->radius[1] = 3 * RADIUS;
                for (int c = 0; c < 3; c++)
                    p->x[c][1] = p->x[c][0] + (c == 0 ? 4 * RADIUS : 0);
                p->v[0][0] = 0.1;
                fixture_start(&f);
            }
            (void)collide(&f);
            /* the line to the opening is off by a step's part of the way */
            assert_close("restitution", -fixture_approach(&f) / 0.1, asked[k], 1e-3);
            fixture_close(&f);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(restitution_follows_the_history),
        cmocka_unit_test(ledger_with_adhesion),
        cmocka_unit_test(linear_restitution),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
