#include "test_analyzer_fixture.h"
#include "common/scene_file.h"

#include <dirent.h>
#include <hdf5.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define SAMPLE                                                                                                         \
    "sample = { count = 100; radius_min_m = 5e-4; radius_max_m = 15e-4; density_kg_per_m3 = 2000.0; };\n"              \
    "material = { law = \"linear\"; kn_n_per_m = 1e5; };\n"

const char fixture_biaxial_config[] =
    "name = \"synthetic\"; dimension = 2; seed = 7; analysis = { strain = \"logarithmic\"; };\n" SAMPLE
    "stages = ( { name = \"relax\"; dt_s = 1e-6; duration_s = 0.01;\n"
    "             walls = { x = { mode = \"stress\"; pressure_pa = 500.0; mass_kg = 1e-4; };\n"
    "                       z = { mode = \"stress\"; pressure_pa = 500.0; mass_kg = 1e-4; }; }; },\n"
    "           { name = \"test\"; dt_s = 1e-6; duration_s = 0.06;\n"
    "             walls = { x = { mode = \"stress\"; pressure_pa = 500.0; mass_kg = 1e-4; };\n"
    "                       z = { mode = \"strain\"; strain = 0.035; frequency_hz = 10.0; }; }; } );\n";

const char fixture_cyclic_config[] =
    "name = \"cycles\"; dimension = 3; seed = 3;\n" SAMPLE
    "stages = ( { name = \"cycles\"; dt_s = 1e-5; duration_s = 1e3;\n"
    "  walls = { x = { mode = \"stress\"; target = \"cosine\"; pressure_pa = 1000.0; amplitude_pa = 200.0; period_s = "
    "10.0;\n"
    "                  mass_kg = 2.0; };\n"
    "            y = { mode = \"stress\"; pressure_pa = 1000.0; mass_kg = 2.0; };\n"
    "            z = { mode = \"stress\"; pressure_pa = 1000.0; mass_kg = 2.0; }; }; } );\n";

void assert_near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.15g is not within %.3g of %.15g", value, tolerance, expected);
}

double random_uniform(struct random *random)
{
    uint64_t z = random->state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return ((double)((z ^ (z >> 31)) >> 11) + 0.5) * 0x1p-53;
}

double random_normal(struct random *random)
{
    double radius = sqrt(-2 * log(random_uniform(random)));
    return radius * cos(2 * M_PI * random_uniform(random));
}

static size_t width(enum observable_shape shape, int dimension)
{
    size_t d = (size_t)dimension;
    return shape == SHAPE_SCALAR ? 1 : shape == SHAPE_VECTOR ? d : d * d;
}

static const struct {
    const char *name;
    enum observable_shape shape;
} observables[OBSERVABLES] = {
#define NAME(id, name, shape) {name, shape},
    OBSERVABLE_LIST(NAME)
#undef NAME
};

void fixture_set(struct run *run, enum observable observable, size_t i, size_t k, double value)
{
    run->value[observable][i * run->width[observable] + k] = value;
}

static void sample_defaults(struct run *run, size_t i)
{
    int d = run->dimension;
    run->step[i] = (double)i;
    for (int k = 0; k < d; k++) {
        fixture_set(run, OBSERVABLE_BOX_LENGTH, i, (size_t)k, 0.1);
        fixture_set(run, OBSERVABLE_FABRIC, i, (size_t)(k * d + k), 1.0 / d);
    }
    fixture_set(run, OBSERVABLE_SOLID_FRACTION, i, 0, 0.88);
    fixture_set(run, OBSERVABLE_COORDINATION, i, 0, 4);
    fixture_set(run, OBSERVABLE_COORDINATION_NO_RATTLERS, i, 0, 4.2);
}

