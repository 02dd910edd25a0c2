/* The reader against damaged files, what the analyzer writes, and the program as a whole. */
#include "test_analyzer_fixture.h"

#include <hdf5.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "analyzer/analysis_files.h"
#include "analyzer/ensemble.h"
#include "analyzer/plots.h"

static const char *analyzer_path; /* the program, from the command line */

struct place {
    char directory[256];
};

static int setup(void **state)
{
    struct place *place = calloc(1, sizeof *place);
    assert_non_null(place);
    fixture_directory_make(place->directory, sizeof place->directory);
    *state = place;
    return 0;
}

static int teardown(void **state)
{
    struct place *place = *state;
    fixture_directory_remove(place->directory);
    free(place);
    return 0;
}

static void biaxial_written(const char *directory, bool complete, const struct flaw *flaw)
{
    struct random random = {3};
    struct run run;
    fixture_biaxial(&run, &(struct biaxial_model){.n = 501, .stress_noise_pa = 2, .strain_noise = 2e-5}, &random);
    run.complete = complete;
    fixture_write(&run, fixture_biaxial_config, directory, flaw);
    run_free(&run);
}

/* Reading must fail with `status`, and the message must name the file and `what`. */
static void assert_refused(const char *directory, enum status status, const char *what)
{
    struct run run;
    char path[512];
    snprintf(path, sizeof path, "%s/run.h5", directory);
    assert_int_equal(run_read(&run, path), status);
    if (!strstr(status_message(), path) || !strstr(status_message(), what))
        fail_msg("the message does not name %s and %s: %s", path, what, status_message());
}

static void reads_back(void **state)
{
    const struct place *place = *state;
    struct random random = {3};
    struct run written, run;
    char path[512];
    fixture_biaxial(&written, &(struct biaxial_model){.n = 51}, &random);
    fixture_write(&written, fixture_biaxial_config, place->directory, NULL);
    snprintf(path, sizeof path, "%s/run.h5", place->directory);
    assert_int_equal(run_read(&run, path), STATUS_OK);
    assert_int_equal(run.n_samples, written.n_samples);
    assert_int_equal(run.seed, 7);
    assert_true(run.complete);
    assert_string_equal(run.name, "synthetic");
    for (int k = 0; k < OBSERVABLES; k++)
        assert_memory_equal(run.value[k], written.value[k], run.n_samples * run.width[k] * sizeof(double));
    run_free(&run);
    run_free(&written);
}

static void missing_parts(void **state)
{
    const struct place *place = *state;
    assert_refused(place->directory, STATUS_IO, "No such file");
    biaxial_written(place->directory, true, &(struct flaw){.omit = "stress_wall_pa"});
    assert_refused(place->directory, STATUS_FORMAT, "/samples/stress_wall_pa/value: missing");
    biaxial_written(place->directory, true, &(struct flaw){.misshape = "fabric"});
    assert_refused(place->directory, STATUS_FORMAT, "/samples/fabric/value: wrong shape");
    biaxial_written(place->directory, true, &(struct flaw){.attribute = "effective_config"});
    assert_refused(place->directory, STATUS_FORMAT, "effective_config: missing");
    biaxial_written(place->directory, true, &(struct flaw){.attribute = "seed"});
    assert_refused(place->directory, STATUS_FORMAT, "seed: missing");
}

/* A file of a version that did not record one of the residuals: all else as ever, that one undefined, with a reason. */
static void of_an_earlier_version(void **state)
{
    const struct place *place = *state;
    struct analysis now, then;
    biaxial_written(place->directory, true, NULL);
    assert_int_equal(analysis_make(&now, place->directory, NULL), STATUS_OK);
    biaxial_written(place->directory, true, &(struct flaw){.omit = "controller_residual_j"});
    if (analysis_make(&then, place->directory, NULL) != STATUS_OK)
        fail_msg("%s", status_message());
    for (int id = 0; id < QUANTITIES; id++) {
        if (id == QUANTITY_CONTROLLER_RESIDUAL || isnan(now.quantity[id].value))
            continue;
        assert_true(then.quantity[id].value == now.quantity[id].value);
    }
    assert_true(isfinite(now.quantity[QUANTITY_CONTROLLER_RESIDUAL].value));
    assert_true(isnan(then.quantity[QUANTITY_CONTROLLER_RESIDUAL].value));
    assert_non_null(strstr(then.quantity[QUANTITY_CONTROLLER_RESIDUAL].text, "earlier version"));
    analysis_free(&now);
    analysis_free(&then);
    biaxial_written(place->directory, true, &(struct flaw){.omit = "interface_residual_j"});
    assert_refused(place->directory, STATUS_FORMAT, "/samples/interface_residual_j/value: missing");
}

