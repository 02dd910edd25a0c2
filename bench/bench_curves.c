/* bench_curves REFERENCE RUN...: how far the curves of runs of one stage lie from those of a reference run (run.h5
 * each, same packing, same samples). One line of JSON per run:
 *   stress    |sigma - sigma_ref|_2 / |sigma_ref|_2 of the axial stress over all samples
 *   early     the same up to 1.5 % of axial strain
 *   peak      relative difference of the largest axial stress
 *   position  largest difference of a box length over that length
 *   strain    largest difference of a strain (lateral under strain control, eps_D in cycles) over its largest range
 *   residual, controller_residual   interface residuals over the work of the walls at the end, 0 without work
 *   elapsed_s, steps, complete      of the run
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

/* Over the samples both have: a run that stopped early has fewer. */
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

static enum status compare(const struct loaded *reference, const char *path)
{
    struct loaded l = {0};
    TRY(load(&l, path));
    const struct curves *a = &l.curves, *ref = &reference->curves;
    const size_t n = a->n < ref->n ? a->n : ref->n;
    const enum curve stress = CURVE_SIGMA_ZZ, strain = ref->kind == TEST_CYCLIC ? CURVE_EPS_D : CURVE_EPS_XX;
    enum status status = STATUS_OK;
    if (n < 2 || a->column[CURVE_STAGE_TIME][n - 1] != ref->column[CURVE_STAGE_TIME][n - 1])
        status = status_fail(STATUS_INCOMPLETE, "%s: its samples are not those of the reference", path);
    if (status == STATUS_OK)
        printf("{\"run\": \"%s\", \"complete\": %s, \"elapsed_s\": %.6g, \"steps\": %" PRId64 ", \"stress\": %.4g, "
               "\"early\": %.4g, \"peak\": %.4g, \"position\": %.4g, \"strain\": %.4g, \"residual\": %.4g, "
               "\"controller_residual\": %.4g}\n",
               path, l.run.complete && a->n == ref->n ? "true" : "false", l.run.elapsed_s, l.run.steps,
               relative_l2(a->column[stress], ref->column[stress], n),
               relative_l2(a->column[stress], ref->column[stress], early_samples(ref, n)),
               largest(a->column[stress], n) / largest(ref->column[stress], n) - 1,
               position_error(&l.run, &reference->run, n),
               largest_difference(a->column[strain], ref->column[strain], n) / range(ref->column[strain], n),
               over_work(&l.run, OBSERVABLE_INTERFACE_RESIDUAL), over_work(&l.run, OBSERVABLE_CONTROLLER_RESIDUAL));
    unload(&l);
    return status;
}

int main(int argc, char **argv)
{
    struct loaded reference = {0};
    if (argc < 3) {
        fprintf(stderr, "usage: bench_curves REFERENCE RUN...\n");
        return STATUS_USAGE;
    }
    enum status status = load(&reference, argv[1]);
    for (int k = 2; k < argc && status == STATUS_OK; k++)
        status = compare(&reference, argv[k]);
    if (status != STATUS_OK)
        fprintf(stderr, "bench_curves: error: %s\n", status_message());
    unload(&reference);
    return (int)status;
}
