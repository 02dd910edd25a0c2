/* The model of a step on more cores than there are, against sums by hand. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "bench/scaling_model.h"

/* Sums of a few numbers that doubles hold. */
static void assert_us(double got, double wanted)
{
    if (!(fabs(got - wanted) <= 1e-12 * wanted))
        fail_msg("%.17g instead of %.17g us", got, wanted);
}

static void whoever_is_done_helps(void **state)
{
    (void)state;
    static const double us[] = {1, 1, 1, 1, 4, 1, 1, 1};
    assert_us(scaling_model_makespan(us, 8, 1), 11);
    /* {1 1}, {1 1 4} and {1 1 1}: the first is free at 2, and takes the 4 */
    assert_us(scaling_model_makespan(us, 8, 3), 6);
    static const double long_share[] = {1, 1, 3, 3};
    /* {1 1} and {3 3}: the first is free at 2, and takes the second 3 */
    assert_us(scaling_model_makespan(long_share, 4, 2), 5);
    assert_us(scaling_model_makespan(long_share, 4, 8), 3);
}

static void a_step_is_blocks_walls_jobs_and_the_rest(void **state)
{
    (void)state;
    static const double us[] = {10, 10, 10, 10};
    static const int pieces[] = {3, 1};
    struct scaling_model model = {.n_blocks = 4,
                                  .block_us = us,
                                  .walls_us = 8,
                                  .n_axes = 2,
                                  .n_pieces = pieces,
                                  .n_jobs = 3,
                                  .serial_us = 5,
                                  .job_us = 1,
                                  .bytes_mb = 4,
                                  .bandwidth_gb_per_s = 100,
                                  .data_mb = 3,
                                  .cache_mb = 1};
    assert_us(scaling_model_step_us(&model, 1), 40 + 8 + 5);
    /* two: half of the blocks, 2 + 1 rounds of the walls' 4 pieces, three jobs; 4 MB take 40 us */
    assert_us(scaling_model_step_us(&model, 2), 40);
    model.bandwidth_gb_per_s = 1000;
    assert_us(scaling_model_step_us(&model, 2), 20 + 6 + 3 + 5);
    /* four: their caches hold 4 MB, and what memory gives does not matter */
    model.bandwidth_gb_per_s = 1;
    assert_us(scaling_model_step_us(&model, 4), 10 + 4 + 3 + 5);
    model.data_mb = 4.5;
    assert_us(scaling_model_step_us(&model, 4), 4000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whoever_is_done_helps),
        cmocka_unit_test(a_step_is_blocks_walls_jobs_and_the_rest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
