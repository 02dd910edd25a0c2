/* Walls of a material of their own: impacts and sliding against closed forms, and what the keys say. */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim/law/contact_law.h"
#include "sim/measure/step_limit.h"

static const double PI = 3.14159265358979323846;
static const double G = 9.81, A = 1e-3; /* m/s^2; radius of the fixture's particles, m */

static double mass(void)
{
    return 4.0 / 3.0 * PI * 2000 * A * A * A;
}

/* One particle over the lower wall of the last axis by -overlap, with velocities along x and towards the wall. */
static struct fixture over_floor(int dimension, const char *material, const char *walls, double dt, double overlap,
                                 double vx, double vn)
{
    const struct fixture_options options = {
        .dimension = dimension, .count = 1, .dt_s = dt, .material = material, .more = walls};
    struct fixture f = fixture_open(&options);
    struct particles *p = &f.sample->particles;
    const int last = dimension - 1;
    p->x[last][0] = f.sample->walls[2 * last].x + A - overlap;
    p->v[0][0] = vx;
    p->v[last][0] = -vn;
    fixture_start(&f);
    return f;
}

struct impact {
    double duration_s, overlap_m, restitution; /* restitution over the speed before */
};

static struct impact impact_on_floor(int dimension, const char *material, const char *walls, double dt, double speed)
{
    struct fixture f = over_floor(dimension, material, walls, dt, 0, 0, speed);
    const struct particles *p = &f.sample->particles;
    const int last = dimension - 1;
    struct impact impact = {0};
    double now = 0, before = 0;
    for (int k = 0; k < 2 || now > 0; k++) {
        before = now;
        fixture_steps(&f, 1);
        now = A - (p->x[last][0] - f.sample->walls[2 * last].x);
        impact.overlap_m = fmax(impact.overlap_m, now);
        impact.duration_s += dt;
        assert_true(k < 100000);
    }
    impact.duration_s -= dt * now / (now - before);
    impact.restitution = p->v[last][0] / speed;
    fixture_close(&f);
    return impact;
}

/* The particles are ten times softer; the impact knows the wall's k alone: t = pi/omega, omega^2 = k/m - eta^2, e =
 * exp(-eta t). The dashpot jumps at both ends, of which a step's half is lost: eta dt = 3e-4 of the speed. */
static void linear_impact_has_the_walls_constants(void **state)
{
    (void)state;
    const double k = 1e5, eta = 0.1 * sqrt(k / mass()), t = PI / sqrt(k / mass() - eta * eta);
    char walls[200];
    snprintf(walls, sizeof walls, "walls = { material = { kn_n_per_m = 1e5; gamma_n_kg_per_s = %.17e; }; };",
             2 * eta * mass());
    for (int dimension = 2; dimension <= 3; dimension++) {
        struct impact own = impact_on_floor(dimension, "kn_n_per_m = 1e4;", walls, t / 1000, 0.01);
        assert_close("duration", own.duration_s / t, 1, 1e-4);
        assert_close("restitution", own.restitution, exp(-eta * t), 1e-3);
        struct impact without = impact_on_floor(dimension, "kn_n_per_m = 1e4;", "", t / 1000, 0.01);
        assert_close("of the particles", without.duration_s, PI * sqrt(mass() / 1e4), 1e-4 * without.duration_s);
    }
    struct impact asked = impact_on_floor(3, "kn_n_per_m = 1e5;",
                                          "walls = { z = { material = { restitution = 0.6; }; }; };", t / 1000, 0.01);
    assert_close("restitution asked for", asked.restitution, 0.6, 1e-3);
}

/* delta_max = (15 m V^2/(16 E* sqrt(a)))^(2/5), 1/E* = (1 - nu_i^2)/E_i + (1 - nu_w^2)/E_w; e as asked of the wall. */
static void hertz_impact_combines_both_sides(void **state)
{
    (void)state;
    static const char particles[] = "law = \"hertz\"; youngs_modulus_pa = 1e9; poisson_ratio = 0.25;",
                      walls[] = "walls = { material = { youngs_modulus_pa = 4e9; poisson_ratio = 0.4; }; };",
                      damped[] = "walls = { material = { youngs_modulus_pa = 4e9; restitution = 0.7; }; };";
    const double e_star = 1 / ((1 - 0.0625) / 1e9 + (1 - 0.16) / 4e9), speed = 0.1;
    const double deepest = pow(15 * mass() * speed * speed / (16 * e_star * sqrt(A)), 0.4);
    const double t = 2.868265 * pow(mass() * mass() / (A * e_star * e_star * speed), 0.2);
    struct impact impact = impact_on_floor(3, particles, walls, t / 1000, speed);
    assert_close("largest overlap / closed form", impact.overlap_m / deepest, 1, 1e-4);
    assert_close("duration / closed form", impact.duration_s / t, 1, 1e-4);
    assert_close("restitution", impact_on_floor(2, particles, damped, t / 2000, speed).restitution, 0.7, 1e-3);
}

