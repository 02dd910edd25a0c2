/* No hidden scales: a scene in other units of length, mass and time, powers of two of them, is the same scene, and what
 * comes out is the same in every digit; and what contacts remember of friction where there is none. */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "sim/measure/measure.h"
#include "sim/sample/step_completion.h"

/* Powers of two: one unit of length is 2^length m, and so on. */
struct units {
    int length, mass, time;
};

static double in(const struct units *u, double value, int length, int mass, int time)
{
    return ldexp(value, u->length * length + u->mass * mass + u->time * time);
}

static const char *const materials[] = {
    "law = \"linear\"; kn_n_per_m = 5e4; gamma_n_kg_per_s = 0.1; mu_s = 0.5; kt_n_per_m = 2e4; gamma_t_kg_per_s = "
    "0.02;\n"
    "  mu_rolling = 0.1; kr_n_per_m = 1e4; gamma_r_kg_per_s = 0.01; mu_torsion = 0.1; ko_n_per_m = 1e4;\n"
    "  gamma_o_kg_per_s = 0.01; gamma_b_kg_per_s = 0.01; gamma_br_kg_per_s = 0.005;",
    "law = \"hysteretic\"; k1_n_per_m = 3e4; k2_n_per_m = 5e4; kc_n_per_m = 1e4; gamma_n_kg_per_s = 0.1; mu_s = 0.5;\n"
    "  kt_n_per_m = 2e4; gamma_t_kg_per_s = 0.02; gamma_b_kg_per_s = 0.01; dashpot_pull = \"none\";",
    "law = \"hertz\"; youngs_modulus_pa = 1e8; poisson_ratio = 0.25; restitution = 0.6; mu_s = 0.5;\n"
    "  gamma_b_kg_per_s = 0.01;"};

/* Balls of about 1 mm fall together and are pressed, sheared and rolled between walls. */
static struct scene *scene_of(int dimension, const char *precision, const char *material)
{
    char text[4096], walls[256];
    snprintf(walls, sizeof walls, "{ mode = \"stress\"; pressure_pa = %g; mass_kg = 1e-4; damping_kg_per_s = 0.5; }",
             dimension == 2 ? 200 : 1e5);
    int length = snprintf(
        text, sizeof text,
        "dimension = %d; seed = 7; precision = \"%s\";\n"
        "sample = { count = 60; radius_min_m = 0.5e-3; radius_max_m = 1.5e-3; density_kg_per_m3 = 2000.0;\n"
        "  speed_m_per_s = 0.3; };\n"
        "gravity_m_per_s2 = [0.0, 0.0, -9.81];\n"
        "material = { %s };\n"
        "walls = { x = %s; z = %s; %s %s };\n"
        "stages = ( { name = \"confine\"; dt_s = 2e-6; duration_s = 6e-3; },\n"
        "  { name = \"test\"; dt_s = 2e-6; duration_s = 6e-3; walls = { z = { mode = \"strain\"; strain = 0.05;\n"
        "    frequency_hz = 82.0; }; }; } );\n",
        dimension, precision, material, walls, walls, dimension == 3 ? "y =" : "", dimension == 3 ? walls : "");
    assert_true(length > 0 && length < (int)sizeof text);
    return fixture_scene_of(text);
}

static void material_in(const struct units *u, struct scene_material *m)
{
    double *const stiffness[] = {&m->kn_n_per_m, &m->k1_n_per_m, &m->k2_n_per_m, &m->kc_n_per_m,
                                 &m->kp_n_per_m, &m->kt_n_per_m, &m->kr_n_per_m, &m->ko_n_per_m};
    double *const damping[] = {&m->gamma_n_kg_per_s, &m->gamma_t_kg_per_s, &m->gamma_r_kg_per_s,
                               &m->gamma_o_kg_per_s, &m->gamma_b_kg_per_s, &m->gamma_br_kg_per_s};
    for (size_t k = 0; k < sizeof stiffness / sizeof *stiffness; k++)
        *stiffness[k] = in(u, *stiffness[k], 0, 1, -2);
    for (size_t k = 0; k < sizeof damping / sizeof *damping; k++)
        *damping[k] = in(u, *damping[k], 0, 1, -1);
    m->youngs_modulus_pa = in(u, m->youngs_modulus_pa, -1, 1, -2);
}

