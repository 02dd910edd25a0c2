/* What the normal dashpot may do where a contact opens (dashpot_pull), and which force limits friction
 * (friction_limit): impacts against closed forms, and the ledger. */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "sim/measure/measure.h"
#include "sim/measure/step_limit.h"
#include "sim/sample/contact_state.h"
#include "sim/sample/step_completion.h"

static const double PI = 3.14159265358979323846;
static const double K = 1e5, MU = 0.3, SPEED = 0.05, SLIDING = 5, STEPS = 4000;
static const char *const precision[] = {"", "precision = \"mixed\";"};

static const char *const option[] = {"", "dashpot_pull = \"none\";", "friction_limit = \"elastic\";",
                                     "dashpot_pull = \"none\"; friction_limit = \"elastic\";"};
enum { PAPERS, NO_PULL, ELASTIC, BOTH, OPTIONS };

static bool pulls(int choice)
{
    return choice == PAPERS || choice == ELASTIC;
}

static double mass(void)
{
    return 4.0 / 3.0 * PI * 2000 * 1e-9;
}

/* Of a sphere that meets a wall: e, the time until the overlap is 0 again, tangential over normal impulse, and the
 * ledger's residual over the energy of the approach. */
struct impact {
    double e, duration_s, ratio, residual;
};

/* A hundred times as fast along the wall, so that it slides from beginning to end. */
static struct impact impact_of(int dimension, const char *more, const char *material, double dt)
{
    const struct fixture_options options = {
        .dimension = dimension, .count = 1, .dt_s = dt, .material = material, .more = more};
    struct fixture f = fixture_open(&options);
    struct particles *p = &f.sample->particles;
    const int last = dimension - 1;
    struct measurement m;
    int steps = 0;
    p->x[last][0] = f.sample->walls[2 * last].x + p->radius[0];
    p->v[0][0] = SLIDING;
    p->v[last][0] = -SPEED;
    fixture_start(&f);
    do {
        fixture_steps(&f, 1);
        must(measure(sample_complete(f.sample), &m));
    } while (++steps < 100000 && p->x[last][0] - p->radius[0] < f.sample->walls[2 * last].x);
    assert_true(steps < 100000);
    struct impact result = {.e = p->v[last][0] / SPEED, .duration_s = steps * dt};
    result.ratio = (SLIDING - p->v[0][0]) / (p->v[last][0] + SPEED);
    result.residual = m.residual_j / (0.5 * mass() * SPEED * SPEED);
    fixture_close(&f);
    return result;
}

/* e where the overlap, or else the force, is 0 again: exp(-pi x), exp(-2 x atan(1/x)), x = zeta/sqrt(1 - zeta^2). */
static double restitution_of(bool pulling, double zeta)
{
    const double x = zeta / sqrt(1 - zeta * zeta);
    return exp(-x * (pulling ? PI : 2 * atan(1 / x)));
}

/* Until the overlap is 0: pi/omega; without pull the sphere flies on at e V from where the force is 0, gamma e V/k
 * deep.
 */
static double duration_of(bool pulling, double zeta)
{
    const double omega0 = sqrt(K / mass()), root = sqrt(1 - zeta * zeta);
    return (pulling ? PI : 2 * atan(root / zeta)) / (omega0 * root) + (pulling ? 0 : 2 * zeta / omega0);
}

/* J_t/(mu J_n), with e' where the force is 0: a limit of f_n >= 0 acts with m V (1 + e'), and J_n is m V (1 + e); one
 * of f_e with all of J_n, as the dashpot's impulse gamma delta is 0 between overlaps of 0, but for gamma^2 e' V/(2 k)
 * if the dashpot is held back on the way out. */
static double ratio_of(int choice, double zeta)
{
    const double e = restitution_of(true, zeta), free = restitution_of(false, zeta);
    static const double one = 1;
    return choice == PAPERS ? (1 + free) / (1 + e) : choice == BOTH ? 1 - 2 * zeta * zeta * free / (1 + free) : one;
}

/* First of them in time: the dashpot's jump at the start of a step, which may be all of it, 1/STEPS of the duration; it
 * changes e by 2 zeta omega dt. Friction that sticks until kt v t is mu gamma V, half of that on average: 2 zeta^2 mu
 * V/(SLIDING (1 + e)) of the impulse, at kt = k. */
static void impacts_on_a_wall(void **state)
{
    static const double zetas[] = {0.0335, 0.2155, 0.4559}; /* e = 0.9, 0.5, 0.2 of a dashpot that pulls */
    (void)state;
    for (int n = 0; n < 3 * OPTIONS * 4; n++) {
        const int choice = n / 4 % OPTIONS, way = n % 4;
        const double zeta = zetas[n / 4 / OPTIONS], late = 2 * PI / STEPS;
        const double e = restitution_of(pulls(choice), zeta), duration = duration_of(pulls(choice), zeta);
        char material[256];
        snprintf(material, sizeof material,
                 "kn_n_per_m = %.17e; gamma_n_kg_per_s = %.17e; mu_s = %.17e; kt_n_per_m = %.17e; %s", K,
                 2 * zeta * sqrt(K * mass()), MU, K, option[choice]);
        const struct impact i = impact_of(2 + way / 2, precision[way % 2], material, duration / STEPS);

        if (way == 2)
            print_message("zeta %.4f %-55s e %.4f, %.4f pi/omega_0, J_t/J_n %.4f, residual %.1g\n", zeta,
                          option[choice], i.e, i.duration_s / (PI * sqrt(mass() / K)), i.ratio, i.residual);
        assert_close("e", i.e, e, 2 * zeta * late);
        assert_close("duration", i.duration_s, duration, 3 * duration / STEPS);
        assert_close("J_t/(mu J_n)", i.ratio / MU, ratio_of(choice, zeta),
                     2 * zeta * zeta * MU * SPEED / SLIDING / (1 + e) + 2 * zeta * late);
        /* friction's power jumps at both ends, by mu gamma V SLIDING: half a step of that each; and 3e-5 of its work */
        const double work = 2 * MU * (1 + e) * SLIDING / SPEED;
        assert_true(fabs(i.residual) < work * (zeta * late + 5e-5));
    }
}

