/* No hidden scales: a scene in other units of length, mass and time, powers of two of them, is the same scene, and what
 * comes out is the same in every digit; and what contacts remember of friction where there is none. */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "sim/look/measure.h"
#include "sim/sample/step_completion.h"

/* Powers of two: one unit of length is 2^length m, and so on. */
struct units {
    int length, mass, time;
};

static double in(const struct units *u, double value, int length, int mass, int time)
{
    return ldexp(value, u->length * length + u->mass * mass + u->time * time);
}

/* Balls of about 1 mm fall together and are pressed, sheared and rolled between walls. */
static struct fixture scene_in(const struct units *u, int dimension, const char *precision)
{
    char text[4096], walls[1024];
    const double pressure = in(u, dimension == 2 ? 200 : 1e5, dimension == 2 ? 0 : -1, 1, -2);
    const double heavy = in(u, 1e-4, 0, 1, 0), damping = in(u, 0.5, 0, 1, -1), dt = in(u, 2e-6, 0, 0, 1);
    snprintf(walls, sizeof walls,
             "{ mode = \"stress\"; pressure_pa = %.17e; mass_kg = %.17e; damping_kg_per_s = %.17e; }", pressure, heavy,
             damping);
    int length = snprintf(
        text, sizeof text,
        "dimension = %d; seed = 7; precision = \"%s\";\n"
        "sample = { count = 60; radius_min_m = %.17e; radius_max_m = %.17e; density_kg_per_m3 = %.17e;\n"
        "  speed_m_per_s = %.17e; };\n"
        "material = { law = \"linear\"; kn_n_per_m = %.17e; gamma_n_kg_per_s = %.17e; mu_s = 0.5; kt_n_per_m = %.17e;\n"
        "  gamma_t_kg_per_s = %.17e; gamma_b_kg_per_s = %.17e; };\n"
        "walls = { x = %s; z = %s; %s %s };\n"
        "stages = ( { name = \"confine\"; dt_s = %.17e; duration_s = %.17e; },\n"
        "  { name = \"test\"; dt_s = %.17e; duration_s = %.17e; walls = { z = { mode = \"strain\"; strain = 0.05;\n"
        "    frequency_hz = %.17e; }; }; } );\n",
        dimension, precision, in(u, 0.5e-3, 1, 0, 0), in(u, 1.5e-3, 1, 0, 0), in(u, 2000, -3, 1, 0),
        in(u, 0.3, 1, 0, -1), in(u, 5e4, 0, 1, -2), in(u, 0.1, 0, 1, -1), in(u, 2e4, 0, 1, -2), in(u, 0.02, 0, 1, -1),
        in(u, 0.01, 0, 1, -1), walls, walls, dimension == 3 ? "y =" : "", dimension == 3 ? walls : "", dt, 6000 * dt,
        dt, 6000 * dt, 1 / (12000 * dt));
    assert_true(length > 0 && length < (int)sizeof text);
    return fixture_from_text(text);
}

/* What is compared, each in units of the first scene. */
enum { LENGTH_X, LENGTH_Z, STRESS_X, STRESS_Z, KINETIC, ELASTIC, TANGENTIAL, FRICTION, SLIDING, VALUES };

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
    value[SLIDING] = m.sliding_fraction;
}

enum { LOOKS = 12 };

static void curves(const struct units *u, int dimension, const char *precision, double curve[LOOKS][VALUES])
{
    struct fixture f = scene_in(u, dimension, precision);
    for (int k = 0; k < LOOKS; k++) {
        fixture_run(&f, 1000 * (k + 1));
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

static const struct units units[] = {{-10, -30, -9}, {-18, -54, -18}};

static void same_in_other_units(const char *precision, double allowed)
{
    const struct units si = {0, 0, 0};
    for (int dimension = 2; dimension <= 3; dimension++) {
        double curve[LOOKS][VALUES], other[LOOKS][VALUES];
        curves(&si, dimension, precision, curve);
        assert_true(curve[LOOKS - 1][FRICTION] > 0.1 * curve[LOOKS - 1][ELASTIC]);
        for (size_t k = 0; k < sizeof units / sizeof *units; k++) {
            curves(&units[k], dimension, precision, other);
            const double apart = difference(curve, other);
            print_message("%s, %dD, units 2^%d m, 2^%d kg, 2^%d s: %.2g apart\n", precision, dimension, units[k].length,
                          units[k].mass, units[k].time, apart);
            assert_true(apart <= allowed);
        }
    }
}

static void same_in_double(void **state)
{
    (void)state;
    same_in_other_units("double", 0);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(friction_starts_from_nothing),
        cmocka_unit_test(same_in_double),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
