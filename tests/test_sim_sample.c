/* Many particles: what is conserved, the energy ledger, and stresses in equilibrium. */
#include "sim_fixture.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

#include "sim/base/random.h"
#include "sim/measure/measure.h"
#include "sim/sample/energy.h"
#include "sim/sample/step_completion.h"

/* ---- a free cluster ---- */

enum { CLUSTER = 12 };

/* Particles on a small lattice that fly at the middle, with spin, nothing else around. */
static struct fixture cluster(int dimension, bool friction)
{
    struct fixture_options options = {
        .dimension = dimension,
        .count = CLUSTER,
        .dt_s = 2e-7,
        .material = friction ? "law = \"hysteretic\"; k1_n_per_m = 5e4; k2_n_per_m = 1e5; kc_n_per_m = 5e4; "
                               "gamma_n_kg_per_s = 0.1; mu_s = 0.4; kt_n_per_m = 3e4; gamma_t_kg_per_s = 0.05;"
                             : "kn_n_per_m = 1e5; gamma_n_kg_per_s = 0.1;"};
    struct fixture f = fixture_open(&options);
    struct particles *p = &f.sample->particles;
    struct random random;
    random_init(&random, 5);
    for (int i = 0; i < CLUSTER; i++) {
        int at[3] = {i % 2, i / 2 % 2, i / 4};
        if (dimension == 2) {
            at[0] = i % 4;
            at[1] = i / 4;
        }
        for (int c = 0; c < dimension; c++) {
            double middle = 0.5 * (f.sample->walls[2 * c].x + f.sample->walls[2 * c + 1].x);
            p->x[c][i] = middle + 2.1e-3 * (at[c] - 1);
            p->v[c][i] = -500 * (p->x[c][i] - middle) + 0.1 * random_uniform(&random);
        }
        for (int c = 0; c < p->n_rotations; c++)
            p->omega[c][i] = 200 * (random_uniform(&random) - 0.5);
    }
    fixture_start(&f);
    return f;
}

/* Momentum, and the sum of |m v| as its scale. */
static void momentum(const struct particles *p, double *sum, double *scale)
{
    *scale = 0;
    for (int c = 0; c < p->dimension; c++) {
        sum[c] = 0;
        for (int i = 0; i < p->count; i++) {
            sum[c] += p->mass[i] * p->v[c][i];
            *scale += fabs(p->mass[i] * p->v[c][i]);
        }
    }
}

/* Rounding: in each step every particle's velocity takes a few roundings of forces that cancel in pairs; a force
 * changes momentum by at most the scale within tens of steps, so that steps x N x eps x scale is far on the safe side.
 */
static void momentum_is_conserved(void **state)
{
    enum { STEPS = 2000 };
    (void)state;
    for (int model = 0; model < 4; model++) {
        double before[3], after[3], scale, end_scale;
        struct fixture f = cluster(2 + model / 2, model % 2);
        double kinetic = energy_kinetic_j(sample_complete(f.sample));
        momentum(&f.sample->particles, before, &scale);
        fixture_steps(&f, STEPS);
        momentum(&f.sample->particles, after, &end_scale);
        assert_true(energy_kinetic_j(sample_complete(f.sample)) < 0.9 * kinetic); /* they did collide */
        for (int c = 0; c < f.sample->particles.dimension; c++)
            assert_close("momentum", after[c], before[c], STEPS * CLUSTER * DBL_EPSILON * scale);
        fixture_close(&f);
    }
}

