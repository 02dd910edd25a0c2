/* What a study file may say, what is planned from it, and what is evaluated: without running anything. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "studies/files.h"
#include "studies/plan.h"
#include "studies/report.h"
#include "studies/results.h"
#include "studies/study.h"
#include "studies/table.h"
#include "studies/task.h"

static const char *source; /* folder of the project */
static char folder[] = "/tmp/test_studies.XXXXXX";

static const char *path_of(const char *name)
{
    static char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

/* A study on the small scene, with `more` at its end. */
static enum status study_from(struct study *study, const char *more)
{
    char *text;
    assert_true(asprintf(&text, "name = \"t\";\nscene = \"%s/scenes/quick.cfg\";\n%s", source, more) > 0);
    assert_int_equal(files_write(path_of("t.cfg"), text), STATUS_OK);
    free(text);
    return study_load(study, path_of("t.cfg"), NULL, 0);
}

static void refused(const char *more, const char *words)
{
    struct study study;
    assert_int_equal(study_from(&study, more), STATUS_CONFIG);
    if (!strstr(status_message(), words))
        fail_msg("'%s' instead of '%s'", status_message(), words);
}

static void wrong_files_are_refused(void **state)
{
    (void)state;
    refused("colour = 1;", "t.cfg:3: colour: unknown key");
    refused("seeds = 0;", "seeds");
    refused("seeds = [ 1.5 ];", "not a whole number");
    refused("vary = ( { name = \"a b\"; values = [1.0]; } );", "letters, digits");
    refused("vary = ( { name = \"a\"; } );", "needs either values");
    refused("vary = ( { name = \"a\"; values = [ \"x\" ]; } );", "not a number");
    refused("vary = ( { name = \"a\"; values = [ ]; } );", "has no levels");
    refused("vary = ( { name = \"a\"; levels = ( { set = [ \"x=1\" ]; } ); } );", "needs a name or a value");
    refused("paper = ( { quantity = \"nu\"; value = 1.0; where = { a = 1.0; }; } );", "no series varies");
    refused("paper = ( { quantity = \"nu\"; } );", "paper.0.value: missing");
    refused("figures = ( { kind = \"pie\"; name = \"f\"; } );", "\"curves\", \"points\", \"mohr\"");
    refused("figures = ( { kind = \"points\"; name = \"f\"; x = \"a\"; y = \"nu\"; } );", "no factor of the study");
    refused("figures = ( { kind = \"curves\"; name = \"../f\"; x = \"a\"; y = \"b\"; } );", "letters, digits");
    refused("figures = ( { kind = \"curves\"; name = \"f\"; x = \"a\"; y = \"b\"; table = \"/etc/passwd\"; } );",
            "table must be");
    refused("evaluate = ( { kind = \"tangent\"; name = \"t\"; along = \"p\"; } );", "no factor of the study");
    refused("score = \"p\";", "no factor of the study");
    refused("quantities = [ \"nu\" ]; paper = ( { quantity = \"mu\"; value = 1.0; } );",
            "neither among the quantities");
    refused("quantities = [ \"nu\" ]; vary = ( { name = \"a\"; values = [1.0]; } );"
            "figures = ( { kind = \"points\"; name = \"f\"; x = \"a\"; y = \"t.tau_s\"; } );",
            "neither among the quantities");
    refused("series = ( { name = \"a\"; }, { name = \"a\"; } );", "is taken");
}

static const char two_factors[] =
    "prepare = \"ring\"; seeds = [3, 1];\n"
    "set = [ \"stages.0.material.kc_n_per_m=0.0\" ];\n"
    "vary = ( { name = \"p\"; keys = [ \"stages.0.walls.x.pressure_pa\" ]; values = [ 100.0, 500.0 ]; },\n"
    "         { name = \"kc\"; keys = [ \"material.kc_n_per_m\" ]; scale = 1e5; values = [ 0.0, 0.5, 1.0 ]; } );\n";

static void runs_share_preparations(void **state)
{
    struct study study;
    struct plan plan;
    (void)state;
    assert_int_equal(study_from(&study, two_factors), STATUS_OK);
    assert_int_equal(plan_make(&plan, &study), STATUS_OK);
    assert_int_equal(plan.n_runs, 12);
    /* one for each pressure and seed, whatever the cohesion */
    assert_int_equal(plan.n_preparations, 4);
    /* those that make one come first */
    for (int a = 0; a < 4; a++)
        for (int b = 0; b < a; b++)
            assert_string_not_equal(plan.run[a].preparation, plan.run[b].preparation);
    for (int a = 0; a < plan.n_runs; a++)
        for (int b = 0; b < a; b++)
            assert_string_not_equal(plan.run[a].hash, plan.run[b].hash);
    assert_non_null(strstr(plan.run[0].scene, "/" TASK_PREPARED));
    assert_null(strstr(plan.run[0].scene, "name = \"ring\""));
    assert_string_equal(plan.run[0].name, "p_100-kc_0-seed3");
    plan_free(&plan);
    study_free(&study);
}

/* A setting that only comes after the preparation leaves it; one of the preparation does not. */
static void settings_have_their_hash(void **state)
{
    static const char *const later[] = {"material.gamma_n_kg_per_s=0.2", "stages.0.material.gamma_n_kg_per_s=0.1"};
    static const char *const before[] = {"stages.0.dt_s=5e-7"};
    struct study study[3];
    struct plan plan[3];
    (void)state;
    assert_int_equal(study_from(&study[0], two_factors), STATUS_OK);
    assert_int_equal(study_load(&study[1], path_of("t.cfg"), later, 2), STATUS_OK);
    assert_int_equal(study_load(&study[2], path_of("t.cfg"), before, 1), STATUS_OK);
    for (int k = 0; k < 3; k++)
        assert_int_equal(plan_make(&plan[k], &study[k]), STATUS_OK);
    assert_string_equal(plan[0].run[0].preparation, plan[1].run[0].preparation);
    assert_string_not_equal(plan[0].run[0].hash, plan[1].run[0].hash);
    assert_string_not_equal(plan[0].run[0].preparation, plan[2].run[0].preparation);
    assert_string_not_equal(plan[0].run[0].hash, plan[2].run[0].hash);
    for (int k = 0; k < 3; k++) {
        plan_free(&plan[k]);
        study_free(&study[k]);
    }
}

static void broken_scenes_name_their_run(void **state)
{
    struct study study;
    struct plan plan;
    (void)state;
    assert_int_equal(study_from(&study, "vary = ( { name = \"mu\"; keys = [ \"material.mu\" ]; values = [ 1.0 ]; } );"),
                     STATUS_OK);
    assert_int_equal(plan_make(&plan, &study), STATUS_CONFIG);
    assert_non_null(strstr(status_message(), "run mu_1-seed1: "));
    assert_non_null(strstr(status_message(), "unknown key"));
    study_free(&study);
    assert_int_equal(study_from(&study, "prepare = \"nothing\";"), STATUS_OK);
    assert_int_equal(plan_make(&plan, &study), STATUS_CONFIG);
    assert_non_null(strstr(status_message(), "no stage \"nothing\""));
    study_free(&study);
    assert_int_equal(study_from(&study, "prepare = \"test\";"), STATUS_OK);
    assert_int_equal(plan_make(&plan, &study), STATUS_CONFIG);
    assert_non_null(strstr(status_message(), "no stage comes after"));
    study_free(&study);
}

/* Settings that change take the former results along. */
static void stale_results_go(void **state)
{
    struct task task;
    char path[300];
    (void)state;
    assert_int_equal(task_open(&task, folder, "r"), STATUS_OK);
    assert_string_equal(task.hash, "");
    assert_int_equal(task_set(&task, "scene", "00000000000000aa", ""), STATUS_OK);
    snprintf(path, sizeof path, "%s/runs/r/analysis.json", folder);
    assert_int_equal(files_write(path, "{\"complete\": true}"), STATUS_OK);
    assert_false(task_is_done(&task)); /* no run.h5 */
    assert_int_equal(task_set(&task, "scene", "00000000000000bb", "00000000000000cc"), STATUS_OK);
    assert_false(files_exist(path));
    assert_int_equal(task_open(&task, folder, "r"), STATUS_OK);
    assert_string_equal(task.hash, "00000000000000bb");
    assert_string_equal(task.preparation, "00000000000000cc");
}

static void spreads_have_closed_forms(void **state)
{
    const double value[] = {1, NAN, 2, 3, 4}, none[] = {NAN};
    struct spread spread = spread_of(value, 5);
    (void)state;
    assert_int_equal(spread.n, 4);
    /* roundings of a few sums */
    assert_true(fabs(spread.mean - 2.5) < 1e-15);
    assert_true(fabs(spread.sd - sqrt(5.0 / 3)) < 1e-15);
    assert_true(fabs(spread_error(&spread) - sqrt(5.0 / 12)) < 1e-15);
    spread = spread_of(none, 1);
    assert_int_equal(spread.n, 0);
    assert_true(isnan(spread.mean) && isnan(spread_error(&spread)));
}

/* sigma_1 = sigma_3 (1 + sin)/(1 - sin) + 2 c cos/(1 - sin) gives phi and c back. */
static void tangents_have_closed_forms(void **state)
{
    const double phi = 20 * M_PI / 180, c = 30, minor[] = {100, 200, 500};
    double major[3], number[TANGENT_KEYS];
    (void)state;
    for (int k = 0; k < 3; k++)
        major[k] = (minor[k] * (1 + sin(phi)) + 2 * c * cos(phi)) / (1 - sin(phi));
    for (int n = 2; n <= 3; n++) {
        tangent_fit(minor, major, n, number);
        /* roundings, times the ratio of the stresses to c */
        assert_true(fabs(number[TANGENT_TAN_PHI] - tan(phi)) < 1e-13);
        assert_true(fabs(number[TANGENT_FRICTION_ANGLE] - 20) < 1e-11);
        assert_true(fabs(number[TANGENT_COHESION] - c) < 1e-11);
    }
    tangent_fit(minor, major, 1, number);
    assert_true(isnan(number[TANGENT_TAN_PHI]));
}

/* A damped oscillation sampled 50 times a period: largest values are found to within half a sample, so their size to
 * (pi/50)^2/2 = 0.2 %, the same for all but for where samples fall; tau over the 3 decades seen to well below 1 %. */
static void decays_are_found(void **state)
{
    enum { N = 1000 };
    double time[N], value[N];
    (void)state;
    for (int k = 0; k < N; k++) {
        time[k] = k * 2e-5;
        value[k] = 400 + 50 * exp(-time[k] / 2.3e-3) * cos(2 * M_PI * time[k] / 1e-3);
    }
    struct number tau = decay_fit(time, value, N, 400);
    assert_true(fabs(tau.value / 2.3e-3 - 1) < 0.01);
    assert_true(tau.uncertainty > 0 && tau.uncertainty < 0.01 * 2.3e-3);
    for (int k = 0; k < N;
         k++) /* without swings, to its last value, which is 1e-4 of the first off: 0.5 % of a fiftieth */
        value[k] = 400 + 50 * exp(-time[k] / 2.1e-3);
    tau = decay_fit(time, value, N, NAN);
    assert_true(fabs(tau.value / 2.1e-3 - 1) < 0.01);
    for (int k = 0; k < N; k++)
        value[k] = exp(time[k] / 2e-3);
    assert_true(isnan(decay_fit(time, value, N, 0).value)); /* it goes away */
}

static void slopes_have_closed_forms(void **state)
{
    const double x[] = {0, 1, 2, 3}, y[] = {1, 2, 4, 5};
    struct number slope = slope_fit(x, y, 4);
    (void)state;
    /* (n sum xy - sum x sum y)/(n sum xx - (sum x)^2) = (4 25 - 6 12)/(4 14 - 36); rest 0.2 over 2 degrees, over 5 */
    assert_true(fabs(slope.value - 1.4) < 1e-14);
    assert_true(fabs(slope.uncertainty - sqrt(0.2 / 2 / 5)) < 1e-14);
    assert_true(isnan(slope_fit(x, y, 2).value));
}

static void tables_are_read(void **state)
{
    struct table table;
    const double *column;
    (void)state;
    assert_int_equal(files_write(path_of("t.csv"), "a,b\n1,2\n3,\n"), STATUS_OK);
    assert_int_equal(table_read(&table, path_of("t.csv")), STATUS_OK);
    assert_int_equal(table.rows, 2);
    assert_int_equal(table_column(&table, "b", &column), STATUS_OK);
    assert_true(column[0] == 2 && isnan(column[1]));
    assert_int_equal(table_column(&table, "c", &column), STATUS_FORMAT);
    table_free(&table);
    assert_int_equal(files_write(path_of("t.csv"), "a,b\n1,2,3\n"), STATUS_OK);
    assert_int_equal(table_read(&table, path_of("t.csv")), STATUS_FORMAT);
    assert_int_equal(files_write(path_of("t.csv"), "a,b\n1\n"), STATUS_OK);
    assert_int_equal(table_read(&table, path_of("t.csv")), STATUS_FORMAT);
}

static void spreads_are_printed(void **state)
{
    static const struct {
        struct spread spread;
        const char *text;
    } form[] = {{{722.14, 9.36, 5}, "722.1 ± 9.4"}, {{0.1853, 0.0071, 5}, "0.1853 ± 0.0071"},
                {{24441, 616, 5}, "24441 ± 616"},   {{3.2e-7, 0.5e-7, 3}, "(3.20 ± 0.50)·10^-7"},
                {{715.3, NAN, 1}, "715.3"},         {{NAN, NAN, 0}, "–"}};
    char text[64];
    (void)state;
    for (size_t k = 0; k < sizeof form / sizeof *form; k++)
        assert_string_equal(report_spread_text(&form[k].spread, text, sizeof text), form[k].text);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_files_are_refused),    cmocka_unit_test(runs_share_preparations),
        cmocka_unit_test(settings_have_their_hash),   cmocka_unit_test(broken_scenes_name_their_run),
        cmocka_unit_test(stale_results_go),           cmocka_unit_test(spreads_have_closed_forms),
        cmocka_unit_test(tangents_have_closed_forms), cmocka_unit_test(decays_are_found),
        cmocka_unit_test(slopes_have_closed_forms),   cmocka_unit_test(tables_are_read),
        cmocka_unit_test(spreads_are_printed),
    };
    if (argc != 2 || !mkdtemp(folder))
        return 2;
    source = argv[1];
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    char command[128];
    snprintf(command, sizeof command, "rm -rf %s", folder);
    return system(command) == 0 ? failures : 1;
}
