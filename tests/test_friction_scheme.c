/* The scheme of friction (docs/theory.md): sticking contacts neither gain nor lose, springs turn with their pairs, the
 * ledger closes without any damping of friction, and impacts are at least as accurate as with a plain leapfrog. */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "sim/base/random.h"
#include "sim/lanes/lanes_reference.h"
#include "sim/measure/measure.h"
#include "sim/sample/step_completion.h"

static const double PI = 3.14159265358979323846;
static const char *const precision[] = {"", "precision = \"mixed\";"};

static double mass_of(double radius)
{
    return 4.0 / 3.0 * PI * 2000 * radius * radius * radius;
}

/* ---- a contact that sticks ---- */

/* Energy of the spring, averaged over 100 periods with a smooth window, so that its swing is left out. */
static double spring_energy(struct fixture *f, int steps)
{
    double sum = 0, weights = 0;
    for (int k = 0; k < steps; k++) {
        struct measurement m;
        double weight = 1 - cos(2 * PI * (k + 0.5) / steps);
        fixture_steps(f, 1);
        must(measure(sample_complete(f->sample), &m));
        sum += weight * weight * m.elastic_tangential_j;
        weights += weight * weight;
    }
    return sum / weights;
}

/* A sphere that gravity presses on the floor swings on its tangential spring, with no damping at all. */
static double amplitude_after(int dimension, bool mixed, int periods, int steps_a_period)
{
    const double k = 1e5, kt = 2e4, m = mass_of(1e-3), g = 100, arm = 1 - m * g / k / 1e-3;
    const double period = 2 * PI / sqrt((1 + 2.5 * arm * arm) * kt / m);
    struct fixture_options options = {.dimension = dimension,
                                      .count = 1,
                                      .dt_s = period / steps_a_period,
                                      .material = "kn_n_per_m = 1e5; mu_s = 50.0; kt_n_per_m = 2e4;",
                                      .more = precision[mixed]};
    struct fixture f = fixture_open(&options);
    struct particles *p = &f.sample->particles;
    const int last = dimension - 1;
    f.sample->gravity[last] = -g;
    p->x[last][0] = f.sample->walls[2 * last].x + p->radius[0] - m * g / k;
    p->v[0][0] = 1e-4;
    if (dimension == 3)
        p->v[1][0] = 0.7e-4;
    fixture_start(&f);
    const double before = spring_energy(&f, 50 * steps_a_period);
    fixture_steps(&f, (periods - 50) * steps_a_period);
    const double after = spring_energy(&f, 50 * steps_a_period);
    fixture_close(&f);
    return sqrt(after / before);
}

/* Within 1e-3 after 1000 periods at 20 steps a period. With springs that advance with the predicted velocity the
 * amplitude grew by (omega dt)^3 omega/8: to 570 times as much. */
static void sticking_keeps_its_amplitude(void **state)
{
    (void)state;
    for (int k = 0; k < 4; k++) {
        const double ratio = amplitude_after(2 + k / 2, k % 2, 1000, 20);
        print_message("%dD %s: amplitude x %.6f after 1000 periods\n", 2 + k / 2, k % 2 ? "mixed" : "double", ratio);
        assert_close("amplitude", ratio, 1, 1e-3);
    }
}

/* ---- springs turn ---- */

