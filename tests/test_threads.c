/* Threads: the same bits for any number of them, the physics of one, and small samples left alone. */
#include "sim_fixture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "sim/base/random.h"
#include "sim/run/checkpoint.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"

enum { LARGE = 10000, LARGER = 30000, SMALL = 9000, STEPS = 40 };

/* Particles anywhere in a box that they would fill to 70 %, so that nearly all touch; they fly apart slowly. */
static struct fixture crowd(int dimension, int count, int threads, const char *precision)
{
    char more[160];
    snprintf(more, sizeof more,
             "threads = %d; precision = \"%s\"; neighbor = { skin_ratio = 0.02; renumber_steps = 25; };", threads,
             precision);
    const struct fixture_options options = {dimension, count, 1e-6,
                                            "law = \"hysteretic\"; k1_n_per_m = 8e1; k2_n_per_m = 1e2; mu_s = 0.3; "
                                            "kt_n_per_m = 2e1; gamma_n_kg_per_s = 0.001; gamma_t_kg_per_s = 0.001; "
                                            "gamma_b_kg_per_s = 1e-4;",
                                            more};
    struct fixture f = fixture_open(&options);
    struct sample *sample = f.sample;
    struct particles *p = &sample->particles;
    struct random random;
    random_init(&random, 11);
    double side = pow(particles_solid_volume(p) / 0.7, 1.0 / dimension);
    for (int c = 0; c < dimension; c++) {
        sample->walls[2 * c].x = 0;
        sample->walls[2 * c + 1].x = side;
        for (int i = 0; i < count; i++) {
            p->x[c][i] = side * random_uniform(&random);
            p->v[c][i] = 2 * random_uniform(&random) - 1;
        }
    }
    fixture_start(&f);
    return f;
}

static bool same_losses(const struct ledger *a, const struct ledger *b)
{
    return memcmp(a, b, sizeof *a) == 0;
}

/* Steps that are left open for the next one, which goes on with a part of the particles as soon as it can. */
static void open_steps(struct fixture *f)
{
    for (int k = 0; k < STEPS; k++)
        must(sample_step_open(f->sample));
    (void)sample_complete(f->sample);
}

/* Positions, velocities, rotations, walls, and the energy ledger, whose sums have a fixed order too. */
static void any_number_gives_the_same_bits(void **state)
{
    static const int numbers[] = {1, 2, 3, 5, 8, 16};
    (void)state;
    for (int model = 0; model < 4; model++) {
        const int dimension = 2 + model / 2;
        const char *precision = model % 2 ? "mixed" : "double";
        struct fixture one = crowd(dimension, LARGE, 1, precision);
        fixture_steps(&one, STEPS);
        assert_int_equal(one.sample->threads.n, 1);
        assert_true(one.sample->threads.halo.n_blocks > 1 && one.sample->pairs.count > LARGE);
        assert_true(one.sample->verlet.rebuilds > 4);
        for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++) {
            const int threads = numbers[k];
            struct fixture many = crowd(dimension, LARGE, threads, precision);
            open_steps(&many);
            assert_int_equal(many.sample->threads.n,
                             threads < many.sample->threads.n_parts ? threads : many.sample->threads.n_parts);
            assert_true(sample_hash(sample_complete(one.sample)) == sample_hash(sample_complete(many.sample)));
            assert_true(same_losses(&one.sample->ledger, &many.sample->ledger));
            fixture_close(&many);
        }
        fixture_close(&one);
    }
}

/* A sample that was saved between two builds of its lists, in blocks, goes on with the same bits before the next build
 * and after it, whatever the number of threads. */
static void resumed_samples_sum_in_the_same_order(void **state)
{
    static const char path[] = "test_threads.h5";
    (void)state;
    for (int model = 0; model < 4; model++) {
        const int threads = 1 + model % 2;
        struct fixture whole = crowd(2 + model / 2, LARGE, threads, model % 2 ? "mixed" : "double");
        const struct run_progress progress = {0};
        struct run_progress taken;
        struct sample *resumed;
        while (whole.sample->step < STEPS || whole.sample->verlet.built_step == whole.sample->step)
            fixture_steps(&whole, 1);
        must(checkpoint_write(path, whole.sample, &progress));
        must(checkpoint_resume(path, whole.scene, &resumed, &taken));
        const int64_t rebuilds = whole.sample->verlet.rebuilds;
        assert_int_equal(resumed->threads.n, threads);
        assert_true(whole.sample->threads.halo.n_blocks > 1);
        assert_int_equal(resumed->threads.halo.n_blocks, whole.sample->threads.halo.n_blocks);
        for (int k = 0; k < STEPS; k++) {
            fixture_steps(&whole, 1);
            must(sample_step(resumed));
            assert_true(k > 0 || whole.sample->verlet.rebuilds == rebuilds);
            assert_true(sample_hash(sample_complete(whole.sample)) == sample_hash(sample_complete(resumed)));
            assert_true(same_losses(&whole.sample->ledger, &resumed->ledger));
        }
        assert_true(whole.sample->verlet.rebuilds > rebuilds);
        sample_free(resumed);
        fixture_close(&whole);
    }
    assert_int_equal(remove(path), 0);
}

/* Against the sum in one go, which the small samples use: rounding alone. Speeds are about 1 m/s, so each step rounds
 * at 1e-16 m/s, and a few dozen steps of soft contacts amplify little. */
static void pieces_add_up(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        struct fixture pieces = crowd(dimension, LARGER, 2, "double"), whole = crowd(dimension, LARGER, 1, "double");
        const struct particles *a = &pieces.sample->particles, *b = &whole.sample->particles;
        double worst = 0;
        const int parts = whole.sample->threads.n_parts;
        whole.sample->threads.n_parts = 1;
        must(sample_build_lists(whole.sample)); /* slots look at no copies */
        fixture_steps(&pieces, STEPS);
        fixture_steps(&whole, STEPS);
        for (int i = 0; i < a->count; i++)
            for (int c = 0; c < dimension; c++)
                worst = fmax(worst, fabs(a->v[c][a->slot[i]] - b->v[c][b->slot[i]]));
        print_message("%dD: %d blocks with %d copies, velocities differ by %.2g m/s\n", dimension,
                      pieces.sample->threads.halo.n_blocks, pieces.sample->threads.halo.n_copies, worst);
        assert_true(worst > 0 && pieces.sample->threads.halo.n_copies > 0);
        assert_close("largest difference", worst, 0, 1e-12);
        assert_close("work of the background", pieces.sample->ledger.background, whole.sample->ledger.background,
                     1e-12 * whole.sample->ledger.background);
        whole.sample->threads.n_parts = parts; /* to be freed */
        fixture_close(&pieces);
        fixture_close(&whole);
    }
}

static void small_samples_are_left_alone(void **state)
{
    (void)state;
    struct fixture f = crowd(2, SMALL, 4, "double");
    assert_int_equal(f.sample->threads.n, 1);
    assert_int_equal(f.sample->threads.n_parts, 1);
    fixture_close(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_number_gives_the_same_bits),
        cmocka_unit_test(resumed_samples_sum_in_the_same_order),
        cmocka_unit_test(pieces_add_up),
        cmocka_unit_test(small_samples_are_left_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
