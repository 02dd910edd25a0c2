/* Notes and verdict from what the record holds, the simulator's own notes, and files that claim what they do not hold.
 */
#include "test_analyzer_fixture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analyzer/analysis.h"
#include "analyzer/judgement.h"

enum { TEST_STAGE = 1 };

static void model(struct run *run)
{
    struct random random = {3};
    fixture_biaxial(run, &(struct biaxial_model){.n = 101}, &random);
}

static void set_all(struct run *run, enum observable observable, double value)
{
    for (size_t i = 0; i < run->n_samples; i++)
        fixture_set(run, observable, i, 0, value);
}

static const struct judgement_note *find(const struct judgement *judgement, const char *text)
{
    for (size_t k = 0; k < judgement->n; k++)
        if (strstr(judgement->note[k].text, text))
            return &judgement->note[k];
    return NULL;
}

static struct judgement *judged(const struct run *run)
{
    static struct judgement judgement;
    judgement_make(&judgement, run, TEST_STAGE);
    return &judgement;
}

/* A run without a flaw: residual 1e-4 of the work, no overlaps, at rest, on target. */
static void sound(void **state)
{
    struct run run;
    (void)state;
    model(&run);
    const struct judgement *judgement = judged(&run);
    assert_int_equal(judgement->verdict, WORTH_SOUND);
    assert_int_equal(judgement->status, STATUS_OK);
    assert_int_equal(judgement->n, 0);
    assert_string_equal(judgement->headline, "complete");
    run_free(&run);
}

/* Work that is given back, as in cycles: the residual is measured by all that went in and out, 1 J in each of 100
 * intervals, not by the sum, which is 0 at the end. */
static void work_is_given_back(void **state)
{
    struct run run;
    bool net = true;
    (void)state;
    model(&run);
    set_all(&run, OBSERVABLE_WORK_GRAVITY, 0);
    set_all(&run, OBSERVABLE_ENERGY_RESIDUAL, -0.5);
    const size_t n = 101;
    for (size_t k = 0; k < n; k++)
        fixture_set(&run, OBSERVABLE_WORK_WALLS, k, 0, (double)(k % 2));
    assert_true(judgement_residual(&run, OBSERVABLE_ENERGY_RESIDUAL, 0, n, &net) == 0.5 / 100);
    assert_false(net);
    run_free(&run);
}

/* Each bound from both sides. */
static void bounds(void **state)
{
    static const struct {
        enum observable observable;
        double value;
        enum worth verdict;
        const char *text; /* NULL: no note */
    } cases[] = {
        {OBSERVABLE_MAX_OVERLAP_RATIO, 0.049, WORTH_SOUND, NULL},
        {OBSERVABLE_MAX_OVERLAP_RATIO, 0.051, WORTH_SOUND, "5.1 % of the smaller radius"},
        {OBSERVABLE_MAX_OVERLAP_RATIO, 0.31, WORTH_FAILED, "31 % of the smaller radius"},
        {OBSERVABLE_INERTIAL_NUMBER, 0.9e-3, WORTH_SOUND, NULL},
        {OBSERVABLE_INERTIAL_NUMBER, 2e-3, WORTH_SOUND, "inertial number up to 0.002, mean 0.002"},
        /* the work is 5 eps, 0.175 J at the end: 0.0017 J is 0.97 %, 0.0018 J 1.03 % */
        {OBSERVABLE_ENERGY_RESIDUAL, 0.0017, WORTH_SOUND, NULL},
        {OBSERVABLE_ENERGY_RESIDUAL, -0.0018, WORTH_DOUBTFUL, "1.03 % of the work"},
        {OBSERVABLE_KINETIC_ENERGY, 0.9e-6, WORTH_SOUND, NULL},
        {OBSERVABLE_KINETIC_ENERGY, 2e-6, WORTH_SOUND, "not at rest at the start: E_kin/E_el = 0.002"},
    };
    (void)state;
    for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
        struct run run;
        model(&run);
        set_all(&run, OBSERVABLE_ELASTIC_NORMAL, 1e-3);
        for (size_t i = 5; i < run.n_samples; i++) /* the second stage */
            fixture_set(&run, cases[c].observable, i, 0, cases[c].value);
        const struct judgement *judgement = judged(&run);
        if (judgement->verdict != cases[c].verdict || (cases[c].text && !find(judgement, cases[c].text)) ||
            (!cases[c].text && judgement->n > 0))
            fail_msg("case %zu: %s, \"%s\"", c, judgement_worth_name(judgement->verdict),
                     judgement->n ? judgement->note[0].text : "");
        assert_int_equal(judgement->status == STATUS_OK, cases[c].verdict == WORTH_SOUND);
        if (cases[c].verdict == WORTH_DOUBTFUL)
            assert_int_equal(judgement->status, STATUS_DOUBTFUL);
        run_free(&run);
    }
}

/* Preparation may be violent: 50 % in the first stage alone is a note. */
static void violent_preparation(void **state)
{
    struct run run;
    (void)state;
    model(&run);
    for (size_t i = 0; i < 5; i++)
        fixture_set(&run, OBSERVABLE_MAX_OVERLAP_RATIO, i, 0, 0.5);
    const struct judgement *judgement = judged(&run);
    assert_int_equal(judgement->verdict, WORTH_SOUND);
    assert_string_equal(find(judgement, "50 % of the smaller radius")->stage, "relax");
    run_free(&run);
}

