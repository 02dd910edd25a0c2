/* What a run says about itself, against closed forms: the longest stable time step, the ledger's term of a change of
 * material, rest. */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>

#include "sim/measure/at_rest.h"
#include "sim/measure/measure.h"
#include "sim/measure/passing_watch.h"
#include "sim/measure/stability_watch.h"
#include "sim/measure/step_limit.h"
#include "sim/measure/strain_limit.h"
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

static const double HELD_J = 1e-6;

/* The first particle between the walls of x, at an overlap d each, where k d^2 is HELD_J; five steps. */
static void hold_between_walls(struct fixture *fixture)
{
    struct sample *sample = fixture->sample;
    const double overlap = sqrt(HELD_J / STIFFNESS);
    sample->walls[0].x = sample->particles.x[0][0] - RADIUS + overlap;
    sample->walls[1].x = sample->particles.x[0][0] + RADIUS - overlap;
    must(sample_build_lists(sample));
    fixture_run(fixture, 5);
}

/* A particle held by two walls at an overlap d each; the second stage doubles k. Twice k d^2/2 becomes twice as much,
 * so the jump is k d^2 = 1e-6 J, and nothing is missing in the ledger. */
static void the_ledger_names_a_change_of_material(void **unused)
{
    (void)unused;
    struct fixture fixture = fixture_from_text(
        "dimension = 2;\n"
        "sample = { count = 1; radius_min_m = 1e-3; radius_max_m = 1e-3; density_kg_per_m3 = 2000.0; };\n"
        "stages = ( { name = \"a\"; dt_s = 1e-6; duration_s = 1e-5; material = { kn_n_per_m = 1e5; }; },\n"
        "  { name = \"b\"; dt_s = 1e-6; duration_s = 1e-5; material = { kn_n_per_m = 2e5; }; } );\n");
    struct sample *sample = fixture.sample;
    struct measurement m;
    hold_between_walls(&fixture);
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

/* A particle that two walls hold at an overlap d each, k d^2 = 1e-6 J: work that shows nowhere is all that passed, and
 * is doubted, above 1 % of the scale, where it is more than 1e-5 of what is held, and not below. */
static void a_residual_is_held_against_what_passed_or_a_thousandth_of_what_is_held(void **unused)
{
    (void)unused;
    struct fixture_options options = {.dimension = 2, .count = 1, .dt_s = 1e-6, .material = "kn_n_per_m = 1e5;"};
    struct fixture fixture = fixture_open(&options);
    struct sample *sample = fixture.sample;
    struct measurement m;
    hold_between_walls(&fixture);
    const struct {
        double missing_j, ratio; /* of the residual to the scale */
    } cases[] = {{0.3e-5 * HELD_J, 0.003}, {3e-5 * HELD_J, 0.03}, {1e-3 * HELD_J, 1}, {0.1 * HELD_J, 1}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        must(measure(sample_complete(sample), &m));
        const double before_j = m.residual_j;
        sample->ledger.work_walls += cases[k].missing_j;
        must(measure(sample_complete(sample), &m));
        assert_true(fabs(fabs(m.residual_j - before_j) / cases[k].missing_j - 1) < 1e-6);
        assert_true(fabs(fabs(m.residual_j - before_j) / measure_ledger_scale_j(sample, &m) / cases[k].ratio - 1) <
                    1e-6);
        sample->ledger.work_walls -= cases[k].missing_j;
    }
    fixture_close(&fixture);
}

/* One disc in a box at rest in x: a strain e in z makes its solid fraction phi/(1 - e), and a disc bears
 * 1/(1 - 0.3/2)^2 = 1.384. */
static void a_strain_leaves_room(void **unused)
{
    struct fixture_options options = {.dimension = 2, .count = 1, .dt_s = 1e-6, .material = "kn_n_per_m = 1e5;"};
    (void)unused;
    struct fixture fixture = fixture_open(&options);
    struct scene_axis *axis = &fixture.scene->stage[0].axis[AXIS_Z];
    const double box = sample_box_length_m(fixture.sample, 0) * sample_box_length_m(fixture.sample, 1);
    const double bears = strain_limit_solid_fraction(2, 0.3);
    const double most = 1 - 3.14159265358979323846 * RADIUS * RADIUS / (bears * box);
    assert_true(fabs(bears / 1.3840830449826989 - 1) < 1e-12);
    axis->mode = WALL_STRAIN;
    axis->course = COURSE_SMOOTH;
    axis->frequency_hz = 1;
    axis->strain = most - 1e-6;
    must(strain_limit_check(fixture.sample, 0));
    axis->strain = most + 1e-6;
    assert_int_equal(strain_limit_check(fixture.sample, 0), STATUS_CONFIG);
    fixture.scene->stage[0].axis[AXIS_X].mode = WALL_STRESS; /* gives way */
    must(strain_limit_check(fixture.sample, 0));
    fixture.scene->stage[0].axis[AXIS_X].mode = WALL_FIXED;
    axis->until_strain = (struct config_band){.count = 1, .value = {0.1}}; /* may end sooner */
    must(strain_limit_check(fixture.sample, 0));
    fixture_close(&fixture);
}

/* Walls in z that are led away from a particle that they touched; walls in x that both move the same way. */
static void the_watch_sees_walls_that_leave_and_a_box_that_drifts(void **unused)
{
    struct fixture_options options = {.dimension = 2, .count = 1, .dt_s = 1e-6, .material = "kn_n_per_m = 1e5;"};
    struct stability_watch watch;
    (void)unused;
    struct fixture fixture = fixture_open(&options);
    struct sample *sample = fixture.sample;
    fixture_start(&fixture);
    struct scene_axis *axis = fixture.scene->stage[0].axis;
    const double length = sample_box_length_m(sample, 0);
    axis[AXIS_Z].mode = WALL_STRAIN;
    axis[AXIS_X].mode = WALL_STRESS;
    axis[AXIS_X].opposite = OPPOSITE_CONSTANT;
    stability_watch_start(&watch);
    must(stability_watch_look(&watch, sample, overlaps_of_fastest(sample), NULL));
    assert_true(watch.left[1] == 0 && watch.drift[0] == 0); /* not touched so far */
    sample->walls[2].touching = 1;
    must(stability_watch_look(&watch, sample, overlaps_of_fastest(sample), NULL));
    sample->walls[2].touching = 0;
    sample->walls[0].x += 0.1 * length;
    sample->walls[1].x += 0.1 * length;
    must(stability_watch_look(&watch, sample, overlaps_of_fastest(sample), NULL));
    must(stability_watch_look(&watch, sample, overlaps_of_fastest(sample), NULL));
    assert_true(watch.left[1] == 2 && watch.left[0] == 0);
    assert_true(fabs(watch.drift[0] - 0.1) < 1e-12 && watch.drift[1] == 0);
    fixture_close(&fixture);
}

/* Two particles of 1 mm that come at each other along x, their lines `apart` radii from each other; what passed within
 * three contact times, looked at as a run does. */
static int64_t passed_by(int dimension, const char *more, double speed, double apart)
{
    const double mean = 0.5 * MASS, dt = 3.14159265358979323846 * sqrt(mean / STIFFNESS) / 20;
    struct fixture_options options = {
        .dimension = dimension, .count = 2, .dt_s = dt, .material = "kn_n_per_m = 1e5;", .more = more};
    struct passing_watch watch = {0};
    struct largest_overlap largest;
    struct fixture fixture = fixture_open(&options);
    struct particles *p = &fixture.sample->particles;
    for (int c = 0; c < dimension; c++)
        for (int i = 0; i < 2; i++) {
            const double middle = 0.5 * (fixture.sample->walls[2 * c].x + fixture.sample->walls[2 * c + 1].x);
            p->x[c][i] = middle + (c == 0 ? (2 * i - 1) * 1.001 : c == 1 ? (2 * i - 1) * 0.5 * apart : 0) * RADIUS;
            p->v[c][i] = c == 0 ? (1 - 2 * i) * speed : 0;
        }
    for (int w = 0; w < fixture.sample->n_walls; w++)
        fixture.sample->walls[w].x += (w % 2 ? 1 : -1) * 0.1;
    fixture_start(&fixture);
    for (int k = 0; k < 60; k++) {
        must(sample_step_open(fixture.sample));
        must(overlaps_look(fixture.sample, &watch, &largest));
    }
    const int64_t passed = watch.passed;
    assert_true(passed == 0 || (watch.last[0] == 0 && watch.last[1] == 1));
    passing_watch_free(&watch);
    fixture_close(&fixture);
    return passed;
}

/* Head on, contacts hold up to an overlap of both radii: m v^2 = k (2 a)^2/2 at the middle, 2 a sqrt(k/(2 m)) = 155 m/s
 * each. A tenth of that bounces, also where the lines are most of a diameter apart and the normal turns as far as it
 * can; twice that goes through, once: straight on the normal turns by 2 acos(apart/2), beyond 90 degrees up to 1.41. */
static void particles_that_pass_through_each_other_are_seen(void **unused)
{
    const double through = 2 * RADIUS * sqrt(STIFFNESS / (2 * MASS));
    (void)unused;
    for (int kind = 0; kind < 4; kind++) {
        const int dimension = 2 + kind / 2;
        const char *precision = kind % 2 ? "precision = \"mixed\"; neighbor = { skin_ratio = 1.0; };" : "";
        for (double apart = 0; apart < 1.95; apart += 0.3)
            assert_int_equal(passed_by(dimension, precision, 0.1 * through, apart), 0);
        for (double apart = 0; apart < 1.25; apart += 0.3)
            assert_int_equal(passed_by(dimension, precision, 2 * through, apart), 1);
    }
}

/* Nothing in its way: x0 + v t. A step's way is rounded to float in mixed precision, 6e-8 of it, and to double
 * otherwise. */
static void fly(const char *precision, double skin_ratio, double part)
{
    char text[1024];
    snprintf(text, sizeof text,
             "dimension = 2; seed = 3; precision = \"%s\"; neighbor = { skin_ratio = %g; };\n"
             "sample = { count = 1; radius_min_m = 1e-3; radius_max_m = 1e-3; density_kg_per_m3 = 2000.0; "
             "speed_m_per_s = 10.0; gap_ratio = 100.0; };\n"
             "material = { kn_n_per_m = 1e5; };\nstages = ( { name = \"fly\"; dt_s = 1e-6; duration_s = 1.0; } );\n",
             precision, skin_ratio);
    struct fixture fixture = fixture_from_text(text);
    struct particles *p = &fixture.sample->particles;
    const double start[] = {p->x[0][0], p->x[1][0]}, v[] = {p->v[0][0], p->v[1][0]}, time_s = 500e-6;
    fixture_start(&fixture);
    fixture_steps(&fixture, 500);
    (void)sample_complete(fixture.sample);
    for (int c = 0; c < 2; c++) {
        assert_true(fabs(v[c]) > 0.1 && fabs(p->v[c][0] - v[c]) <= part * fabs(v[c]));
        assert_true(fabs(p->x[c][0] - start[c] - v[c] * time_s) < part * fabs(v[c]) * time_s);
    }
    fixture_close(&fixture);
}

static void free_flight_is_straight(void **unused)
{
    static const double skins[] = {0, 0.02, 1};
    (void)unused;
    for (int k = 0; k < 3; k++) {
        fly("double", skins[k], 500 * 0x1p-52 * 20); /* positions are up to 20 times the way */
        fly("mixed", skins[k], 0x1p-24);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_stable_step_is_where_a_contact_starts_to_grow),
        cmocka_unit_test(the_limit_of_one_size_is_the_closed_form),
        cmocka_unit_test(the_ledger_names_a_change_of_material),
        cmocka_unit_test(a_residual_is_held_against_what_passed_or_a_thousandth_of_what_is_held),
        cmocka_unit_test(a_strain_leaves_room),
        cmocka_unit_test(free_flight_is_straight),
        cmocka_unit_test(particles_that_pass_through_each_other_are_seen),
        cmocka_unit_test(the_watch_sees_walls_that_leave_and_a_box_that_drifts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