static void cross_of(const double *a, const double *b, double *result)
{
    for (int c = 0; c < 3; c++)
        result[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

/* Rodrigues. */
static void turn_about(const double *axis, double angle, const double *x, double *result)
{
    double side[3], along = axis[0] * x[0] + axis[1] * x[1] + axis[2] * x[2];
    cross_of(axis, x, side);
    for (int c = 0; c < 3; c++)
        result[c] = x[c] * cos(angle) + side[c] * sin(angle) + axis[c] * along * (1 - cos(angle));
}

#define ISA        turn
#define MODEL_TEXT "turn_tmpl.h"
#include "sim/law/for_each_model.h"

typedef void turn_often(const double *axis, double angle, int n, double *spring);

static turn_often *const turns[LAW_COUNT][2] = {
#define TURNS(name, NAME_) {NAME__(turn_often, turn, 3, name, 1, 0), NAME__(turn_often, turn, 3, name, 1, 1)},
    CONTACT_LAWS(TURNS)
#undef TURNS
};

/* 10^4 turns by 1e-3. Double: length to the fourth order, 1e4 (1e-3)^4/8 = 1e-9, direction to the third, 1e4
 * (1e-3)^3/12 = 1e-6 for a turn of n and (1e-3)^3/6 for one about n. Float: directions of n are off by 6e-8 a step,
 * which are not added up but for what they turn: 1e-4 is far below the 1 % by which springs shrank. */
static void springs_turn(void **state)
{
    static const double axes[3][3] = {{0, 0, 1}, {1, 0, 0}, {0.6, 0, 0.8}};
    (void)state;
    for (int mixed = 0; mixed < 2; mixed++)
        for (int k = 0; k < 3; k++) {
            const double start[3] = {0, 0.6, 0.8};
            double spring[3] = {0, 0.6, 0.8}, expected[3], apart = 0, length = 0;
            for (int law = 0; law < LAW_COUNT; law++) {
                memcpy(spring, start, sizeof spring);
                turns[law][mixed](axes[k], 1e-3, 10000, spring);
            }
            turn_about(axes[k], 10, start, expected);
            for (int c = 0; c < 3; c++) {
                apart += (spring[c] - expected[c]) * (spring[c] - expected[c]);
                length += spring[c] * spring[c];
            }
            print_message("%s, axis (%g %g %g): length off by %.2g, apart by %.2g\n", mixed ? "float" : "double",
                          axes[k][0], axes[k][1], axes[k][2], sqrt(length) - 1, sqrt(apart));
            assert_close("length", sqrt(length), 1, mixed ? 1e-4 : 2e-6);
            assert_close("direction", sqrt(apart), 0, mixed ? 1e-4 : 5e-6);
        }
}

/* ---- the ledger of a sample without damping ---- */

/* Grains on a lattice in a fixed box, each with a speed of its own: they lose all their energy to friction. */
static struct fixture gas(int dimension, double steps_a_contact, double mu)
{
    const int side = dimension == 2 ? 6 : 3, count = dimension == 2 ? 36 : 27;
    const double cell = 2.04e-3, m12 = 0.5 * mass_of(0.75e-3);
    char material[80] = "kn_n_per_m = 1e5;";
    if (mu > 0)
        snprintf(material, sizeof material, "kn_n_per_m = 1e5; mu_s = %g; kt_n_per_m = 1e5;", mu);
    struct fixture_options options = {
        .dimension = dimension, .count = count, .dt_s = PI * sqrt(m12 / 1e5) / steps_a_contact, .material = material};
    struct fixture f = fixture_open(&options);
    struct particles *p = &f.sample->particles;
    struct random random;
    random_init(&random, 3);
    for (int w = 0; w < f.sample->n_walls; w++)
        f.sample->walls[w].x = (w % 2 ? 0.97 : 0.03) * side * cell;
    for (int i = 0, place = 0; i < count; place = ++i) {
        p->radius[i] = (0.75 + 0.3 * random_uniform(&random)) * 1e-3;
        for (int c = 0; c < dimension; c++, place /= side) {
            p->x[c][i] = (place % side + 0.5) * cell;
            p->v[c][i] = 0.3 * (random_uniform(&random) - 0.5);
        }
    }
    fixture_start(&f);
    return f;
}

struct gas_ledger {
    double worst, end,
        friction; /* |residual| within 150 contact times, and then; what friction took: over the energy */
};

static struct gas_ledger gas_run(int dimension, int steps_a_contact, double mu)
{
    struct fixture f = gas(dimension, steps_a_contact, mu);
    const double start = f.sample->ledger.kinetic_start + f.sample->ledger.elastic_start;
    struct gas_ledger ledger = {0};
    for (int k = 0; k < 150; k++) {
        struct measurement m;
        fixture_steps(&f, steps_a_contact);
        must(measure(sample_complete(f.sample), &m));
        ledger.end = fabs(m.residual_j) / start;
        ledger.worst = fmax(ledger.worst, ledger.end);
    }
    ledger.friction = f.sample->ledger.contacts.friction / start;
    fixture_close(&f);
    return ledger;
}

/* Friction takes all of the energy in some hundred impacts: what is missing then is what its terms leave. On the way
 * more is missing, as much as the same grains miss without friction. Second order, the coarse steps being at its edge,
 * so that the whole range is fitted. */
static void ledger_without_damping(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        struct gas_ledger with[3];
        for (int k = 0; k < 3; k++)
            with[k] = gas_run(dimension, 20 << k, 0.5);
        const struct gas_ledger without = gas_run(dimension, 20, 0);
        const double order = 0.5 * log2(with[0].worst / with[2].worst);
        print_message(
            "%dD: at 20, 40, 80 steps a contact time %.2g, %.2g, %.2g of the energy missing at the end; on the "
            "way at most %.2g, %.2g, %.2g, order %.2f; without friction %.2g; friction took %.3f\n",
            dimension, with[0].end, with[1].end, with[2].end, with[0].worst, with[1].worst, with[2].worst, order,
            without.worst, with[0].friction);
        assert_true(with[0].friction > 0.99);
        assert_true(with[0].end < 1e-3 && with[1].end < 0.25e-3 && with[2].end < 0.07e-3);
        assert_true(with[0].worst < 1.5 * without.worst && without.friction == 0);
        assert_close("order", order, 2, 0.4);
    }
}

/* ---- impacts ---- */

struct impact {
    double vn, vt, spin, phase, dt;
};

enum { IMPACT_VALUES = 3 };

static const double RADIUS = 1e-3, STIFFNESS = 1e5, TANGENTIAL = 2e5 / 7, MU = 0.3;

/* A sphere meets a wall with the first overlap somewhere within a step: its velocity along and off the wall, and that
 * of its surface by its spin. */
static void impact_here(const struct impact *i, int steps, double *value)
{
    char material[160];
    snprintf(material, sizeof material, "kn_n_per_m = %.17e; mu_s = %.17e; kt_n_per_m = %.17e;", STIFFNESS, MU,
             TANGENTIAL);
    struct fixture_options options = {.dimension = 2, .count = 1, .dt_s = i->dt, .material = material};
    struct fixture f = fixture_open(&options);
    struct particles *p = &f.sample->particles;
    p->x[1][0] = f.sample->walls[2].x + RADIUS + i->vn * i->dt * (1 + i->phase);
    p->v[0][0] = i->vt;
    p->v[1][0] = -i->vn;
    p->omega[0][0] = i->spin;
    fixture_start(&f);
    fixture_steps(&f, steps);
    value[0] = p->v[0][0];
    value[1] = p->v[1][0];
    value[2] = p->omega[0][0] * RADIUS;
    fixture_close(&f);
}

/* The same with a plain leapfrog: the spring advances with velocities of the middle of the step, and forces are those
 * of a step's start. Surface velocity v + l w (w turns x into z), force of the contact on the sphere along x: -spring.
 */
static void impact_leapfrog(const struct impact *i, int steps, double *value)
{
    const double m = mass_of(RADIUS), inertia = 0.4 * m * RADIUS * RADIUS;
    double z = RADIUS + i->vn * i->dt * (1 + i->phase), vx = i->vt, vz = -i->vn, w = i->spin, spring = 0;
    for (int k = 0; k < steps; k++) {
        double overlap = RADIUS - z, normal = 0, along = 0;
        if (overlap > 0) {
            normal = STIFFNESS * overlap;
            spring += i->dt * (vx + z * w);
            along = -TANGENTIAL * spring;
            if (fabs(along) > MU * normal) {
                along = copysign(MU * normal, along);
                spring = -along / TANGENTIAL;
            }
        } else {
            spring = 0;
        }
        vx += i->dt * along / m;
        vz += i->dt * normal / m;
        w += i->dt * z * along / inertia;
        z += i->dt * vz;
    }
    value[0] = vx;
    value[1] = vz;
    value[2] = w * RADIUS;
}

/* Rms error over angles and phases, over the speed, against 5120 steps to a contact time. */
static double impact_error(void impact(const struct impact *i, int steps, double *value), int steps_a_contact)
{
    enum { ANGLES = 4, PHASES = 10, FINE = 5120 };
    const double contact = PI * sqrt(mass_of(RADIUS) / STIFFNESS), speed = 0.5;
    double sum = 0;
    for (int a = 0; a < ANGLES; a++) {
        const double angle = (15 + 20 * a) * PI / 180;
        struct impact i = {.vn = speed * cos(angle), .vt = speed * sin(angle), .spin = 50, .phase = 0.37};
        double right[IMPACT_VALUES], value[IMPACT_VALUES];
        i.dt = contact / FINE;
        impact_here(&i, 2 * FINE, right);
        for (int k = 0; k < PHASES; k++) {
            i.phase = (k + 0.5) / PHASES;
            i.dt = contact / steps_a_contact;
            impact(&i, 2 * steps_a_contact, value);
            for (int c = 0; c < IMPACT_VALUES; c++)
                sum += pow((value[c] - right[c]) / speed, 2);
        }
    }
    return sqrt(sum / (ANGLES * PHASES));
}

/* Undamped friction is at least as accurate as with a plain leapfrog, whose velocities are half a step late. */
static void impacts_against_leapfrog(void **state)
{
    (void)state;
    for (int steps = 20; steps <= 80; steps *= 2) {
        const double here = impact_error(impact_here, steps), leapfrog = impact_error(impact_leapfrog, steps);
        print_message("%d steps a contact time: rms error %.2g, plain leapfrog %.2g\n", steps, here, leapfrog);
        assert_true(here < 1.1 * leapfrog && here < 2e-4);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sticking_keeps_its_amplitude),
        cmocka_unit_test(springs_turn),
        cmocka_unit_test(ledger_without_damping),
        cmocka_unit_test(impacts_against_leapfrog),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
