/* Teams of threads: every piece of every job once, whoever does it; and how many threads are found to be worth it. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "sim/base/thread_team.h"
#include "sim/sample/thread_choice.h"

enum { PIECES = 300, JOBS = 2000 };

struct counts {
    int done[PIECES]; /* not atomic: a piece done twice at a time, or seen too late, is what the sanitizer looks for */
    atomic_int all;
};

static void count(void *context, int piece)
{
    struct counts *counts = context;
    counts->done[piece]++;
    atomic_fetch_add(&counts->all, 1);
}

/* Jobs of many sizes right behind each other, with more threads than there are CPUs, and numbers of threads that
 * change. */
static void every_piece_is_done_once(void **state)
{
    (void)state;
    for (int threads = 1; threads <= 8; threads += threads < 3 ? 1 : 5) {
        struct thread_team *team;
        struct counts counts = {0};
        int all = 0;
        assert_int_equal(thread_team_create(&team, threads), STATUS_OK);
        for (int job = 0; job < JOBS; job++) {
            const int pieces = job % 7 == 0 ? PIECES : job % 5;
            thread_team_use(team, 1 + job / 10 % threads);
            thread_team_run(team, pieces, count, &counts);
            all += pieces;
            assert_int_equal(atomic_load(&counts.all), all);
        }
        for (int k = 0; k < PIECES; k++) {
            int expected = 0;
            for (int job = 0; job < JOBS; job++)
                expected += (job % 7 == 0 ? PIECES : job % 5) > k;
            assert_int_equal(counts.done[k], expected);
        }
        thread_team_free(team);
    }
}

static void without_a_team(void **state)
{
    (void)state;
    struct counts counts = {0};
    thread_team_run(NULL, PIECES, count, &counts);
    assert_int_equal(atomic_load(&counts.all), PIECES);
    assert_int_equal(thread_team_in_use(NULL), 1);
    thread_team_free(NULL);
}

/* Seconds of a step of 1 ms work with n threads on `cpus`, beside programs that make threads wait for each other if
 * they are more than those that are left. */
static double step_s(int n, int cpus, int busy)
{
    const double alone = 1e-3 / (n < cpus ? n : cpus);
    return n > 1 && n > cpus - busy ? 5e-3 : alone;
}

/* Runs for `seconds`; returns how much longer it takes than with the best number all the time. */
static double go(struct thread_choice *choice, double seconds, int cpus, int busy)
{
    double spent = 0, best = INFINITY;
    int steps = 0;
    for (int n = 1; n <= choice->most; n *= 2)
        best = fmin(best, step_s(n, cpus, busy));
    for (; spent < seconds; steps++) {
        const double s = step_s(choice->use, cpus, busy);
        thread_choice_step(choice, s);
        spent += s;
    }
    return spent / (steps * best);
}

static void the_best_number_is_found(void **state)
{
    (void)state;
    for (int cpus = 1; cpus <= 16; cpus *= 2) {
        struct thread_choice choice = thread_choice_of(16);
        (void)go(&choice, 2, cpus, 0);
        assert_int_equal(choice.best, cpus);
        assert_true(go(&choice, 20, cpus, 0) < 1.03); /* a trial of 20 ms, at most five times as slow, in 6.4 s */
    }
}

/* One of two CPUs is taken by others, and given back. */
static void others_are_made_way_for(void **state)
{
    (void)state;
    struct thread_choice choice = thread_choice_of(2);
    (void)go(&choice, 20, 2, 0);
    assert_int_equal(choice.best, 2);
    assert_true(go(&choice, 10, 2, 1) < 1.15);
    assert_int_equal(choice.best, 1);
    (void)go(&choice, 10, 2, 0);
    assert_int_equal(choice.best, 2);
}

static void one_thread_stays_one(void **state)
{
    (void)state;
    struct thread_choice choice = thread_choice_of(1);
    (void)go(&choice, 1, 2, 0);
    assert_int_equal(choice.use, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_piece_is_done_once), cmocka_unit_test(without_a_team),
        cmocka_unit_test(the_best_number_is_found), cmocka_unit_test(others_are_made_way_for),
        cmocka_unit_test(one_thread_stays_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