/* What run.h5 says is data: no file that it names is read into the configuration, with settings on top or without. */
static void includes_are_refused(void **state)
{
    const struct place *place = *state;
    static const char *const settings[] = {"analysis.peak_band=0.1"};
    char path[512], text[8192];
    struct run written, read;
    fixture_run(&written, fixture_biaxial_config, 10);
    snprintf(path, sizeof path, "%s/other.cfg", place->directory);
    FILE *other = fopen(path, "w");
    assert_non_null(other);
    assert_true(fputs("seed = 5;\n", other) >= 0);
    assert_int_equal(fclose(other), 0);
    snprintf(text, sizeof text, "@include \"%s\"\n%s", path, fixture_biaxial_config);
    fixture_write(&written, text, place->directory, NULL);
    snprintf(path, sizeof path, "%s/run.h5", place->directory);
    for (int n = 0; n < 2; n++) {
        assert_int_equal(run_read_set(&read, path, settings, n), STATUS_CONFIG);
        assert_non_null(strstr(status_message(), "@include is not allowed"));
    }
    run_free(&written);
}

/* A file of a version that had the samples where the frames' now are. */
static void samples_where_they_were(void **state)
{
    const struct place *place = *state;
    struct analysis now, then;
    char path[512];
    biaxial_written(place->directory, true, NULL);
    assert_int_equal(analysis_make(&now, place->directory, NULL), STATUS_OK);
    snprintf(path, sizeof path, "%s/run.h5", place->directory);
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
    assert_true(H5Lmove(file, "/samples", file, "/observables", H5P_DEFAULT, H5P_DEFAULT) >= 0);
    assert_true(H5Fclose(file) >= 0);
    assert_int_equal(analysis_make(&then, place->directory, NULL), STATUS_OK);
    for (int id = 0; id < QUANTITIES; id++)
        assert_true(isnan(now.quantity[id].value) || then.quantity[id].value == now.quantity[id].value);
    analysis_free(&now);
    analysis_free(&then);
}

/* Cut at every tenth of its length, and not HDF5 at all: refused or read, never a crash; the head alone is refused. */
static void truncated(void **state)
{
    const struct place *place = *state;
    char path[512];
    struct stat info;
    snprintf(path, sizeof path, "%s/run.h5", place->directory);
    biaxial_written(place->directory, true, NULL);
    assert_int_equal(stat(path, &info), 0);
    for (int tenth = 9; tenth >= 0; tenth--) {
        assert_int_equal(truncate(path, info.st_size * tenth / 10), 0);
        assert_refused(place->directory, STATUS_FORMAT, "truncated");
    }
}

static void wrong_content(void **state)
{
    const struct place *place = *state;
    struct random random = {3};
    struct run run;
    fixture_biaxial(&run, &(struct biaxial_model){.n = 51}, &random);
    fixture_write(&run, "dimension = 2;", place->directory, NULL);
    assert_refused(place->directory, STATUS_CONFIG, "effective_config");
    fixture_write(&run, fixture_cyclic_config, place->directory, NULL);
    assert_refused(place->directory, STATUS_FORMAT, "dimension 2 does not fit the scene's 3");
    fixture_set(&run, OBSERVABLE_BOX_LENGTH, 17, 1, 0);
    fixture_write(&run, fixture_biaxial_config, place->directory, NULL);
    assert_refused(place->directory, STATUS_FORMAT, "record 17 is not positive");
    run_free(&run);
}

/* Observables of unequal length: an error in a complete run; in one that was cut off, the shortest counts. */
static void unequal_lengths(void **state)
{
    const struct place *place = *state;
    struct run run;
    char path[512];
    snprintf(path, sizeof path, "%s/run.h5", place->directory);
    biaxial_written(place->directory, true, &(struct flaw){.shorten = "fabric"});
    assert_refused(place->directory, STATUS_FORMAT, "/samples/fabric/value: 505 records where the others have 506");
    biaxial_written(place->directory, false, &(struct flaw){.shorten = "fabric"});
    assert_int_equal(run_read(&run, path), STATUS_OK);
    assert_int_equal(run.n_samples, 505);
    assert_false(run.complete);
    run_free(&run);
}