/* E* and G* of two sides, from the elastic force and the tangential stiffness that the law makes of them. */
static void elastic_constants_of_two_sides(void **state)
{
    (void)state;
    struct scene *scene = fixture_scene_of(
        "dimension = 3;\nsample = { count = 1; radius_min_m = 1e-3; radius_max_m = 1e-3; density_kg_per_m3 = 2e3; };\n"
        "material = { law = \"hertz\"; youngs_modulus_pa = 7e10; poisson_ratio = 0.2; };\n"
        "walls = { y = { material = { youngs_modulus_pa = 2e11; poisson_ratio = 0.3; }; }; };\n"
        "stages = ( { name = \"a\"; dt_s = 1e-8; duration_s = 1.0; } );\n");
    const double e = 1 / ((1 - 0.04) / 7e10 + (1 - 0.09) / 2e11);
    const double g = 1 / (2 * 1.8 * 1.2 / 7e10 + 2 * 1.7 * 1.3 / 2e11);
    const struct contact_law_constants own = contact_law_constants_of_walls(&scene->stage[0], AXIS_Y, LAW_HERTZ),
                                       others = contact_law_constants_of_walls(&scene->stage[0], AXIS_X, LAW_HERTZ),
                                       pairs = contact_law_constants_of(&scene->stage[0].material, LAW_HERTZ);
    /* in the order of normal_hertz.h: E*, 8 G* */
    assert_close("E*", own.normal[0] / e, 1, 1e-14);
    assert_close("8 G*", own.normal[1] / (8 * g), 1, 1e-14);
    assert_memory_equal(others.normal, pairs.normal, sizeof pairs.normal);
    fixture_scene_free(scene);
}

/* A particle that slides on the floor slows down at mu g, with the mu of that wall. Exact while it slides. */
static double slowing(int dimension, const char *material, const char *walls)
{
    const double v0 = 0.5, dt = 1e-6;
    enum { STEPS = 5000 };
    struct fixture f = over_floor(dimension, material, walls, dt, mass() * G / 1e4, v0, 0);
    const struct particles *p = &f.sample->particles;
    f.sample->gravity[dimension - 1] = -G;
    fixture_steps(&f, STEPS); /* the weight came of a sudden: the swing is damped */
    const double before = p->v[0][0];
    fixture_steps(&f, STEPS);
    const double rate = (before - p->v[0][0]) / (STEPS * dt) / G;
    assert_true(contact_list_slides(&f.sample->walls[2 * (dimension - 1)].contacts, 0));
    fixture_close(&f);
    return rate;
}

static void friction_of_the_walls(void **state)
{
    (void)state;
    static const char grains[] = "kn_n_per_m = 1e4; gamma_n_kg_per_s = 0.2; mu_s = 0.3; kt_n_per_m = 2e3; "
                                 "wall_friction = 0.5;";
    static const char smooth[] = "kn_n_per_m = 1e4; gamma_n_kg_per_s = 0.2;";
    for (int dimension = 2; dimension <= 3; dimension++) {
        /* the swing: e^(-eta t), eta t = gamma/(2 m) 5e-3 s = 60 */
        assert_close("wall_friction", slowing(dimension, grains, ""), 0.15, 1e-9);
        assert_close("all walls", slowing(dimension, grains, "walls = { material = { mu_s = 0.2; }; };"), 0.2, 1e-9);
        assert_close(
            "this axis",
            slowing(dimension, grains,
                    "walls = { material = { mu_s = 0.2; }; z = { material = { mu_s = 0.4; mu_d = 0.35; }; }; };"),
            0.35, 1e-9);
        assert_close("another axis", slowing(dimension, grains, "walls = { x = { material = { mu_s = 0.4; }; }; };"),
                     0.15, 1e-9);
        assert_close("frictionless grains",
                     slowing(dimension, smooth, "walls = { material = { mu_s = 0.1; kt_n_per_m = 1e3; }; };"), 0.1,
                     1e-9);
    }
}