void fixture_run(struct run *run, const char *config, size_t n)
{
    memset(run, 0, sizeof *run);
    run->scene = calloc(1, sizeof *run->scene);
    assert_non_null(run->scene);
    if (scene_parse(run->scene, config, "fixture") != STATUS_OK)
        fail_msg("%s", status_message());
    snprintf(run->name, sizeof run->name, "%s", run->scene->name);
    snprintf(run->version, sizeof run->version, "0.1.0");
    snprintf(run->kernel_set, sizeof run->kernel_set, "reference");
    run->seed = run->scene->seed;
    run->dimension = (int)run->scene->dimension;
    run->complete = true;
    run->elapsed_s = 1.5;
    run->n_samples = n;
    run->step = calloc(n + 1, sizeof *run->step);
    run->time_s = calloc(n + 1, sizeof *run->time_s);
    assert_true(run->step && run->time_s);
    for (int k = 0; k < OBSERVABLES; k++) {
        run->width[k] = width(observables[k].shape, run->dimension);
        run->value[k] = calloc((n + 1) * run->width[k], sizeof(double));
        assert_non_null(run->value[k]);
    }
    for (size_t i = 0; i < n; i++)
        sample_defaults(run, i);
}

static void text_write(hid_t group, const char *name, const char *text)
{
    hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
    assert_true(H5Tset_size(type, strlen(text) + 1) >= 0);
    hid_t attribute = H5Acreate2(group, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    assert_true(H5Awrite(attribute, type, text) >= 0);
    assert_true(H5Aclose(attribute) >= 0 && H5Sclose(space) >= 0 && H5Tclose(type) >= 0);
}

static void number_write(hid_t object, const char *name, hid_t type, const void *value)
{
    hid_t space = H5Screate(H5S_SCALAR);
    hid_t attribute = H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    assert_true(H5Awrite(attribute, type, value) >= 0);
    assert_true(H5Aclose(attribute) >= 0 && H5Sclose(space) >= 0);
}

static void dataset_write(hid_t file, const char *path, size_t n, size_t columns, const double *values)
{
    hsize_t size[2] = {n, columns};
    hid_t links = H5Pcreate(H5P_LINK_CREATE), space = H5Screate_simple(columns > 1 ? 2 : 1, size, NULL);
    assert_true(H5Pset_create_intermediate_group(links, 1) >= 0);
    hid_t dataset = H5Dcreate2(file, path, H5T_NATIVE_DOUBLE, space, links, H5P_DEFAULT, H5P_DEFAULT);
    assert_true(dataset >= 0);
    assert_true(n == 0 || H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
    assert_true(H5Dclose(dataset) >= 0 && H5Sclose(space) >= 0 && H5Pclose(links) >= 0);
}

/* A dataset of 2^40 rows of which none is there. */
static void huge_write(hid_t file, const char *path, size_t columns)
{
    hsize_t size[2] = {(hsize_t)1 << 40, columns}, chunk[2] = {64, columns};
    hid_t links = H5Pcreate(H5P_LINK_CREATE), layout = H5Pcreate(H5P_DATASET_CREATE);
    hid_t space = H5Screate_simple(columns > 1 ? 2 : 1, size, NULL);
    assert_true(H5Pset_create_intermediate_group(links, 1) >= 0);
    assert_true(H5Pset_chunk(layout, columns > 1 ? 2 : 1, chunk) >= 0);
    hid_t dataset = H5Dcreate2(file, path, H5T_NATIVE_DOUBLE, space, links, layout, H5P_DEFAULT);
    assert_true(dataset >= 0 && H5Dclose(dataset) >= 0);
    assert_true(H5Sclose(space) >= 0 && H5Pclose(links) >= 0 && H5Pclose(layout) >= 0);
}

/* Texts of 512 bytes, as the recorder writes them. */
static void notes_write(hid_t file, const struct run *run)
{
    enum { BYTES = 512 };
    static const char *const severities[] = {"note", "doubtful", "failed"};
    hsize_t size = run->n_notes;
    char *texts = calloc(run->n_notes, BYTES);
    assert_non_null(texts);
    for (size_t k = 0; k < run->n_notes; k++)
        snprintf(texts + k * BYTES, BYTES, "%.100s;%s;%.380s", run->note[k].stage, severities[run->note[k].severity],
                 run->note[k].text);
    hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate_simple(1, &size, NULL);
    assert_true(H5Tset_size(type, BYTES) >= 0);
    hid_t dataset = H5Dcreate2(file, "/notes", type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    assert_true(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts) >= 0);
    assert_true(H5Dclose(dataset) >= 0 && H5Sclose(space) >= 0 && H5Tclose(type) >= 0);
    free(texts);
}

static bool same(const char *flaw, const char *name)
{
    return flaw && strcmp(flaw, name) == 0;
}

static void parameters_write(hid_t file, const struct run *run, const char *config, const struct flaw *flaw)
{
    const struct {
        const char *name, *text;
    } texts[] = {
        {"name", run->name}, {"version", run->version}, {"kernel_set", run->kernel_set}, {"effective_config", config}};
    hid_t group = H5Gcreate2(file, "/parameters", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++)
        if (!same(flaw->attribute, texts[k].name))
            text_write(group, texts[k].name, texts[k].text);
    int64_t dimension = run->dimension;
    if (!same(flaw->attribute, "seed"))
        number_write(group, "seed", H5T_NATIVE_INT64, &run->seed);
    number_write(group, "dimension", H5T_NATIVE_INT64, &dimension);
    assert_true(H5Gclose(group) >= 0);
}

void fixture_write(const struct run *run, const char *config, const char *directory, const struct flaw *flaw)
{
    static const struct flaw none = {0};
    char path[600];
    int complete = run->complete;
    flaw = flaw ? flaw : &none;
    snprintf(path, sizeof path, "%s/run.h5", directory);
    hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    assert_true(file >= 0);
    number_write(file, "complete", H5T_NATIVE_INT, &complete);
    if (run->complete)
        number_write(file, "elapsed_s", H5T_NATIVE_DOUBLE, &run->elapsed_s);
    parameters_write(file, run, config, flaw);
    dataset_write(file, "/samples/stage/step", run->n_samples, 1, run->step);
    dataset_write(file, "/samples/stage/time", run->n_samples, 1, run->time_s);
    for (int k = 0; k < OBSERVABLES; k++) {
        const char *name = observables[k].name;
        size_t n = run->n_samples - (same(flaw->shorten, name) ? 1 : 0);
        snprintf(path, sizeof path, "/samples/%s/value", name);
        if (same(flaw->huge, name)) {
            huge_write(file, path, run->width[k]);
        } else if (same(flaw->misshape, name)) {
            double seven[7] = {0};
            dataset_write(file, path, 1, 7, seven);
        } else if (!same(flaw->omit, name)) {
            dataset_write(file, path, n, run->width[k], run->value[k]);
        }
    }
    if (run->n_notes > 0)
        notes_write(file, run);
    assert_true(H5Fclose(file) >= 0);
}

void fixture_directory_make(char *path, size_t size)
{
    const char *base = getenv("TMPDIR");
    snprintf(path, size, "%s/analyzer-XXXXXX", base ? base : "/tmp");
    assert_non_null(mkdtemp(path));
}

void fixture_directory_remove(const char *path)
{
    DIR *directory = opendir(path);
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));) {
        char file[1024];
        snprintf(file, sizeof file, "%s/%s", path, entry->d_name);
        if (entry->d_name[0] != '.')
            assert_int_equal(unlink(file), 0);
    }
    assert_int_equal(closedir(directory), 0);
    assert_int_equal(rmdir(path), 0);
}

