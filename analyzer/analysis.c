#include "analyzer/analysis.h"

#include <math.h>
#include <string.h>

#include "analyzer/compression.h"
#include "analyzer/held.h"
#include "analyzer/shear.h"
#include "analyzer/undrained.h"

/* A residual at the last sample over the work done in the stage: the net work, or the sum of its absolute changes from
 * sample to sample where the net is below a tenth of that (cycles give back what they took). */
static void over_work(const struct curves *curves, enum curve of, struct quantity *quantity)
{
    const double *work = curves->column[CURVE_WORK];
    double total = 0;
    for (size_t k = 1; k < curves->n; k++)
        total += fabs(work[k] - work[k - 1]);
    if (!(total > 0)) {
        quantity_undefined(quantity, "no work was done in the stage");
        return;
    }
    double net = fabs(work[curves->n - 1]), residual = fabs(curves->column[of][curves->n - 1]);
    if (isnan(residual)) {
        quantity_undefined(quantity, "not recorded: the run is of an earlier version");
        return;
    }
    bool use_net = net >= total / 10;
    quantity_set(quantity, (struct estimate){residual / (use_net ? net : total), NAN});
    if (!use_net)
        quantity_note(quantity, "over the sum of absolute work: the net work is small");
}

/* What needs no particular protocol. */
static void state_quantities(const struct curves *curves, struct quantity *q)
{
    static const struct {
        enum quantity_id id;
        enum curve from;
    } initial[] = {{QUANTITY_INITIAL_PHI, CURVE_SOLID_FRACTION},
                   {QUANTITY_INITIAL_COORDINATION, CURVE_COORDINATION},
                   {QUANTITY_INITIAL_COORDINATION_NO_RATTLERS, CURVE_COORDINATION_NO_RATTLERS}};
    for (size_t k = 0; k < sizeof initial / sizeof initial[0]; k++) {
        if (curves->n)
            quantity_set(&q[initial[k].id], (struct estimate){curves->column[initial[k].from][0], NAN});
        else
            quantity_undefined(&q[initial[k].id], "the stage has no samples");
    }
    over_work(curves, CURVE_ENERGY_RESIDUAL, &q[QUANTITY_ENERGY_RESIDUAL]);
    over_work(curves, CURVE_INTERFACE_RESIDUAL, &q[QUANTITY_INTERFACE_RESIDUAL]);
    over_work(curves, CURVE_CONTROLLER_RESIDUAL, &q[QUANTITY_CONTROLLER_RESIDUAL]);
    quantity_set(&q[QUANTITY_STRESS_DIFFERENCE], (struct estimate){curves->stress_difference, NAN});
}

static void inertial_number(const struct curves *curves, struct quantity *q)
{
    const double *inertial = curves->column[CURVE_INERTIAL_NUMBER];
    double largest = 0, mean = 0;
    for (size_t k = 0; k < curves->n; k++) {
        largest = fmax(largest, fabs(inertial[k]));
        mean += fabs(inertial[k]) / (double)curves->n;
    }
    quantity_set(&q[QUANTITY_INERTIAL_MEAN], (struct estimate){curves->n ? mean : NAN, NAN});
    quantity_set(&q[QUANTITY_INERTIAL_MAX], (struct estimate){curves->n ? largest : NAN, NAN});
}

/* What the controls of the stage make of it. */
static enum status evaluate_kind(struct analysis *analysis)
{
    const struct curves *curves = &analysis->curves;
    switch (curves->controls.kind) {
    case TEST_CONSTANT_VOLUME:
        undrained_evaluate(curves, analysis->quantity);
        return shear_evaluate(curves, analysis->run.scene, analysis->quantity, &analysis->stiffness);
    case TEST_SHEAR:
        return shear_evaluate(curves, analysis->run.scene, analysis->quantity, &analysis->stiffness);
    case TEST_ISOTROPIC:
    case TEST_OEDOMETER:
        return compression_evaluate(curves, analysis->quantity);
    case TEST_CREEP:
    case TEST_RELAXATION:
        held_evaluate(curves, analysis->quantity);
        return STATUS_OK;
    case TEST_CYCLIC:
        TRY(cycles_evaluate(&analysis->cycles, curves));
        cycles_quantities(&analysis->cycles, curves, analysis->quantity);
        return STATUS_OK;
    default:
        return STATUS_OK;
    }
}

static enum status evaluate(struct analysis *analysis)
{
    TRY(curves_extract(&analysis->curves, &analysis->run));
    for (int k = 0; k < QUANTITIES; k++)
        quantity_undefined(&analysis->quantity[k], "not of this kind of test: %s",
                           controls_name(&analysis->curves.controls, analysis->run.dimension));
    TRY(evaluate_kind(analysis));
    state_quantities(&analysis->curves, analysis->quantity);
    inertial_number(&analysis->curves, analysis->quantity);
    return STATUS_OK;
}

enum status analysis_make(struct analysis *analysis, const char *directory)
{
    char path[sizeof analysis->directory + 16];
    memset(analysis, 0, sizeof *analysis);
    if (strlen(directory) >= sizeof analysis->directory)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", directory);
    snprintf(analysis->directory, sizeof analysis->directory, "%s", directory);
    snprintf(path, sizeof path, "%s/run.h5", directory);
    TRY(run_read(&analysis->run, path));
    enum status status = evaluate(analysis);
    if (status != STATUS_OK)
        analysis_free(analysis);
    return status;
}

void analysis_free(struct analysis *analysis)
{
    cycles_free(&analysis->cycles);
    curves_free(&analysis->curves);
    run_free(&analysis->run);
}
