#include "analyzer/curves.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const names[CURVES] = {
#define CURVE_NAME(id, name) name,
    CURVE_LIST(CURVE_NAME)
#undef CURVE_NAME
};

const char *curve_name(enum curve curve)
{
    return names[curve];
}

enum curve curve_axial_strain(int measure)
{
    return measure == STRAIN_LOGARITHMIC ? CURVE_EPS_ZZ_LOG : CURVE_EPS_ZZ;
}

enum curve curve_volumetric_strain(int measure)
{
    return measure == STRAIN_LOGARITHMIC ? CURVE_EPS_V_LOG : CURVE_EPS_V;
}

static int compare_descending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

static void eigenvalues_3d(const double *t, double *eigenvalues)
{
    double off = t[1] * t[1] + t[2] * t[2] + t[5] * t[5], mean = (t[0] + t[4] + t[8]) / 3;
    double a = t[0] - mean, b = t[4] - mean, c = t[8] - mean;
    double p = sqrt((a * a + b * b + c * c + 2 * off) / 6);
    double det = a * (b * c - t[5] * t[5]) - t[1] * (t[1] * c - t[5] * t[2]) + t[2] * (t[1] * t[5] - b * t[2]);
    double ratio = p > 0 ? det / (2 * p * p * p) : 0;
    double angle = acos(fmax(-1, fmin(1, ratio))) / 3; /* rounding may leave [-1, 1] */
    for (int k = 0; k < 3; k++)
        eigenvalues[k] = mean + 2 * p * cos(angle + 2 * M_PI * k / 3);
    qsort(eigenvalues, 3, sizeof *eigenvalues, compare_descending);
}

void tensor_eigenvalues(const double *tensor, int dimension, double *eigenvalues)
{
    if (dimension == 3) {
        eigenvalues_3d(tensor, eigenvalues);
        return;
    }
    double mean = (tensor[0] + tensor[3]) / 2, shear = (tensor[1] + tensor[2]) / 2;
    double radius = hypot((tensor[0] - tensor[3]) / 2, shear);
    eigenvalues[0] = mean + radius;
    eigenvalues[1] = mean - radius;
}

static void split(const struct curves *curves, const double *vector, double *axial, double *lateral)
{
    stage_controls_split(&curves->controls, curves->dimension, vector, axial, lateral);
}

static void strains_fill(struct curves *curves, const struct run *run, size_t first, size_t i)
{
    const double *length = run_record(run, OBSERVABLE_BOX_LENGTH, first + i);
    const double *start = run_record(run, OBSERVABLE_BOX_LENGTH, first);
    double strain[SCENE_AXES] = {0}, logarithmic[SCENE_AXES] = {0}, volumetric = 0, axial, lateral;
    for (int k = 0; k < curves->dimension; k++) {
        strain[k] = 1 - length[k] / start[k];
        logarithmic[k] = -log1p((length[k] - start[k]) / start[k]); /* keeps the digits of small strains */
        volumetric += logarithmic[k];
    }
    split(curves, strain, &axial, &lateral);
    curves->column[CURVE_EPS_ZZ][i] = axial;
    curves->column[CURVE_EPS_XX][i] = lateral;
    curves->column[CURVE_EPS_V][i] = -expm1(-volumetric);
    curves->column[CURVE_EPS_D][i] = axial - lateral;
    split(curves, logarithmic, &axial, &lateral);
    curves->column[CURVE_EPS_ZZ_LOG][i] = axial;
    curves->column[CURVE_EPS_XX_LOG][i] = lateral;
    curves->column[CURVE_EPS_V_LOG][i] = volumetric;
    curves->column[CURVE_EPS_D_LOG][i] = axial - lateral;
}