static void axis_in(const struct units *u, int of_stress, struct scene_axis *axis)
{
    axis->pressure_pa = in(u, axis->pressure_pa, of_stress, 1, -2);
    axis->mass_kg = in(u, axis->mass_kg, 0, 1, 0);
    axis->damping_kg_per_s = in(u, axis->damping_kg_per_s, 0, 1, -1);
    axis->frequency_hz = in(u, axis->frequency_hz, 0, 0, -1);
}

/* The scene in other units, also such as keys do not allow: sizes and densities that nothing has. */
static struct fixture scene_in(const struct units *u, int dimension, const char *precision, const char *material)
{
    struct fixture f = {.scene = scene_of(dimension, precision, material)};
    struct scene_sample *s = &f.scene->sample;
    double *const length[] = {&s->radius_min_m, &s->radius_max_m, &s->mean_radius_m};
    for (int k = 0; k < 3; k++)
        *length[k] = in(u, *length[k], 1, 0, 0);
    s->mean_cube_m3 = in(u, s->mean_cube_m3, 3, 0, 0);
    s->density_kg_per_m3 = in(u, s->density_kg_per_m3, -3, 1, 0);
    s->speed_m_per_s = in(u, s->speed_m_per_s, 1, 0, -1);
    for (int c = 0; c < f.scene->gravity_m_per_s2.count; c++)
        f.scene->gravity_m_per_s2.value[c] = in(u, f.scene->gravity_m_per_s2.value[c], 1, 0, -2);
    for (int k = 0; k < f.scene->n_stages; k++) {
        struct scene_stage *stage = &f.scene->stage[k];
        stage->dt_s = in(u, stage->dt_s, 0, 0, 1);
        stage->duration_s = in(u, stage->duration_s, 0, 0, 1);
        material_in(u, &stage->material);
        for (int axis = 0; axis < SCENE_AXES; axis++)
            axis_in(u, dimension == 2 ? 0 : -1, &stage->axis[axis]);
    }
    must(sample_create(&f.sample, f.scene));
    return f;
}

/* What is compared, each in units of the first scene. */
enum { LENGTH_X, LENGTH_Z, STRESS_X, STRESS_Z, KINETIC, ELASTIC, TANGENTIAL, FRICTION, DAMPED, SLIDING, VALUES };

static void look(struct fixture *f, const struct units *u, double *value)
{
    struct measurement m;
    must(measure(sample_complete(f->sample), &m));
    const int last = f->sample->particles.dimension - 1, of_stress = last == 1 ? 0 : 1;
    value[LENGTH_X] = in(u, m.box_length_m[0], -1, 0, 0);
    value[LENGTH_Z] = in(u, m.box_length_m[last], -1, 0, 0);
    value[STRESS_X] = in(u, m.stress_wall_pa[0], of_stress, -1, 2);
    value[STRESS_Z] = in(u, m.stress_wall_pa[last], of_stress, -1, 2);
    value[KINETIC] = in(u, m.kinetic_j, -2, -1, 2);
    value[ELASTIC] = in(u, m.elastic_normal_j, -2, -1, 2);
    value[TANGENTIAL] = in(u, m.elastic_tangential_j, -2, -1, 2);
    value[FRICTION] = in(u, f->sample->ledger.contacts.friction, -2, -1, 2);
    value[DAMPED] = in(u, f->sample->ledger.contacts.viscous_normal + f->sample->ledger.background, -2, -1, 2);
    value[SLIDING] = m.sliding_fraction;
}

enum { LOOKS = 12 };

static void curves(const struct units *u, int dimension, const char *precision, const char *material,
                   double curve[LOOKS][VALUES])
{
    struct fixture f = scene_in(u, dimension, precision, material);
    for (int k = 0; k < LOOKS; k++) {
        fixture_run(&f, 500 * (k + 1));
        look(&f, u, curve[k]);
    }
    fixture_close(&f);
}