/* In the place of a scalar, `records` bytes of which the first `stored` are in the file: as much as deflation could
 * stand for the rest. */
static void claim_records(const char *directory, const char *object, hsize_t records, hsize_t stored)
{
    char path[512];
    const hsize_t start = 0;
    snprintf(path, sizeof path, "%s/run.h5", directory);
    signed char *bytes = calloc(stored, 1);
    const hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT), properties = H5Pcreate(H5P_DATASET_CREATE);
    const hid_t space = H5Screate_simple(1, &records, NULL), memory = H5Screate_simple(1, &stored, NULL);
    assert_non_null(bytes);
    assert_true(H5Pset_chunk(properties, 1, &stored) >= 0 && H5Ldelete(file, object, H5P_DEFAULT) >= 0);
    const hid_t id = H5Dcreate2(file, object, H5T_NATIVE_SCHAR, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    assert_true(H5Sselect_hyperslab(space, H5S_SELECT_SET, &start, NULL, &stored, NULL) >= 0);
    assert_true(H5Dwrite(id, H5T_NATIVE_SCHAR, memory, space, H5P_DEFAULT, bytes) >= 0);
    assert_true(H5Dclose(id) >= 0 && H5Sclose(memory) >= 0 && H5Sclose(space) >= 0 && H5Pclose(properties) >= 0);
    assert_true(H5Fclose(file) >= 0);
    free(bytes);
}

/* More than is ever read, though the file may hold it; and more than it can hold. */
static void too_many_records(void **state)
{
    const struct place *place = *state;
    biaxial_written(place->directory, true, NULL);
    claim_records(place->directory, "/samples/solid_fraction/value", 100000001, 100000);
    assert_refused(place->directory, STATUS_FORMAT, "claims 100000001 records; at most 100000000 are read");
    claim_records(place->directory, "/samples/solid_fraction/value", 100000000, 90000);
    assert_refused(place->directory, STATUS_FORMAT, "claims more records than the file holds");
}

static json_t *json_of(const char *directory, const char *name)
{
    char path[512];
    json_error_t error;
    snprintf(path, sizeof path, "%s/%s", directory, name);
    json_t *root = json_load_file(path, 0, &error);
    if (!root)
        fail_msg("%s: %s", path, error.text);
    return root;
}

/* The number under a dotted key. */
static double number_of(json_t *root, const char *key, const char *member)
{
    char copy[128], *rest = copy;
    snprintf(copy, sizeof copy, "%s", key);
    for (char *part; (part = strsep(&rest, "."));)
        root = json_object_get(root, part);
    json_t *number = json_object_get(root, member);
    if (!json_is_number(number))
        fail_msg("%s.%s is not a number", key, member);
    return json_number_value(number);
}

static void write_all(const char *directory, struct analysis *analysis)
{
    int n_plots;
    assert_int_equal(analysis_make(analysis, directory, NULL), STATUS_OK);
    assert_int_equal(analysis_write(analysis), STATUS_OK);
    if (plots_write(analysis, &n_plots) != STATUS_OK)
        fail_msg("%s", status_message());
    assert_int_equal(n_plots, analysis->curves.controls.kind == TEST_CYCLIC ? 7 : 5);
}

static size_t file_size(const char *directory, const char *name)
{
    char path[512];
    struct stat info;
    snprintf(path, sizeof path, "%s/%s", directory, name);
    return stat(path, &info) == 0 ? (size_t)info.st_size : 0;
}

/* A PNG of at least 10 kB (an empty frame of this size has 6 kB or less) with its signature; an SVG that is closed and
 * has paths. */
static void assert_plot(const char *directory, const char *stem)
{
    char name[64], path[512], text[9] = "";
    snprintf(name, sizeof name, "%s.png", stem);
    assert_true(file_size(directory, name) > 10000);
    snprintf(path, sizeof path, "%s/%s.png", directory, stem);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fread(text, 1, 8, file), 8);
    assert_memory_equal(text, "\x89PNG\r\n\x1a\n", 8);
    assert_int_equal(fclose(file), 0);
    snprintf(name, sizeof name, "%s.svg", stem);
    size_t size = file_size(directory, name);
    assert_true(size > 5000);
    char *svg = calloc(size + 1, 1);
    snprintf(path, sizeof path, "%s/%s.svg", directory, stem);
    assert_non_null(svg);
    file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fread(svg, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    assert_non_null(strstr(svg, "<path"));
    assert_non_null(strstr(svg + size - 20, "</svg>"));
    free(svg);
}