/* The e that is asked for comes out with either dashpot, of linear and of Hertz contacts, at any speed of these. e <
 * 0.14 without pull is beyond critical damping. */
static void restitution_is_kept(void **state)
{
    static const double asked[] = {0.9, 0.5, 0.2, 0.05};
    static const char *const law[] = {"kn_n_per_m = 1e5;",
                                      "law = \"hertz\"; youngs_modulus_pa = 1e9; poisson_ratio = 0.25;"};
    (void)state;
    for (int n = 0; n < 2 * 2 * 4; n++) {
        const double e = asked[n % 4], speed = 0.05, tc = n / 8 ? 3e-5 : PI * sqrt(mass() / 2 / K);
        char material[256];
        snprintf(material, sizeof material, "%s restitution = %.17e; %s", law[n / 8], e, option[n / 4 % 2]);
        const struct fixture_options options = {.dimension = 3, .dt_s = tc / STEPS, .material = material};
        struct fixture f = fixture_pair(&options, 1e-13, speed);
        for (int k = 0; k < 20 * STEPS && fixture_overlap(&f) > 0; k++)
            fixture_steps(&f, 1);
        assert_true(fixture_overlap(&f) <= 0);
        assert_close("restitution", -fixture_approach(&f) / speed, e, 2e-3);
        fixture_close(&f);
    }
}

/* Steps of dt_s = "auto" bear the dashpots that small e without pull need, far beyond critical damping: e = 0.01 asks
 * for zeta = 5, and steps of a twentieth of the contact would not do. */
static void auto_steps_bear_them(void **state)
{
    (void)state;
    for (int law = 0; law < 2; law++) {
        char text[512];
        snprintf(text, sizeof text,
                 "dimension = 2;\n"
                 "sample = { count = 2; radius_min_m = 1e-3; radius_max_m = 1e-3; density_kg_per_m3 = 2000.0; };\n"
                 "material = { %s restitution = 0.01; dashpot_pull = \"none\"; };\n"
                 "stages = ( { name = \"a\"; duration_s = 1e-3; } );\n",
                 law ? "law = \"hertz\"; youngs_modulus_pa = 1e9; poisson_ratio = 0.25;" : "kn_n_per_m = 1e5;");
        struct fixture f = fixture_from_text(text);
        const struct scene_stage *stage = &f.scene->stage[0];
        const struct step_limit limit = step_limit_of(f.sample, stage);
        print_message("law %d: auto %.3g s, the longest that holds %.3g s, t_c %.3g s\n", law, stage->dt_s,
                      limit.stable_s, limit.contact_s);
        assert_true(stage->dt_s < limit.stable_s);
        assert_true(limit.stable_s < limit.contact_s / 20); /* 1/(4 zeta omega), less by what other contacts add */
        fixture_close(&f);
    }
}

/* With cohesion the least force is -kc delta: a pair that parts fast. */
static void cohesion_is_left(void **state)
{
    double least[2] = {0};
    (void)state;
    for (int choice = PAPERS; choice <= NO_PULL; choice++) {
        char material[256];
        snprintf(
            material, sizeof material,
            "law = \"hysteretic\"; k1_n_per_m = 5e4; k2_n_per_m = 1e5; kc_n_per_m = 2e3; gamma_n_kg_per_s = 0.3; %s",
            option[choice]);
        const struct fixture_options options = {.dimension = 2, .dt_s = 1e-8, .material = material};
        struct fixture f = fixture_pair(&options, 1e-13, 0.3);
        for (int k = 0; k < 10000 && fixture_overlap(&f) > 0; k++) {
            struct contact_geometry g;
            struct contact_forces forces;
            fixture_steps(&f, 1);
            if (contact_state_at(sample_complete(f.sample), 0, 0, &g, &forces))
                least[choice] = fmin(least[choice], forces.normal + 2e3 * fixture_overlap(&f));
        }
        assert_true(fixture_overlap(&f) <= 0);
        fixture_close(&f);
    }
    print_message("least of f_n + kc delta: %.3g N, without pull %.3g N\n", least[PAPERS], least[NO_PULL]);
    assert_true(least[PAPERS] < -1e-3 && least[NO_PULL] > -1e-15);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(impacts_on_a_wall),
        cmocka_unit_test(restitution_is_kept),
        cmocka_unit_test(auto_steps_bear_them),
        cmocka_unit_test(cohesion_is_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