/* The largest difference of each curve over its largest value. */
static double difference(double a[LOOKS][VALUES], double b[LOOKS][VALUES])
{
    double worst = 0;
    for (int v = 0; v < VALUES; v++) {
        double largest = 0, apart = 0;
        for (int k = 0; k < LOOKS; k++) {
            assert_true(isfinite(a[k][v]) && isfinite(b[k][v]));
            largest = fmax(largest, fabs(a[k][v]));
            apart = fmax(apart, fabs(a[k][v] - b[k][v]));
        }
        assert_true(largest > 0);
        worst = fmax(worst, apart / largest);
    }
    return worst;
}

/* The corners of the cube of exponents from -30 to 30 and the middles of its sides; some odd ones for laws without
 * roots of dimensions. */
static void same_in_other_units(const char *precision, double allowed)
{
    static const struct units some[] = {{0, 0, 30},  {0, 0, -30},    {0, 30, 0},      {0, -30, 0},  {30, 0, 0},
                                        {-30, 0, 0}, {-10, -30, -9}, {-18, -54, -18}, {7, -11, 13}, {-3, 5, -1}};
    const struct units si = {0, 0, 0};
    enum { CORNERS = 8, SOME = sizeof some / sizeof *some };
    for (int n = 0; n < 6; n++) {
        const int dimension = 2 + n % 2, law = n / 2, count = CORNERS + (law < 2 ? SOME : 0);
        double curve[LOOKS][VALUES], other[LOOKS][VALUES], worst = 0;
        curves(&si, dimension, precision, materials[law], curve);
        assert_true(curve[LOOKS - 1][FRICTION] > 0.1 * curve[LOOKS - 1][ELASTIC]);
        for (int k = 0; k < count; k++) {
            const struct units corner = {k & 1 ? 30 : -30, k & 2 ? 30 : -30, k & 4 ? 30 : -30},
                               u = k < CORNERS ? corner : some[k - CORNERS];
            curves(&u, dimension, precision, materials[law], other);
            const double apart = difference(curve, other);
            if (apart > allowed)
                print_message("%s, %dD, %.20s, units 2^%d m, 2^%d kg, 2^%d s: %.2g apart\n", precision, dimension,
                              materials[law], u.length, u.mass, u.time, apart);
            worst = fmax(worst, apart);
        }
        print_message("%s, %dD, %.20s: at most %.2g apart in %d systems of units\n", precision, dimension,
                      materials[law], worst, count);
        assert_true(worst <= allowed);
    }
}

static void same_in_double(void **state)
{
    (void)state;
    same_in_other_units("double", 0);
}

static void same_in_mixed(void **state)
{
    (void)state;
    same_in_other_units("mixed", 0);
}

/* ---- friction that is switched on ---- */

static const char switched_on[] =
    "dimension = 2; seed = 7;\n"
    "sample = { count = 60; radius_min_m = 0.5e-3; radius_max_m = 1.5e-3; density_kg_per_m3 = 2000.0;\n"
    "  speed_m_per_s = 0.3; };\n"
    "material = { law = \"linear\"; kn_n_per_m = 5e4; gamma_n_kg_per_s = 0.1; gamma_b_kg_per_s = 0.02; %s };\n"
    "walls = { x = { mode = \"stress\"; pressure_pa = 100.0; mass_kg = 1e-4; damping_kg_per_s = 1.0; };\n"
    "          z = { mode = \"stress\"; pressure_pa = 100.0; mass_kg = 1e-4; damping_kg_per_s = 1.0; }; };\n"
    "stages = ( { name = \"confine\"; dt_s = 1e-6; duration_s = 6e-3; },\n"
    "  { name = \"hold\"; dt_s = 1e-6; duration_s = 1e-3;\n"
    "    material = { mu_s = 0.5; kt_n_per_m = 2e4; gamma_t_kg_per_s = %s; }; } );\n";

/* A stage without friction has no springs, whatever its kt: friction starts from nothing. Before, most contacts slid as
 * soon as it was on, from springs that had grown all the way from the first contact, and the ledger was off by more
 * than all the energy there is. */