double fixture_ratio(double eps)
{
    if (eps <= 0.001)
        return 1 + 200 * eps;
    if (eps < 0.006)
        return 1.2 + 0.328 * (eps - 0.001) / 0.005;
    if (eps <= 0.018)
        return 1.6 - 2000 * (eps - 0.012) * (eps - 0.012);
    return eps < 0.028 ? 1.528 - 0.128 * (eps - 0.018) / 0.01 : 1.4;
}

double fixture_eps_v(double eps)
{
    if (eps <= 0.002)
        return -0.31 * eps;
    return -0.31 * 0.002 + (eps > 0.008 ? 0.19 * (eps - 0.008) : 0);
}

/* Errors of three measured quantities, each an autoregression of unit variance. */
static void errors_next(double *error, double correlation, struct random *random, bool first)
{
    for (int k = 0; k < 3; k++) {
        double fresh = random_normal(random);
        error[k] = first ? fresh : correlation * error[k] + sqrt(1 - correlation * correlation) * fresh;
    }
}

void fixture_biaxial(struct run *run, const struct biaxial_model *model, struct random *random)
{
    enum { RELAX = 5 };
    double error[3] = {0}, p = 500;
    size_t n = model->n + model->rest;
    fixture_run(run, fixture_biaxial_config, RELAX + n);
    for (size_t i = 0; i < RELAX; i++)
        for (size_t k = 0; k < 2; k++)
            fixture_set(run, OBSERVABLE_STRESS_WALL, i, k, p);
    for (size_t i = 0; i < n; i++) {
        double s = fmin(1, (double)i / (double)(model->n - 1)), eps = 0.0175 * (1 - cos(M_PI * s));
        errors_next(error, model->correlation, random, i == 0);
        double eps_v = fixture_eps_v(eps) + (i ? model->strain_noise * error[2] : 0);
        size_t at = RELAX + i;
        run->time_s[at] = 0.01 + 0.05 * (double)i / (double)(model->n - 1);
        fixture_set(run, OBSERVABLE_STAGE, at, 0, 1);
        fixture_set(run, OBSERVABLE_STAGE_TIME, at, 0, run->time_s[at] - 0.01);
        fixture_set(run, OBSERVABLE_BOX_LENGTH, at, 0, 0.1 * exp(eps_v + eps));
        fixture_set(run, OBSERVABLE_BOX_LENGTH, at, 1, 0.1 * exp(-eps));
        double stress[2] = {p + model->stress_noise_pa * error[0],
                            p * fixture_ratio(eps) + model->stress_noise_pa * error[1]};
        for (size_t k = 0; k < 2; k++) {
            fixture_set(run, OBSERVABLE_STRESS_WALL, at, k, stress[k]);
            fixture_set(run, OBSERVABLE_STRESS_CONTACT, at, 3 * k, 1.01 * stress[k]);
        }
        fixture_set(run, OBSERVABLE_WORK_WALLS, at, 0, 5 * eps);
        fixture_set(run, OBSERVABLE_ENERGY_RESIDUAL, at, 0, -5e-4 * eps);
        fixture_set(run, OBSERVABLE_INTERFACE_RESIDUAL, at, 0, 2.5e-3 * eps);
        fixture_set(run, OBSERVABLE_CONTROLLER_RESIDUAL, at, 0, 1e-2 * eps);
        fixture_set(run, OBSERVABLE_COORDINATION, at, 0, 4.2 - 0.6 * (1 - exp(-eps / 0.004)));
        fixture_set(run, OBSERVABLE_COORDINATION_NO_RATTLERS, at, 0, 4.3 - 0.5 * (1 - exp(-eps / 0.004)));
        fixture_set(run, OBSERVABLE_SOLID_FRACTION, at, 0, 0.88 / exp(eps_v));
    }
}