/* sigma_xx of 525 where 500 is asked for: 5 % in the mean and at most. */
static void off_target(void **state)
{
    struct run run;
    double mean, largest;
    (void)state;
    model(&run);
    set_all(&run, OBSERVABLE_STRESS_WALL, 525);
    judgement_stress_error(&run, TEST_STAGE, 5, run.n_samples, &mean, &largest);
    assert_near(mean, 0.05, 1e-12);
    assert_near(largest, 0.05, 1e-12);
    assert_non_null(find(judged(&run), "5 % in the mean, 5 % at most"));
    run_free(&run);
}

/* Cut at 10 of 101 samples of the second stage: t = 0.01 + 0.05 x 9/100 = 0.0145 of 0.07 s, 20 %. Nothing that looks to
 * the end is given; the stage before came to its end. */
static void interrupted(void **state)
{
    struct run run;
    (void)state;
    model(&run);
    run.n_samples = 15;
    run.complete = false;
    const struct judgement *judgement = judged(&run);
    assert_int_equal(judgement->verdict, WORTH_FAILED);
    assert_int_equal(judgement->status, STATUS_INCOMPLETE);
    assert_string_equal(judgement->headline, "INTERRUPTED at 20 %");
    assert_false(judgement->ended);
    run.status = status_exit_code(STATUS_UNSTABLE);
    run.complete = true;
    snprintf(run.reason, sizeof run.reason, "faster than sound");
    judgement = judged(&run);
    assert_string_equal(judgement->headline, "FAILED at 20 %: faster than sound");
    assert_int_equal(judgement->status, STATUS_UNSTABLE);
    struct judgement before;
    judgement_make(&before, &run, 0);
    assert_true(before.ended);
    run_free(&run);
}

static void cut_is_not_evaluated(void **state)
{
    char directory[256];
    struct analysis *analysis = calloc(1, sizeof *analysis);
    struct random random = {3};
    struct run run;
    (void)state;
    assert_non_null(analysis);
    fixture_directory_make(directory, sizeof directory);
    fixture_biaxial(&run, &(struct biaxial_model){.n = 501}, &random);
    run.n_samples = 5 + 250;
    run.complete = false;
    fixture_write(&run, fixture_biaxial_config, directory, NULL);
    assert_int_equal(analysis_make(analysis, directory, NULL), STATUS_OK);
    assert_true(isnan(analysis->quantity[QUANTITY_CRITICAL_SIN_PHI].value));
    assert_non_null(strstr(analysis->quantity[QUANTITY_CRITICAL_SIN_PHI].text, "did not end: INTERRUPTED at"));
    assert_near(analysis->quantity[QUANTITY_E_INITIAL].value, 1e5, 1); /* lies behind */
    analysis_free(analysis);
    run_free(&run);
    fixture_directory_remove(directory);
    free(analysis);
}

/* The simulator's notes come first, count for the verdict, and stand alone where they are as severe. */
static void notes_of_the_simulator(void **state)
{
    static struct run_note notes[] = {{"test", 1, "residual 3 % (mine)"}, {"", 0, "kappa = 1e4"}};
    char directory[256], path[300];
    struct run run, read;
    (void)state;
    fixture_directory_make(directory, sizeof directory);
    model(&run);
    set_all(&run, OBSERVABLE_ENERGY_RESIDUAL, 0.1);
    run.note = notes;
    run.n_notes = 2;
    fixture_write(&run, fixture_biaxial_config, directory, NULL);
    run.note = NULL;
    run_free(&run);
    snprintf(path, sizeof path, "%s/run.h5", directory);
    assert_int_equal(run_read(&read, path), STATUS_OK);
    assert_int_equal(read.n_notes, 2);
    assert_string_equal(read.note[0].stage, "test");
    assert_int_equal(read.note[0].severity, 1);
    assert_string_equal(read.note[1].text, "kappa = 1e4");
    const struct judgement *judgement = judged(&read);
    assert_int_equal(judgement->verdict, WORTH_DOUBTFUL);
    assert_non_null(find(judgement, "residual 3 % (mine)"));
    assert_null(find(judgement, "does not close"));
    run_free(&read);
    fixture_directory_remove(directory);
}

/* A dataset of 2^40 records takes 8 TB: refused by its extent, before memory is asked for. */
static void hostile_extent(void **state)
{
    char directory[256], path[300];
    struct run run;
    (void)state;
    fixture_directory_make(directory, sizeof directory);
    model(&run);
    fixture_write(&run, fixture_biaxial_config, directory, &(struct flaw){.huge = "fabric"});
    run_free(&run);
    snprintf(path, sizeof path, "%s/run.h5", directory);
    assert_int_equal(run_read(&run, path), STATUS_FORMAT);
    assert_non_null(strstr(status_message(), "/samples/fabric/value: claims 1099511627776 records"));
    fixture_directory_remove(directory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sound),
        cmocka_unit_test(work_is_given_back),
        cmocka_unit_test(bounds),
        cmocka_unit_test(off_target),
        cmocka_unit_test(violent_preparation),
        cmocka_unit_test(interrupted),
        cmocka_unit_test(cut_is_not_evaluated),
        cmocka_unit_test(notes_of_the_simulator),
        cmocka_unit_test(hostile_extent),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