static void friction_starts_from_nothing(void **state)
{
    static const char *const before[] = {"", "kt_n_per_m = 2e4;"}, *const damping[] = {"0.0", "0.02"};
    double x[2][2];
    (void)state;
    for (int k = 0; k < 4; k++) {
        char text[2048];
        snprintf(text, sizeof text, switched_on, before[k % 2], damping[k / 2]);
        struct fixture f = fixture_from_text(text);
        struct measurement m;
        fixture_run(&f, 5999);
        must(measure(sample_complete(f.sample), &m));
        assert_true(m.n_contacts > 50 && m.elastic_tangential_j == 0 && m.sliding_fraction == 0);
        for (int c = 0; c < f.sample->pairs.count; c++)
            assert_true(contact_list_spring(&f.sample->pairs, 0, c) == 0);
        fixture_run(&f, 6020);
        must(measure(sample_complete(f.sample), &m));
        print_message("friction on, kt before: '%s', gamma_t %s: %.3f slide\n", before[k % 2], damping[k / 2],
                      m.sliding_fraction);
        assert_true(m.sliding_fraction < 0.05);
        fixture_run(&f, 7000);
        must(measure(sample_complete(f.sample), &m));
        assert_true(fabs(m.residual_j) < 1e-2 * measure_turnover_j(f.sample, &m));
        x[k / 2][k % 2] = f.sample->particles.x[0][0];
        fixture_close(&f);
    }
    assert_true(x[0][0] == x[0][1] && x[1][0] == x[1][1] && x[0][0] != x[1][0]);
}

/* A stage that switches friction off takes what its springs hold, and one that makes contacts stiffer adds to what they
 * hold: the ledger has both as work of the material, and closes. */
static void material_that_changes(void **state)
{
    static const char *const first[] = {"law = \"linear\"; kn_n_per_m = 5e4; gamma_n_kg_per_s = 0.1; kt_n_per_m = 2e4;",
                                        "law = \"hertz\"; youngs_modulus_pa = 1e8; poisson_ratio = 0.25;"},
                             *const second[] = {"kn_n_per_m = 6e4; kt_n_per_m = 0.0;", "youngs_modulus_pa = 1.2e8;"};
    (void)state;
    for (int n = 0; n < 4; n++) {
        char text[2048];
        snprintf(
            text, sizeof text,
            "dimension = 2; seed = 7; precision = \"%s\";\n"
            "sample = { count = 60; radius_min_m = 0.5e-3; radius_max_m = 1.5e-3; density_kg_per_m3 = 2000.0;\n"
            "  speed_m_per_s = 0.3; };\n"
            "material = { %s mu_s = 0.5; gamma_b_kg_per_s = 0.02; };\n"
            "walls = { x = { mode = \"stress\"; pressure_pa = 100.0; mass_kg = 1e-4; damping_kg_per_s = 1.0; };\n"
            "          z = { mode = \"stress\"; pressure_pa = 100.0; mass_kg = 1e-4; damping_kg_per_s = 1.0; }; };\n"
            "stages = ( { name = \"rough\"; dt_s = 1e-6; duration_s = 6e-3; },\n"
            "  { name = \"smooth\"; dt_s = 1e-6; duration_s = 2e-3; material = { mu_s = 0.0; %s }; } );\n",
            n % 2 ? "mixed" : "double", first[n / 2], second[n / 2]);
        struct fixture f = fixture_from_text(text);
        struct measurement before, after;
        fixture_run(&f, 6000);
        must(measure(sample_complete(f.sample), &before));
        assert_true(before.elastic_tangential_j > 1e-3 * before.elastic_normal_j);
        fixture_run(&f, 6001);
        /* linear: energies of springs go with k at the same overlaps; Hertz: with E */
        const double grown = 0.2 * before.elastic_normal_j, work = f.sample->ledger.work_material;
        assert_close("work of the material", work, grown - before.elastic_tangential_j, 1e-5 * grown);
        fixture_run(&f, 8000);
        must(measure(sample_complete(f.sample), &after));
        print_message("%s, %s: friction's springs held %.3g J, contacts get %.3g J; residual %.2g of the turnover\n",
                      n / 2 ? "hertz" : "linear", n % 2 ? "mixed" : "double", before.elastic_tangential_j, grown,
                      after.residual_j / measure_turnover_j(f.sample, &after));
        assert_true(after.elastic_tangential_j == 0);
        assert_true(fabs(after.residual_j) < 1e-2 * measure_turnover_j(f.sample, &after));
        fixture_close(&f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(friction_starts_from_nothing),
        cmocka_unit_test(material_that_changes),
        cmocka_unit_test(same_in_double),
        cmocka_unit_test(same_in_mixed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