void fixture_cyclic(struct run *run, const struct cyclic_model *model)
{
    size_t n = model->cycles * model->per_cycle + 1;
    double delta = 2 * M_PI * 4 / 64, e = 1e-3;
    fixture_run(run, fixture_cyclic_config, n);
    for (size_t i = 0; i < n; i++) {
        double x = (double)i / (double)model->per_cycle, theta = 2 * M_PI * x;
        double eps = e / 2 * (cos(delta) - cos(theta - delta)) + model->accumulated(x, model->context);
        double stress[3] = {1000 + 100 * (1 - cos(theta)), 1000, 1000}, strain[3] = {eps, -0.3 * eps, -0.3 * eps};
        run->time_s[i] = 10 * x;
        fixture_set(run, OBSERVABLE_STAGE_TIME, i, 0, 10 * x);
        for (size_t k = 0; k < 3; k++) {
            fixture_set(run, OBSERVABLE_STRESS_WALL, i, k, stress[k]);
            fixture_set(run, OBSERVABLE_STRESS_CONTACT, i, 4 * k, stress[k]);
            fixture_set(run, OBSERVABLE_BOX_LENGTH, i, k, 0.1 * exp(-strain[k]));
        }
        fixture_set(run, OBSERVABLE_WORK_WALLS, i, 0, 1e-3 * (1 - cos(theta)));
        fixture_set(run, OBSERVABLE_ENERGY_RESIDUAL, i, 0, 1e-6);
    }
}
