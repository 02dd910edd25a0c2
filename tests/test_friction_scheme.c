/* The scheme of friction (docs/theory.md): sticking contacts neither gain nor lose, springs turn with their pairs, the
 * ledger closes without any damping of friction, and impacts are at least as accurate as with a plain leapfrog. */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "sim/base/random.h"
#include "sim/lanes/lanes_reference.h"
#include "sim/look/measure.h"
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
static double amplitude_after(int dimension, bool single, int periods, int steps_a_period)
{
    const double k = 1e5, kt = 2e4, m = mass_of(1e-3), g = 100, arm = 1 - m * g / k / 1e-3;
    const double period = 2 * PI / sqrt((1 + 2.5 * arm * arm) * kt / m);
    struct fixture_options options = {.dimension = dimension,
                                      .count = 1,
                                      .dt_s = period / steps_a_period,
                                      .material = "kn_n_per_m = 1e5; mu_s = 50.0; kt_n_per_m = 2e4;",
                                      .more = precision[single]};
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
    for (int single = 0; single < 2; single++)
        for (int k = 0; k < 3; k++) {
            const double start[3] = {0, 0.6, 0.8};
            double spring[3] = {0, 0.6, 0.8}, expected[3], apart = 0, length = 0;
            for (int law = 0; law < LAW_COUNT; law++) {
                memcpy(spring, start, sizeof spring);
                turns[law][single](axes[k], 1e-3, 10000, spring);
            }
            turn_about(axes[k], 10, start, expected);
            for (int c = 0; c < 3; c++) {
                apart += (spring[c] - expected[c]) * (spring[c] - expected[c]);
                length += spring[c] * spring[c];
            }
            print_message("%s, axis (%g %g %g): length off by %.2g, apart by %.2g\n", single ? "float" : "double",
                          axes[k][0], axes[k][1], axes[k][2], sqrt(length) - 1, sqrt(apart));
            assert_close("length", sqrt(length), 1, single ? 1e-4 : 2e-6);
            assert_close("direction", sqrt(apart), 0, single ? 1e-4 : 5e-6);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sticking_keeps_its_amplitude),
        cmocka_unit_test(springs_turn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