static void stresses_fill(struct curves *curves, const struct run *run, size_t sample, size_t i)
{
    int d = curves->dimension;
    const double *contact = run_record(run, OBSERVABLE_STRESS_CONTACT, sample);
    double diagonal[SCENE_AXES] = {0}, axial, lateral;
    for (int k = 0; k < d; k++)
        diagonal[k] = contact[k * d + k];
    split(curves, diagonal, &axial, &lateral);
    curves->column[CURVE_CONTACT_ZZ][i] = axial;
    curves->column[CURVE_CONTACT_XX][i] = lateral;
    split(curves, run_record(run, OBSERVABLE_STRESS_WALL, sample), &axial, &lateral);
    double p = (axial + (d - 1) * lateral) / d;
    /* the ratio of a wall that nothing pushes on means nothing */
    bool pressed = lateral > 0;
    curves->column[CURVE_SIGMA_ZZ][i] = axial;
    curves->column[CURVE_SIGMA_XX][i] = lateral;
    curves->column[CURVE_SIGMA_D][i] = (axial - lateral) * (d - 1) / d;
    curves->column[CURVE_STRESS_RATIO][i] = pressed ? axial / lateral : NAN;
    curves->column[CURVE_P][i] = p;
    curves->column[CURVE_Q][i] = axial - lateral;
    curves->column[CURVE_U][i] = curves->column[CURVE_P][0] - p;
    curves->column[CURVE_SIGMA_CORR][i] = pressed ? curves->controls.lateral_pressure_pa * axial / lateral : NAN;
    curves->column[CURVE_SIN_PHI][i] = axial + lateral > 0 ? fabs(axial - lateral) / (axial + lateral) : NAN;
    curves->column[CURVE_Q_OVER_P][i] = p > 0 ? (axial - lateral) / p : NAN;
}

static void fabric_fill(struct curves *curves, const struct run *run, size_t sample, size_t i)
{
    int d = curves->dimension, a = stage_controls_slot(d, (int)curves->controls.axial);
    const double *fabric = run_record(run, OBSERVABLE_FABRIC, sample);
    double eigenvalues[SCENE_AXES];
    tensor_eigenvalues(fabric, d, eigenvalues);
    curves->column[CURVE_FABRIC_MAJOR][i] = eigenvalues[0];
    curves->column[CURVE_FABRIC_MINOR][i] = eigenvalues[d - 1];
    curves->column[CURVE_FABRIC_ANISOTROPY][i] = eigenvalues[0] - eigenvalues[d - 1];
    curves->column[CURVE_FABRIC_ZZ][i] = fabric[a * d + a];
}

static void scalars_fill(struct curves *curves, const struct run *run, size_t sample, size_t i)
{
    static const struct {
        enum curve to;
        enum observable from;
    } plain[] = {
        {CURVE_STAGE_TIME, OBSERVABLE_STAGE_TIME},
        {CURVE_SOLID_FRACTION, OBSERVABLE_SOLID_FRACTION},
        {CURVE_COORDINATION, OBSERVABLE_COORDINATION},
        {CURVE_COORDINATION_NO_RATTLERS, OBSERVABLE_COORDINATION_NO_RATTLERS},
        {CURVE_RATTLER_FRACTION, OBSERVABLE_RATTLER_FRACTION},
        {CURVE_SLIDING_FRACTION, OBSERVABLE_SLIDING_FRACTION},
        {CURVE_MAX_OVERLAP_RATIO, OBSERVABLE_MAX_OVERLAP_RATIO},
        {CURVE_INERTIAL_NUMBER, OBSERVABLE_INERTIAL_NUMBER},
        {CURVE_KINETIC_ENERGY, OBSERVABLE_KINETIC_ENERGY},
        {CURVE_ENERGY_RESIDUAL, OBSERVABLE_ENERGY_RESIDUAL},
        {CURVE_INTERFACE_RESIDUAL, OBSERVABLE_INTERFACE_RESIDUAL},
        {CURVE_CONTROLLER_RESIDUAL, OBSERVABLE_CONTROLLER_RESIDUAL},
    };
    for (size_t k = 0; k < sizeof plain / sizeof plain[0]; k++)
        curves->column[plain[k].to][i] = *run_record(run, plain[k].from, sample);
    double period = curves->controls.period_s, solid = *run_record(run, OBSERVABLE_SOLID_FRACTION, sample);
    double t = curves->column[CURVE_STAGE_TIME][i];
    curves->column[CURVE_VOID_RATIO][i] = solid > 0 ? (1 - solid) / solid : NAN;
    curves->column[CURVE_STEP][i] = run->step[sample];
    curves->column[CURVE_TIME][i] = run->time_s[sample];
    /* times are sums of steps: allow for rounding at the end of a cycle, which belongs to the cycle that ends */
    curves->column[CURVE_CYCLE][i] = period > 0 && t > 0 ? ceil(t / period - 1e-6) : 0;
    curves->column[CURVE_WORK][i] =
        *run_record(run, OBSERVABLE_WORK_WALLS, sample) + *run_record(run, OBSERVABLE_WORK_GRAVITY, sample);
}