/* JSON holds what was computed; undefined is null with a reason; CSV has every sample. */
static void biaxial_outputs(void **state)
{
    const struct place *place = *state;
    struct analysis analysis;
    biaxial_written(place->directory, true, NULL);
    write_all(place->directory, &analysis);
    json_t *root = json_of(place->directory, "analysis.json");
    assert_near(number_of(root, "E_initial_pa", "value"), analysis.quantity[QUANTITY_E_INITIAL].value, 0);
    assert_near(number_of(root, "peak.sigma_corr_pa", "uncertainty"),
                analysis.quantity[QUANTITY_PEAK_SIGMA_CORR].uncertainty, 0);
    /* residual 5e-4 eps over work 5 eps; contact stress 1 % larger; initial values of the fixture: all exact to
     * rounding */
    assert_near(number_of(root, "energy_residual", "value"), 1e-4, 1e-15);
    assert_near(number_of(root, "interface_residual", "value"), 5e-4, 1e-15);
    assert_near(number_of(root, "controller_residual", "value"), 2e-3, 1e-15);
    assert_near(number_of(root, "stress_wall_contact_difference", "value"), 0.01, 1e-12);
    assert_near(number_of(root, "initial.phi", "value"), 0.88, 1e-15);
    assert_near(number_of(root, "initial.coordination", "value"), 4.2, 1e-15);
    assert_true(json_is_true(json_object_get(root, "complete")));
    assert_true(json_is_null(json_object_get(root, "cycles")));
    assert_near(number_of(root, "run", "seed"), 7, 0);
    json_decref(root);
    assert_plot(place->directory, "stress_strain");
    assert_plot(place->directory, "volumetric_strain");
    assert_plot(place->directory, "fabric");
    assert_true(file_size(place->directory, "curves.csv") > 501 * CURVES * 2);
    analysis_free(&analysis);
}

static double steady(double x, const void *context)
{
    (void)context;
    return 5e-5 * pow(x, 0.8);
}

static void cyclic_outputs(void **state)
{
    const struct place *place = *state;
    struct analysis analysis;
    struct run run;
    fixture_cyclic(&run, &(struct cyclic_model){30, 64, steady, NULL});
    fixture_write(&run, fixture_cyclic_config, place->directory, NULL);
    run_free(&run);
    write_all(place->directory, &analysis);
    json_t *root = json_of(place->directory, "analysis.json"), *cycles = json_object_get(root, "cycles");
    assert_string_equal(json_string_value(json_object_get(cycles, "classification")), "ratcheting");
    assert_int_equal(json_array_size(json_object_get(cycles, "per_cycle")), 30);
    assert_near(number_of(root, "cycles.accumulation_exponent", "value"), 0.8, 1e-9);
    assert_null(json_object_get(root, "E_initial_pa")); /* no quantity of a cyclic test */
    json_t *ratio = json_object_get(cycles, "r_u_max");
    assert_true(json_is_null(json_object_get(ratio, "value")));
    assert_non_null(json_string_value(json_object_get(ratio, "reason")));
    json_decref(root);
    /* the work goes to 0 at the end of each cycle: over 30 x 2 x 2e-3 J */
    assert_near(analysis.quantity[QUANTITY_ENERGY_RESIDUAL].value, 1e-6 / 0.12, 1e-12);
    assert_plot(place->directory, "loops");
    assert_plot(place->directory, "path");
    assert_plot(place->directory, "accumulation");
    assert_plot(place->directory, "accumulation_log");
    assert_true(file_size(place->directory, "cycles.csv") > 30 * 20);
    analysis_free(&analysis);
}

