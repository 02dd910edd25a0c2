#include "bench/curve_errors.h"

#include <hdf5.h>
#include <math.h>

#include "analyzer/curves.h"
#include "analyzer/run_file.h"

static const double EARLY_STRAIN = 0.015;

struct loaded {
    struct run run;
    struct curves curves;
};

static enum status load(struct loaded *l, const char *path)
{
    TRY(run_read(&l->run, path));
    enum status status = curves_extract(&l->curves, &l->run);
    if (status != STATUS_OK)
        run_free(&l->run);
    return status;
}

static void unload(struct loaded *l)
{
    curves_free(&l->curves);
    run_free(&l->run);
}

static double relative_l2(const double *a, const double *ref, size_t n)
{
    double difference = 0, norm = 0;
    for (size_t k = 0; k < n; k++) {
        difference += (a[k] - ref[k]) * (a[k] - ref[k]);
        norm += ref[k] * ref[k];
    }
    return sqrt(difference / norm);
}

static double largest(const double *a, size_t n)
{
    double value = -INFINITY;
    for (size_t k = 0; k < n; k++)
        value = fmax(value, a[k]);
    return value;
}

static double range(const double *a, size_t n)
{
    double lo = INFINITY;
    for (size_t k = 0; k < n; k++)
        lo = fmin(lo, a[k]);
    return largest(a, n) - lo;
}

static double largest_difference(const double *a, const double *b, size_t n)
{
    double value = 0;
    for (size_t k = 0; k < n; k++)
        value = fmax(value, fabs(a[k] - b[k]));
    return value;
}

static double position_error(const struct run *a, const struct run *b, size_t n)
{
    double worst = 0;
    for (size_t k = 0; k < n; k++)
        for (size_t c = 0; c < a->width[OBSERVABLE_BOX_LENGTH]; c++) {
            double here = run_record(a, OBSERVABLE_BOX_LENGTH, k)[c],
                   there = run_record(b, OBSERVABLE_BOX_LENGTH, k)[c];
            worst = fmax(worst, fabs(here - there) / there);
        }
    return worst;
}

static double over_work(const struct run *run, enum observable observable)
{
    if (run->n_samples == 0)
        return 0;
    double work = fabs(*run_record(run, OBSERVABLE_WORK_WALLS, run->n_samples - 1));
    return work > 0 ? *run_record(run, observable, run->n_samples - 1) / work : 0;
}

static size_t early_samples(const struct curves *ref, size_t n)
{
    size_t k = 0;
    while (k < n && fabs(ref->column[CURVE_EPS_ZZ][k]) <= EARLY_STRAIN)
        k++;
    return k;
}

int64_t run_attribute_i64(const char *path, const char *name)
{
    int64_t value = 0;
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file < 0)
        return 0;
    if (H5Aexists(file, name) > 0) {
        hid_t attribute = H5Aopen(file, name, H5P_DEFAULT);
        if (H5Aread(attribute, H5T_NATIVE_INT64, &value) < 0)
            value = 0;
        H5Aclose(attribute);
    }
    H5Fclose(file);
    return value;
}

static enum status compare(const struct loaded *reference, const struct loaded *l, const char *path,
                           struct curve_errors *errors)
{
    const struct curves *a = &l->curves, *ref = &reference->curves;
    const size_t n = a->n < ref->n ? a->n : ref->n;
    const enum curve stress = CURVE_SIGMA_ZZ, strain = ref->controls.kind == TEST_CYCLIC ? CURVE_EPS_D : CURVE_EPS_XX;
    if (n < 2 || a->column[CURVE_STAGE_TIME][n - 1] != ref->column[CURVE_STAGE_TIME][n - 1])
        return status_fail(STATUS_INCOMPLETE, "%s: its samples are not those of the reference", path);
    const double *stress_a = a->column[stress], *stress_ref = ref->column[stress];
    const double *strain_a = a->column[strain], *strain_ref = ref->column[strain];
    *errors = (struct curve_errors){
        .stress = relative_l2(stress_a, stress_ref, n),
        .early = relative_l2(stress_a, stress_ref, early_samples(ref, n)),
        .peak = largest(stress_a, n) / largest(stress_ref, n) - 1,
        .position = position_error(&l->run, &reference->run, n),
        .strain = largest_difference(strain_a, strain_ref, n) / range(strain_ref, n),
        .gain = fabs(strain_a[n - 1] - strain_ref[n - 1]) / fabs(strain_ref[n - 1]),
        .residual = over_work(&l->run, OBSERVABLE_INTERFACE_RESIDUAL),
        .controller_residual = over_work(&l->run, OBSERVABLE_CONTROLLER_RESIDUAL),
        .elapsed_s = l->run.elapsed_s,
        .steps = l->run.steps,
        .exchanges = run_attribute_i64(path, "wall_states"),
        .complete = l->run.complete && l->run.reason[0] == 0 && a->n == ref->n,
    };
    return STATUS_OK;
}

enum status curve_errors_measure(const char *reference, const char *path, struct curve_errors *errors)
{
    struct loaded ref = {0}, run = {0};
    TRY(load(&ref, reference));
    enum status status = load(&run, path);
    if (status == STATUS_OK) {
        status = compare(&ref, &run, path, errors);
        unload(&run);
    }
    unload(&ref);
    return status;
}