static double stress_difference(const struct run *run, size_t begin, size_t end)
{
    size_t d = (size_t)run->dimension;
    double difference = 0, size = 0;
    for (size_t s = begin; s < end; s++) {
        for (size_t k = 0; k < d; k++) {
            double wall = run_record(run, OBSERVABLE_STRESS_WALL, s)[k];
            double contact = run_record(run, OBSERVABLE_STRESS_CONTACT, s)[k * d + k];
            difference += (wall - contact) * (wall - contact);
            size += wall * wall;
        }
    }
    return size > 0 ? sqrt(difference / size) : NAN;
}

enum status curves_extract(struct curves *curves, const struct run *run)
{
    return curves_extract_stage(curves, run, scene_stage_find(run->scene, run->scene->analysis.stage));
}

enum status curves_extract_stage(struct curves *curves, const struct run *run, int stage)
{
    size_t begin, end;
    memset(curves, 0, sizeof *curves);
    curves->dimension = run->dimension;
    curves->stage = stage;
    curves->protocol = &run->scene->stage[curves->stage];
    run_stage_range(run, curves->stage, &begin, &end);
    stage_controls_find(&curves->controls, run, stage, begin, end);
    for (int k = 0; k < CURVES; k++) {
        curves->column[k] = malloc((end - begin + 1) * sizeof **curves->column);
        if (!curves->column[k]) {
            curves_free(curves);
            return status_fail(STATUS_NO_MEMORY, "out of memory for %zu samples", end - begin);
        }
    }
    curves->n = end - begin;
    for (size_t i = 0; i < curves->n; i++) {
        scalars_fill(curves, run, begin + i, i);
        strains_fill(curves, run, begin, i);
        stresses_fill(curves, run, begin + i, i);
        fabric_fill(curves, run, begin + i, i);
    }
    curves->stress_difference = stress_difference(run, begin, end);
    return STATUS_OK;
}

void curves_free(struct curves *curves)
{
    for (int k = 0; k < CURVES; k++)
        free(curves->column[k]);
    memset(curves, 0, sizeof *curves);
}

static void names_write(FILE *out)
{
    for (int k = 0; k < CURVES; k++)
        fprintf(out, "%s,", names[k]);
    fprintf(out, "stage\n");
}

static void rows_write(FILE *out, const struct curves *curves)
{
    for (size_t i = 0; i < curves->n; i++) {
        for (int k = 0; k < CURVES; k++)
            fprintf(out, "%.12g,", curves->column[k][i]);
        fprintf(out, "\"%s\"\n", curves->protocol->name);
    }
}

static enum status csv_close(FILE *out, const char *path)
{
    int failed = ferror(out); /* sticky: covers every write before */
    if (fclose(out) != 0 || failed)
        return status_fail(STATUS_IO, "%s: cannot be written: %s", path, strerror(errno));
    return STATUS_OK;
}

enum status curves_write_csv(const struct curves *curves, const char *path)
{
    FILE *out = fopen(path, "w");
    if (!out)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    names_write(out);
    rows_write(out, curves);
    return csv_close(out, path);
}

enum status curves_write_all_csv(const struct run *run, const char *path)
{
    FILE *out = fopen(path, "w");
    if (!out)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    enum status status = STATUS_OK;
    names_write(out);
    for (int k = 0; status == STATUS_OK && k < run->scene->n_stages; k++) {
        struct curves curves;
        status = curves_extract_stage(&curves, run, k);
        if (status != STATUS_OK)
            break;
        rows_write(out, &curves);
        curves_free(&curves);
    }
    enum status closed = csv_close(out, path);
    return status == STATUS_OK ? closed : status;
}