/* 1, 2, 3: mean 2, s.d. 1, standard error 1/sqrt 3; the undefined are left out. */
static void ensemble_statistics(void **state)
{
    const struct place *place = *state;
    struct ensemble ensemble = {0};
    struct analysis *analysis = calloc(1, sizeof *analysis);
    char path[512];
    assert_non_null(analysis);
    for (int k = 0; k < 4; k++) {
        for (int id = 0; id < QUANTITIES; id++)
            quantity_undefined(&analysis->quantity[id], "not made");
        quantity_set(&analysis->quantity[QUANTITY_NU], (struct estimate){k < 3 ? k + 1 : NAN, 0.5});
        assert_int_equal(ensemble_add(&ensemble, analysis), STATUS_OK);
    }
    snprintf(path, sizeof path, "%s/ensemble.json", place->directory);
    assert_int_equal(ensemble_write(&ensemble, path), STATUS_OK);
    json_t *root = json_of(place->directory, "ensemble.json");
    assert_near(number_of(root, "nu", "mean"), 2, 1e-15);
    assert_near(number_of(root, "nu", "n"), 3, 0);
    assert_near(number_of(root, "nu", "standard_deviation"), 1, 1e-15);
    assert_near(number_of(root, "nu", "standard_error"), 1 / sqrt(3), 1e-15);
    assert_near(number_of(root, "nu", "uncertainty_within_runs"), 0.5, 1e-15);
    assert_null(json_object_get(root, "E50_pa")); /* no run has it */
    json_decref(root);
    ensemble_free(&ensemble);
    free(analysis);
}

/* Runs the program; returns its exit code, its output (both streams) in `text`. */
static int program_run(const char *arguments, char *text, size_t size)
{
    char command[2048];
    snprintf(command, sizeof command, "%s %s 2>&1", analyzer_path, arguments);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    size_t length = fread(text, 1, size - 1, pipe);
    text[length] = '\0';
    int how = pclose(pipe);
    assert_true(WIFEXITED(how));
    return WEXITSTATUS(how);
}

/* One good run, cut off, and one directory without a run: a verdict, an error, the exit code of the first, and the
 * ensemble of what there is. A series over a key that is none: an error that names those that are there, and no table.
 */
static void program(void **state)
{
    const struct place *place = *state;
    char text[16384], arguments[1024];
    biaxial_written(place->directory, false, NULL);
    snprintf(arguments, sizeof arguments, "--no-plots --out %s %s %s/nowhere", place->directory, place->directory,
             place->directory);
    assert_int_equal(program_run(arguments, text, sizeof text), 9);
    assert_non_null(strstr(text, "INTERRUPTED at"));
    assert_non_null(strstr(text, "verdict: failed"));
    assert_non_null(strstr(text, "nowhere/run.h5: No such file"));
    assert_non_null(strstr(text, "peak.sigma_corr_pa"));
    json_t *root = json_of(place->directory, "analysis.json");
    assert_true(json_is_false(json_object_get(root, "complete")));
    json_decref(root);
    root = json_of(place->directory, "ensemble.json");
    assert_near(json_number_value(json_object_get(root, "n_incomplete")), 1, 0);
    json_decref(root);
    biaxial_written(place->directory, true, NULL);
    snprintf(arguments, sizeof arguments, "--no-plots --series material.mus %s", place->directory);
    assert_int_equal(program_run(arguments, text, sizeof text), 2);
    assert_non_null(strstr(text, "'material.mus' is no number of the scene; numbers there: kn_n_per_m, k1_n_per_m"));
    assert_null(strstr(text, "series over"));
    assert_int_equal(program_run("", text, sizeof text), 2);
    assert_int_equal(program_run("--unknown x", text, sizeof text), 2);
    assert_int_equal(program_run("--help", text, sizeof text), 0);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(reads_back, setup, teardown),
        cmocka_unit_test_setup_teardown(missing_parts, setup, teardown),
        cmocka_unit_test_setup_teardown(of_an_earlier_version, setup, teardown),
        cmocka_unit_test_setup_teardown(samples_where_they_were, setup, teardown),
        cmocka_unit_test_setup_teardown(includes_are_refused, setup, teardown),
        cmocka_unit_test_setup_teardown(truncated, setup, teardown),
        cmocka_unit_test_setup_teardown(wrong_content, setup, teardown),
        cmocka_unit_test_setup_teardown(unequal_lengths, setup, teardown),
        cmocka_unit_test_setup_teardown(too_many_records, setup, teardown),
        cmocka_unit_test_setup_teardown(biaxial_outputs, setup, teardown),
        cmocka_unit_test_setup_teardown(cyclic_outputs, setup, teardown),
        cmocka_unit_test_setup_teardown(ensemble_statistics, setup, teardown),
        cmocka_unit_test_setup_teardown(program, setup, teardown),
    };
    if (argc != 2) {
        fprintf(stderr, "usage: %s ANALYZER\n", argv[0]);
        return 2;
    }
    analyzer_path = argv[1];
    return cmocka_run_group_tests(tests, NULL, NULL);
}