/* Stages take the walls' material over key by key, and give single keys back to the particles; the effective
 * configuration says the same again. */
static void stages_take_over(void **state)
{
    (void)state;
    struct scene *scene = fixture_scene_of(
        "dimension = 3;\nsample = { count = 1; radius_min_m = 1e-3; radius_max_m = 1e-3; density_kg_per_m3 = 2e3; };\n"
        "material = { kn_n_per_m = 1e5; kt_n_per_m = 2e4; mu_s = 0.5; mu_d = 0.4; wall_friction = 0.5; };\n"
        "walls = { material = { kn_n_per_m = 3e5; mu_s = 0.1; }; z = { material = { kn_n_per_m = 9e5; }; }; };\n"
        "stages = ( { name = \"a\"; duration_s = 1.0; },\n"
        "  { name = \"b\"; duration_s = 1.0; material = { kt_n_per_m = 3e4; };\n"
        "    walls = { material = { mu_s = \"particles\"; }; z = { material = { kn_n_per_m = \"particles\"; }; }; }; } "
        ");\n");
    struct scene_material m;
    assert_true(scene_wall_material(&scene->stage[0], AXIS_X, &m));
    assert_true(m.kn_n_per_m == 3e5 && m.mu_s == 0.1 && m.mu_d == 0.1 && m.kt_n_per_m == 2e4);
    assert_true(scene_wall_material(&scene->stage[0], AXIS_Z, &m));
    assert_true(m.kn_n_per_m == 9e5);
    assert_true(scene_wall_material(&scene->stage[1], AXIS_Z, &m));
    assert_true(m.kn_n_per_m == 3e5 && m.mu_s == 0.25 && m.mu_d == 0.2 && m.kt_n_per_m == 3e4);
    /* dt_s = "auto" follows the stiffest: three times as stiff, sqrt(3) times as short */
    assert_close("dt", scene->stage[0].dt_s / scene->stage[1].dt_s, sqrt(1.0 / 3), 1e-12);

    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    scene_print(out, scene);
    assert_int_equal(fclose(out), 0);
    struct scene *again = fixture_scene_of(text);
    for (int s = 0; s < 2; s++)
        for (int axis = 0; axis < SCENE_AXES; axis++) {
            struct scene_material before = {0}, after = {0};
            (void)scene_wall_material(&scene->stage[s], (enum axis)axis, &before);
            (void)scene_wall_material(&again->stage[s], (enum axis)axis, &after);
            assert_true(before.kn_n_per_m == after.kn_n_per_m && before.mu_s == after.mu_s &&
                        before.mu_d == after.mu_d && before.kt_n_per_m == after.kt_n_per_m);
        }
    free(text);
    fixture_scene_free(again);
    fixture_scene_free(scene);
}

/* Walls 100 times as stiff as the particles bear steps a tenth as long. */
static void stiff_walls_limit_the_step(void **state)
{
    (void)state;
    struct fixture_options options = {
        .dimension = 2, .count = 1, .dt_s = 1e-6, .material = "kn_n_per_m = 1e4;", .more = ""};
    struct fixture soft = fixture_open(&options);
    options.more = "walls = { z = { material = { kn_n_per_m = 1e6; }; }; };";
    struct fixture stiff = fixture_open(&options);
    const struct step_limit a = step_limit_of(soft.sample, &soft.scene->stage[0]),
                            b = step_limit_of(stiff.sample, &stiff.scene->stage[0]);
    assert_close("a tenth", a.stable_s / b.stable_s, 10, 1e-12);
    assert_true(a.contact_axis == '\0' && b.contact_axis == 'z');
    stiff.scene->stage[0].dt_s = 1.01 * b.stable_s;
    assert_int_equal(step_limit_check(stiff.sample), STATUS_CONFIG);
    assert_non_null(strstr(status_message(), "normal contacts of the smallest particles with the walls in z"));
    fixture_close(&soft);
    fixture_close(&stiff);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(linear_impact_has_the_walls_constants),
        cmocka_unit_test(hertz_impact_combines_both_sides),
        cmocka_unit_test(elastic_constants_of_two_sides),
        cmocka_unit_test(friction_of_the_walls),
        cmocka_unit_test(stages_take_over),
        cmocka_unit_test(stiff_walls_limit_the_step),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