/* a x b, component c of 3; in 2D the one component about x cross z. */
static double cross(const double *a, const double *b, int dimension, int c)
{
    if (dimension == 2)
        return a[0] * b[1] - a[1] * b[0];
    return a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

static double angular_momentum(const struct particles *p, int c)
{
    double sum = 0;
    for (int i = 0; i < p->count; i++) {
        double x[3] = {0}, v[3] = {0};
        for (int k = 0; k < p->dimension; k++) {
            x[k] = p->x[k][i];
            v[k] = p->v[k][i];
        }
        sum += p->mass[i] * cross(x, v, p->dimension, c) + p->omega[c][i] / p->inv_inertia[i];
    }
    return sum;
}

/* Sum of the sizes of the torques that contacts make. */
static double torque_sizes(struct sample *sample, int c)
{
    struct contact_measurement contacts[CLUSTER * CLUSTER];
    double sum = 0;
    int n = measure_contacts(sample_complete(sample), contacts);
    for (int k = 0; k < n; k++)
        sum += 2e-3 * fabs(cross(contacts[k].normal, contacts[k].tangential_force_n, sample->particles.dimension, c));
    return sum;
}

/* Lever arms add up to the distance of centres, so that a contact leaves no torque: angular momentum stays, to
 * rounding, whatever dt. */
static void angular_momentum_stays(void **state)
{
    enum { STEPS = 1000 };
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        struct fixture f = cluster(dimension, true);
        const struct particles *p = &f.sample->particles;
        for (int c = 0; c < p->n_rotations; c++) {
            double before = angular_momentum(p, c), turned = 0;
            for (int k = 0; k < STEPS; k++) {
                fixture_steps(&f, 1);
                turned += f.sample->dt * torque_sizes(f.sample, c);
            }
            /* x of about 0.2 m times m v of all: the terms that cancel */
            double scale = CLUSTER * p->mass[0] * 0.4 * 0.5, allowed = STEPS * CLUSTER * DBL_EPSILON * scale;
            assert_close("angular momentum", angular_momentum(p, c), before, allowed);
            if (c == 0) /* friction acted: an overlap's part of its torques, 1e-3, would be far above what is allowed */
                assert_true(1e-3 * turned > 10 * allowed);
        }
        fixture_close(&f);
    }
}

/* ---- a packed box ---- */

/* In 3D the walls are small: forces of the same order as in 2D. */
static double pressure_of(int dimension)
{
    return dimension == 2 ? 500 : 2e4;
}

/* 60 particles between four stress-controlled walls, in 3D six. */
static struct fixture box(int dimension, const char *material, double dt_s)
{
    char text[2048];
    char wall[256];
    snprintf(wall, sizeof wall,
             "{ mode = \"stress\"; pressure_pa = %g; mass_kg = 1e-4; damping_kg_per_s = 1.0; opposite = \"mirror\"; };",
             pressure_of(dimension));
    int length =
        snprintf(text, sizeof text,
                 "dimension = %d; seed = 2;\n"
                 "sample = { count = 60; radius_min_m = 0.5e-3; radius_max_m = 1.5e-3; density_kg_per_m3 = "
                 "2000.0; speed_m_per_s = 0.1; };\n"
                 "material = { %s };\n"
                 "walls = { x = %s z = %s %s%s };\n"
                 "stages = ( { name = \"a\"; dt_s = %.17e; duration_s = 100.0; } );\n",
                 dimension, material, wall, wall, dimension == 3 ? "y = " : "", dimension == 3 ? wall : "", dt_s);
    assert_true(length < (int)sizeof text);
    return fixture_from_text(text);
}

/* Work of all kinds in the ledger: the scale of its residual. */
static double work_scale(const struct sample *sample, const struct measurement *m)
{
    return fabs(sample->ledger.work_walls) + fabs(m->work_gravity_j) + sample->ledger.kinetic_start;
}

/* The whole ledger while a sample is compressed: every term is in use. dt is 1/36 of the shortest collision time, omega
 * dt = 0.09: the residual is of second order, of the order (omega dt)^2/12 = 7e-4 of what passes through the springs.
 */
