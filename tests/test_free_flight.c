/* Particles that nothing touches keep their velocities and go as far as these take them, also slow ones, in either
 * precision. */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>

#include "sim/sample/step_completion.h"

enum { FLYERS = 5, STEPS = 1000000 };
static const double DT = 1e-6;
static const char *const precision[] = {"", "precision = \"mixed\";"};

/* Metres in a step, for radii of 1 mm: from 1e-4 radii to 1e-16 of them. */
static const double way[FLYERS] = {-1.1e-7, 1.3e-10, -1.7e-13, 1.9e-16, -1.6e-19};

/* Side by side, across the middle of the box. */
static struct fixture flight(int dimension, bool mixed)
{
    const struct fixture_options options = {.dimension = dimension,
                                            .count = FLYERS,
                                            .dt_s = DT,
                                            .material = "kn_n_per_m = 1e5; mu_s = 0.5; kt_n_per_m = 1e5;",
                                            .more = precision[mixed]};
    struct fixture f = fixture_open(&options);
    struct particles *p = &f.sample->particles;
    for (int i = 0; i < FLYERS; i++)
        for (int c = 0; c < dimension; c++) {
            const double lo = f.sample->walls[2 * c].x, hi = f.sample->walls[2 * c + 1].x;
            p->x[c][i] = 0.5 * (lo + hi) + (c == dimension - 1 ? 0.01 * (i - 2) : 0);
            p->v[c][i] = c == 0 ? way[i] / DT : 0;
        }
    for (int i = 0; i < FLYERS; i++)
        p->omega[0][i] = 1 + 1e-9 * i;
    fixture_start(&f);
    return f;
}

/* Each step rounds a position to the last place of what it is kept in: in double 2^-53 of the coordinate; in mixed
 * precision 2^-26 of a quantum, which is at most 2^-28 of the skin (docs/theory.md), beside 2^-53 at each of the lists.
 * All could go the same way. */
static void flies(int dimension, bool mixed)
{
    struct fixture f = flight(dimension, mixed);
    struct particles *p = &f.sample->particles;
    double start[FLYERS], v[FLYERS], omega[FLYERS];
    for (int i = 0; i < FLYERS; i++) {
        start[i] = p->x[0][i];
        v[i] = p->v[0][i];
        omega[i] = p->omega[0][i];
    }
    fixture_steps(&f, STEPS);
    (void)sample_complete(f.sample);
    const double place = mixed ? 0x1p-26 * p->quantum : 0x1p-53 * start[0];
    for (int i = 0; i < FLYERS; i++) {
        const double went = p->x[0][i] - start[i], expected = v[i] * DT * STEPS;
        const double rounding =
            STEPS * place + (mixed ? 4 * 0x1p-53 * start[0] * (double)f.sample->verlet.rebuilds : 0);
        print_message("%dD %-22s %8.1e m a step: off by %8.1e of the way\n", dimension, precision[mixed], way[i],
                      went / expected - 1);
        assert_true(p->v[0][i] == v[i] && p->omega[0][i] == omega[i] && p->v[dimension - 1][i] == 0);
        assert_close("way", went, expected, rounding + 1e-12 * fabs(expected));
        if (fabs(way[i]) > 1e6 * place)
            assert_close("way / v t", went / expected, 1, 1e-6);
    }
    fixture_close(&f);
}

static void velocities_are_kept(void **state)
{
    (void)state;
    for (int n = 0; n < 4; n++)
        flies(2 + n / 2, n % 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(velocities_are_kept)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
