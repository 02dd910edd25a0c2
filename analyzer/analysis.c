#include "analyzer/analysis.h"

#include <math.h>
#include <string.h>

#include "analyzer/compression.h"
#include "analyzer/control_quality.h"
#include "analyzer/creep_relaxation.h"
#include "analyzer/shakedown.h"
#include "analyzer/shear_strength.h"
#include "analyzer/true_triaxial.h"
#include "analyzer/undrained.h"

static void over_work(const struct analysis *analysis, enum observable of, struct quantity *quantity)
{
    const struct run *run = &analysis->run;
    size_t begin, end;
    bool net = true;
    run_stage_range(run, analysis->curves.stage, &begin, &end);
    if (begin < end && isnan(*run_record(run, of, end - 1))) {
        quantity_undefined(quantity, "not recorded: the run is of an earlier version");
        return;
    }
    const double residual = begin < end ? judgement_residual(run, of, begin, end, &net) : NAN;
    if (isnan(residual)) {
        quantity_undefined(quantity, "no work was done in the stage");
        return;
    }
    quantity_set(quantity, (struct estimate){residual, NAN});
    if (!net)
        quantity_note(quantity, "over the sum of absolute work: the net work is small");
}

/* What needs no particular protocol. */
static void state_quantities(const struct analysis *analysis, struct quantity *q)
{
    const struct curves *curves = &analysis->curves;
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
    over_work(analysis, OBSERVABLE_ENERGY_RESIDUAL, &q[QUANTITY_ENERGY_RESIDUAL]);
    over_work(analysis, OBSERVABLE_INTERFACE_RESIDUAL, &q[QUANTITY_INTERFACE_RESIDUAL]);
    over_work(analysis, OBSERVABLE_CONTROLLER_RESIDUAL, &q[QUANTITY_CONTROLLER_RESIDUAL]);
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
        TRY(true_triaxial_evaluate(&analysis->run, curves, analysis->quantity));
        return shear_strength_evaluate(curves, analysis->run.scene, analysis->quantity, &analysis->stiffness);
    case TEST_SHEAR:
        TRY(true_triaxial_evaluate(&analysis->run, curves, analysis->quantity));
        return shear_strength_evaluate(curves, analysis->run.scene, analysis->quantity, &analysis->stiffness);
    case TEST_ISOTROPIC:
    case TEST_OEDOMETER:
        return compression_evaluate(curves, analysis->quantity);
    case TEST_CREEP:
    case TEST_RELAXATION:
        creep_relaxation_evaluate(curves, analysis->quantity);
        return STATUS_OK;
    case TEST_CYCLIC:
        TRY(cycles_evaluate(&analysis->cycles, curves));
        shakedown_classify(&analysis->cycles, curves, analysis->run.scene->analysis.negligible_rate);
        cycles_quantities(&analysis->cycles, curves, analysis->quantity);
        return STATUS_OK;
    default:
        return STATUS_OK;
    }
}

static void stress_error(struct analysis *analysis)
{
    size_t begin, end;
    double mean, largest;
    run_stage_range(&analysis->run, analysis->curves.stage, &begin, &end);
    judgement_stress_error(&analysis->run, analysis->curves.stage, begin, end, &mean, &largest);
    quantity_set(&analysis->quantity[QUANTITY_STRESS_ERROR_MEAN], (struct estimate){mean, NAN});
    quantity_set(&analysis->quantity[QUANTITY_STRESS_ERROR_MAX], (struct estimate){largest, NAN});
    if (isnan(mean))
        for (int id = QUANTITY_STRESS_ERROR_MEAN; id <= QUANTITY_STRESS_ERROR_MAX; id++)
            quantity_undefined(&analysis->quantity[id], analysis->run.controller[0]
                                                            ? "a controller of the user's own set the targets"
                                                            : "no axis has a stress as its target");
}

/* Whether a quantity needs no more than what was recorded: an initial slope or a peak that lies behind, of a stage that
 * did not end. */
static bool is_known(const struct curves *curves, enum quantity_id id, const struct quantity *quantity)
{
    if (quantity_belongs(id, TEST_NONE) || isnan(quantity->value))
        return true;
    if (id == QUANTITY_RESIDUAL_SIGMA_CORR || id == QUANTITY_RESIDUAL_STRESS_RATIO ||
        (id >= QUANTITY_CRITICAL_SIN_PHI && id <= QUANTITY_CRITICAL_Q_OVER_P))
        return false;
    const bool sheared = quantity_belongs(id, TEST_SHEAR), behind = quantity->has_window && curves->n > 0;
    return sheared && behind && quantity->window[1] < 0.99 * fabs(curves->column[CURVE_EPS_ZZ][curves->n - 1]);
}

/* A stage that did not end is not evaluated as if it had. */
static void unfinished(struct analysis *analysis)
{
    for (int k = 0; k < QUANTITIES; k++)
        if (!is_known(&analysis->curves, (enum quantity_id)k, &analysis->quantity[k]))
            quantity_undefined(&analysis->quantity[k], "the stage did not end: %.100s", analysis->judgement.headline);
    analysis->cycles.verdict = VERDICT_UNDETERMINED;
    analysis->cycles.confidence = NAN;
    analysis->cycles.range = '?';
    snprintf(analysis->cycles.criterion, sizeof analysis->cycles.criterion, "the stage did not end");
}

/* Number of the stage of that name; an error names those that there are. */
static enum status stage_find(const struct scene *scene, const char *name, int *stage)
{
    char names[600] = "";
    size_t used = 0;
    *stage = scene_stage_find(scene, name ? name : scene->analysis.stage);
    if (*stage >= 0)
        return STATUS_OK;
    for (int k = 0; k < scene->n_stages && used < sizeof names; k++)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s\"%s\"", k ? ", " : "", scene->stage[k].name);
    return status_fail(STATUS_USAGE, "there is no stage \"%s\"; there are %s", name, names);
}

static enum status evaluate(struct analysis *analysis, const char *stage)
{
    int number;
    TRY(stage_find(analysis->run.scene, stage, &number));
    TRY(curves_extract_stage(&analysis->curves, &analysis->run, number));
    for (int k = 0; k < QUANTITIES; k++)
        quantity_undefined(&analysis->quantity[k], "not of this kind of test: %s",
                           stage_controls_name(&analysis->curves.controls, analysis->run.dimension));
    judgement_make(&analysis->judgement, &analysis->run, analysis->curves.stage);
    TRY(evaluate_kind(analysis));
    if (!analysis->judgement.ended)
        unfinished(analysis);
    state_quantities(analysis, analysis->quantity);
    stress_error(analysis);
    control_quality_quantities(&analysis->run, analysis->curves.stage, analysis->quantity);
    inertial_number(&analysis->curves, analysis->quantity);
    return STATUS_OK;
}

enum status analysis_make(struct analysis *analysis, const char *directory, const struct analysis_choice *choice)
{
    static const struct analysis_choice as_it_is = {0};
    char path[sizeof analysis->directory + 16];
    memset(analysis, 0, sizeof *analysis);
    if (strlen(directory) >= sizeof analysis->directory)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", directory);
    snprintf(analysis->directory, sizeof analysis->directory, "%s", directory);
    snprintf(path, sizeof path, "%s/run.h5", directory);
    choice = choice ? choice : &as_it_is;
    TRY(run_read_set(&analysis->run, path, choice->setting, choice->n_settings));
    enum status status = evaluate(analysis, choice->stage);
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