static void ledger_of_a_compression(void **state)
{
    static const char *const material[] = {
        "law = \"hysteretic\"; k1_n_per_m = 5e4; k2_n_per_m = 1e5; kc_n_per_m = 1e4; gamma_n_kg_per_s = 0.1; mu_s = "
        "0.2; mu_d = 0.15; kt_n_per_m = 3e4; gamma_t_kg_per_s = 0.05; gamma_b_kg_per_s = 0.01; gamma_br_kg_per_s = "
        "0.01;",
        "kn_n_per_m = 1e5; gamma_n_kg_per_s = 0.1; gamma_b_kg_per_s = 0.01;"};
    (void)state;
    for (int model = 0; model < 4; model++) {
        struct measurement m;
        struct fixture f = box(2 + model / 2, material[model % 2], 2e-7);
        fixture_run(&f, 150000);
        must(measure(sample_complete(f.sample), &m));
        print_message("%dD model %d: residual/work %.2e, %d contacts, walls %.3g %.3g Pa\n", 2 + model / 2, model % 2,
                      m.residual_j / work_scale(f.sample, &m), m.n_contacts, m.stress_wall_pa[0], m.stress_wall_pa[1]);
        assert_true(m.n_contacts + m.n_wall_contacts > 60);
        assert_true(fabs(m.residual_j) < 1e-3 * work_scale(f.sample, &m));
        fixture_close(&f);
    }
}

/* (1/V) sum over wall contacts of -f (x) p, p the foot of the contact on its wall: what the walls exert from outside.
 */
static void stress_from_outside(struct sample *sample, double *stress)
{
    static struct contact_measurement contacts[4096];
    const struct particles *p = &sample->particles;
    const int dim = p->dimension, n = measure_contacts(sample_complete(sample), NULL);
    double volume = 1;
    assert_true(n <= 4096);
    measure_contacts(sample_complete(sample), contacts);
    for (int c = 0; c < dim; c++)
        volume *= sample_box_length_m(sample, c);
    for (int k = 0; k < dim * dim; k++) {
        const double *a = p->a[k / dim], *v = p->v[k / dim], *x = p->x[k % dim];
        stress[k] = 0;
        for (int i = 0; i < p->count; i++)
            stress[k] += (p->mass[i] * a[i] + sample->material->gamma_b_kg_per_s * v[i]) * x[i] / volume;
    }
    for (int k = 0; k < n; k++) {
        int w = -1 - contacts[k].j;
        if (w < 0)
            continue;
        for (int a = 0; a < dim; a++)
            for (int b = 0; b < dim; b++) {
                double foot = b == w / 2 ? sample->walls[w].x : p->x[b][contacts[k].i];
                double force = contacts[k].normal_force_n * contacts[k].normal[a] + contacts[k].tangential_force_n[a];
                stress[a * dim + b] -= force * foot / volume;
            }
    }
}

/* The contact stress (1/V) sum f (x) l balances what the walls exert, component by component; in equilibrium and
 * without friction on the walls its diagonal is force over area. The relaxation is strong enough for 1e-6. */
static void wall_stress_is_contact_stress(void **state)
{
    static const char *const material[] = {
        "kn_n_per_m = 1e5; gamma_n_kg_per_s = 0.3; gamma_b_kg_per_s = 0.1;",
        "law = \"hysteretic\"; k1_n_per_m = 5e4; k2_n_per_m = 1e5; kc_n_per_m = 1e4; gamma_n_kg_per_s = 0.3; mu_s = "
        "0.2; kt_n_per_m = 3e4; gamma_t_kg_per_s = 0.1; gamma_b_kg_per_s = 0.1; gamma_br_kg_per_s = 0.1;"};
    (void)state;
    for (int model = 0; model < 4; model++) {
        struct measurement m;
        int dim = 2 + model / 2;
        double outside[9], scale = 1e-6 * pressure_of(dim);
        struct fixture f = box(dim, material[model % 2], 1e-6);
        fixture_run(&f, 150000);
        must(measure(sample_complete(f.sample), &m));
        assert_true(m.n_contacts + m.n_wall_contacts > 60);
        stress_from_outside(f.sample, outside);
        for (int k = 0; k < dim * dim; k++)
            assert_close("stress", m.stress_contact_pa[k], outside[k], scale);
        for (int c = 0; c < dim; c++) {
            assert_close("target", m.stress_wall_pa[c], pressure_of(dim), scale);
            if (model % 2 == 0)
                assert_close("wall stress", m.stress_contact_pa[c * dim + c], m.stress_wall_pa[c], scale);
        }
        fixture_close(&f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(momentum_is_conserved),
        cmocka_unit_test(angular_momentum_stays),
        cmocka_unit_test(ledger_of_a_compression),
        cmocka_unit_test(wall_stress_is_contact_stress),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
