/* What a run says about itself, against closed forms: the longest stable time step, the ledger's term of a change of
 * material, rest. */
#include "sim_fixture.h"

#include <math.h>

#include "sim/look/at_rest.h"
#include "sim/look/measure.h"
#include "sim/look/step_limit.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"

static const double STIFFNESS = 1e5, RADIUS = 1e-3;
static const double MASS = 4.0 / 3 * 3.14159265358979323846 * 2000 * 1e-9; /* of the fixture's particles */

/* The largest overlap with the floor, over that at rest, of a particle that starts a tenth off it. */
static double swing(double gamma, double dt_s)
{
    const double g = 1e4, rest = MASS * g / STIFFNESS; /* 8.4e-7 m */
    char material[128];
    snprintf(material, sizeof material, "kn_n_per_m = %g; gamma_n_kg_per_s = %g;", STIFFNESS, gamma);
    struct fixture_options options = {
        .dimension = 2, .count = 1, .dt_s = dt_s, .material = material, .more = "gravity_m_per_s2 = [0.0, 0.0, -1e4];"};
    struct fixture fixture = fixture_open(&options);
    struct particles *p = &fixture.sample->particles;
    const double floor_m = fixture.sample->walls[2].x;
    double largest = 0;
    p->x[1][0] = floor_m + RADIUS - 1.1 * rest;
    fixture_start(&fixture);
    for (int k = 0; k < 4000 && isfinite(largest); k++) {
        if (sample_step(fixture.sample) != STATUS_OK)
            largest = INFINITY; /* thrown through the floor */
        largest = fmax(largest, (RADIUS - (p->x[1][0] - floor_m)) / rest);
    }
    fixture_close(&fixture);
    return largest;
}

/* Two percent below the bound a swing about rest stays as small as it was (1.1; the discrete swing of a step that long
 * is at most 1/sqrt(1 - 0.98^2) = 5 times as wide: below 1.5), two above it grows until the contact opens. */
static void the_stable_step_is_where_a_contact_starts_to_grow(void **unused)
{
    static const double gammas[] = {0, 0.1, 1, 10};
    (void)unused;
    for (size_t k = 0; k < sizeof gammas / sizeof *gammas; k++) {
        const double lambda = gammas[k] / MASS, omega2 = STIFFNESS / MASS;
        const double bound = 2 / (lambda + sqrt(lambda * lambda + omega2));
        const double below = swing(gammas[k], 0.98 * bound), above = swing(gammas[k], 1.02 * bound);
        print_message("gamma = %g kg/s, bound %.3g s: %.3g below, %.3g above\n", gammas[k], bound, below, above);
        assert_true(below < 1.6);
        assert_true(above > 1.9);
    }
}

/* Particles of one size: two contacts along a line, on half of their mass: omega^2 = 4 k/m. */
static void the_limit_of_one_size_is_the_closed_form(void **unused)
{
    struct fixture_options options = {.dimension = 2, .count = 9, .dt_s = 1e-6, .material = "kn_n_per_m = 1e5;"};
    (void)unused;
    struct fixture fixture = fixture_open(&options);
    const struct step_limit limit = step_limit_of(fixture.sample, &fixture.scene->stage[0]);
    assert_true(fabs(limit.stable_s / sqrt(MASS / STIFFNESS) - 1) < 1e-12);
    assert_true(fabs(limit.contact_s / (3.14159265358979323846 * sqrt(MASS / (2 * STIFFNESS))) - 1) < 1e-12);
    assert_true(isinf(limit.wall_stable_s));
    must(step_limit_check(fixture.sample));
    fixture.scene->stage[0].dt_s = 1.001 * limit.stable_s;
    assert_int_equal(step_limit_check(fixture.sample), STATUS_CONFIG);
    fixture_close(&fixture);
}

/* A particle held by two walls at an overlap d each; the second stage doubles k. Twice k d^2/2 becomes twice as much,
 * so the jump is k d^2 = 1e-6 J, and nothing is missing in the ledger. */
static void the_ledger_names_a_change_of_material(void **unused)
{
    const double overlap = sqrt(1e-6 / STIFFNESS);
    (void)unused;
    struct fixture fixture = fixture_from_text(
        "dimension = 2;\n"
        "sample = { count = 1; radius_min_m = 1e-3; radius_max_m = 1e-3; density_kg_per_m3 = 2000.0; };\n"
        "stages = ( { name = \"a\"; dt_s = 1e-6; duration_s = 1e-5; material = { kn_n_per_m = 1e5; }; },\n"
        "  { name = \"b\"; dt_s = 1e-6; duration_s = 1e-5; material = { kn_n_per_m = 2e5; }; } );\n");
    struct sample *sample = fixture.sample;
    struct measurement m;
    sample->walls[0].x = sample->particles.x[0][0] - RADIUS + overlap;
    sample->walls[1].x = sample->particles.x[0][0] + RADIUS - overlap;
    must(sample_build_lists(sample));
    fixture_run(&fixture, 5);
    assert_true(sample->ledger.work_material == 0);
    fixture_run(&fixture, 15);
    assert_int_equal(sample->stage, 1);
    assert_true(fabs(sample->ledger.work_material / 1e-6 - 1) < 1e-9);
    must(measure(sample_complete(sample), &m));
    assert_true(fabs(m.residual_j) < 1e-9 * 1e-6);
    assert_true(fabs(measure_turnover_j(sample, &m) / 1e-6 - 1) < 1e-9);
    /* it rests: the forces of the walls cancel */
    const struct rest_figures rest = rest_figures_of(sample_complete(sample));
    assert_int_equal(rest.contacts, 2);
    assert_true(rest.energy_ratio < 1e-9 && rest.unbalanced_force < 1e-9);
    fixture_close(&fixture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_stable_step_is_where_a_contact_starts_to_grow),
        cmocka_unit_test(the_limit_of_one_size_is_the_closed_form),
        cmocka_unit_test(the_ledger_names_a_change_of_material),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
