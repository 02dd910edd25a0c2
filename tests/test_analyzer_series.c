/* A series of runs: the key's value from the scene in force, order, table and CSV. */
#include "test_analyzer_fixture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "analyzer/plots.h"
#include "analyzer/series.h"

static void keys(void **state)
{
    struct run run;
    double value = 0;
    (void)state;
    fixture_run(&run, fixture_cyclic_config, 2);
    assert_int_equal(series_key_value(run.scene, "sample.count", &value), STATUS_OK);
    assert_near(value, (double)run.scene->sample.count, 0);
    assert_int_equal(series_key_value(run.scene, "material.kn_n_per_m", &value), STATUS_OK);
    assert_near(value, run.scene->material.kn_n_per_m, 0);
    assert_int_equal(series_key_value(run.scene, "stages.0.dt_s", &value), STATUS_OK);
    assert_near(value, run.scene->stage[0].dt_s, 0);
    assert_int_equal(series_key_value(run.scene, "material.nothing", &value), STATUS_USAGE);
    assert_int_equal(series_key_value(run.scene, "material.law", &value), STATUS_USAGE);
    assert_int_equal(series_key_value(run.scene, "stages.9.dt_s", &value), STATUS_USAGE);
    run_free(&run);
}

/* A bound of a condition is a list of one; a band has no number. */
static void bounds(void **state)
{
    struct run run;
    double value = 0;
    (void)state;
    fixture_run(&run, fixture_biaxial_config, 2);
    struct config_band *band = &run.scene->stage[0].axis[AXIS_Z].until_strain;
    *band = (struct config_band){.count = 1, .value = {0.25}};
    assert_int_equal(series_key_value(run.scene, "stages.0.walls.z.until_strain", &value), STATUS_OK);
    assert_near(value, 0.25, 0);
    *band = (struct config_band){.count = 2, .value = {0.1, 0.25}};
    assert_int_equal(series_key_value(run.scene, "stages.0.walls.z.until_strain", &value), STATUS_USAGE);
    run_free(&run);
}

/* Two curves, out of order; the second point of "b" has no peak. */
static void make(struct ensemble *ensemble)
{
    static const char *const names[] = {"b", "a", "a", "b"};
    static const double at[] = {0.5, 0.4, 0.1, 1};
    struct analysis *analysis = calloc(1, sizeof *analysis);
    assert_non_null(analysis);
    for (int k = 0; k < 4; k++) {
        snprintf(analysis->run.name, sizeof analysis->run.name, "%s", names[k]);
        for (int id = 0; id < QUANTITIES; id++)
            quantity_undefined(&analysis->quantity[id], "not made");
        quantity_set(&analysis->quantity[QUANTITY_PEAK_SIN_PHI], (struct estimate){k < 3 ? at[k] / 2 : NAN, 0.01});
        assert_int_equal(ensemble_add(ensemble, analysis), STATUS_OK);
        ensemble->member[k].key_value = at[k];
    }
    free(analysis);
}

static char *content_of(const char *path)
{
    char *text = calloc(1, 65536);
    FILE *in = fopen(path, "r");
    assert_non_null(in);
    assert_non_null(text);
    assert_true(fread(text, 1, 65535, in) > 0);
    assert_int_equal(fclose(in), 0);
    return text;
}

static void table(void **state)
{
    struct ensemble ensemble = {0};
    char directory[512], path[600];
    int curves = 0;
    (void)state;
    make(&ensemble);
    series_sort(&ensemble);
    assert_near(ensemble.member[0].key_value, 0.1, 0);
    assert_near(ensemble.member[1].key_value, 0.4, 0);
    assert_near(ensemble.member[3].key_value, 1, 0);
    fixture_directory_make(directory, sizeof directory);
    assert_int_equal(series_check(&ensemble, "material.mu_s"), STATUS_OK);
    assert_int_equal(series_write(&ensemble, "material.mu_s", directory, &curves), STATUS_OK);
    assert_int_equal(curves, 2); /* peaks of a and of b; nothing else is there */
    snprintf(path, sizeof path, "%s/series.csv", directory);
    char *text = content_of(path);
    assert_non_null(strstr(text, "name,material.mu_s,seed,classification,E_initial_pa,u(E_initial_pa)"));
    const char *first = strstr(text, "\"a\",0.1,"), *block = strstr(text, "\n\n\n\"b\",0.5,");
    assert_true(first && block && first < block);
    free(text);
    series_print(stdout, &ensemble, "material.mu_s");
    assert_int_equal(series_write(&ensemble, "material.mu_s", "/nowhere/at/all", &curves), STATUS_IO);
    for (int k = 0; k < 4; k++)
        ensemble.member[k].key_value = 0;
    assert_int_equal(series_check(&ensemble, "material.mu_s"), STATUS_USAGE);
    assert_non_null(strstr(status_message(), "all 4 runs have material.mu_s = 0"));
    fixture_directory_remove(directory);
    ensemble_free(&ensemble);
}

/* A run's name is data: to gnuplot as to the table. What it says would leave a file if any of it were carried out. */
static void a_name_is_a_text(void **state)
{
    static const char odd[] = "it's `touch beacon` \"$(touch beacon)\"\n'; system('touch beacon') #";
    struct ensemble ensemble = {0};
    char directory[512], path[600];
    int curves = 0;
    (void)state;
    make(&ensemble);
    for (int k = 0; k < 4; k++)
        snprintf(ensemble.member[k].name, sizeof ensemble.member[k].name, "%s", odd);
    fixture_directory_make(directory, sizeof directory);
    assert_int_equal(series_write(&ensemble, "material.mu_s", directory, &curves), STATUS_OK);
    assert_int_equal(curves, 1);
    if (plots_run(directory, "series") != STATUS_OK)
        fail_msg("%s", status_message());
    snprintf(path, sizeof path, "%s/beacon", directory);
    assert_int_equal(access(path, F_OK), -1);
    snprintf(path, sizeof path, "%s/series.svg", directory);
    char *text = content_of(path);
    assert_non_null(strstr(text, "it's `touch beacon` \"$(touch beacon)\" '; system('touch beacon') #"));
    free(text);
    snprintf(path, sizeof path, "%s/series.csv", directory);
    text = content_of(path);
    assert_non_null(strstr(text, "\n\"it's `touch beacon` \"\"$(touch beacon)\"\" '; system('touch beacon') #\",0.5,"));
    free(text);
    fixture_directory_remove(directory);
    ensemble_free(&ensemble);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(keys), cmocka_unit_test(bounds), cmocka_unit_test(table),
                                       cmocka_unit_test(a_name_is_a_text)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
