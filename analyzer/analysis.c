#include "analyzer/analysis.h"

#include <math.h>
#include <string.h>

#include "analyzer/biaxial.h"

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

static enum status evaluate(struct analysis *analysis)
{
    TRY(curves_extract(&analysis->curves, &analysis->run));
    TRY(biaxial_evaluate(&analysis->curves, analysis->run.scene, analysis->quantity));
    TRY(cycles_evaluate(&analysis->cycles, &analysis->curves));
    cycles_quantities(&analysis->cycles, &analysis->curves, analysis->quantity);
    state_quantities(&analysis->curves, analysis->quantity);
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

/* "123.4 +- 5.6" with the digits the uncertainty supports; "-" if undefined. */
static void value_text(const struct quantity *quantity, char *text, size_t size)
{
    double u = quantity->uncertainty;
    if (isnan(quantity->value)) {
        snprintf(text, size, "%12s %12s", "-", "");
    } else if (!(u > 0) || isinf(u)) {
        snprintf(text, size, "%12.5g %12s", quantity->value, "");
    } else {
        /* two digits of the uncertainty; small numbers in powers of ten */
        int decimals = 1 - (int)floor(log10(u)), digits = decimals + (int)floor(log10(fmax(fabs(quantity->value), u)));
        bool power = fabs(quantity->value) < 1e-3;
        char error[32];
        if (power || decimals > 8)
            snprintf(error, sizeof error, "+- %.1e", u);
        else
            snprintf(error, sizeof error, "+- %.*f", decimals < 0 ? 0 : decimals, u);
        snprintf(text, size, power ? "%12.*e %12s" : "%12.*f %12s", (int)fmin(8, fmax(0, power ? digits : decimals)),
                 quantity->value, error);
    }
}

static void quantity_print(FILE *out, enum quantity_id id, const struct quantity *quantity)
{
    char value[64], window[48] = "";
    value_text(quantity, value, sizeof value);
    if (quantity->has_window)
        snprintf(window, sizeof window, "[%.5g, %.5g]", quantity->window[0], quantity->window[1]);
    const char *unit = quantity_unit(id);
    fprintf(out, "  %-34s %s %-6s %-22s %s\n", quantity_key(id), value, strcmp(unit, "1") == 0 ? "" : unit, window,
            quantity->text);
}

/* Of a cyclic test, what only a strain-controlled one has is left out of the table; and the other way round. */
static bool is_shown(const struct analysis *analysis, enum quantity_id id)
{
    if (analysis->curves.kind != TEST_CYCLIC)
        return !quantity_is_cyclic(id);
    return quantity_is_cyclic(id) || isfinite(analysis->quantity[id].value);
}

void analysis_print(FILE *out, const struct analysis *analysis)
{
    const struct run *run = &analysis->run;
    const struct curves *curves = &analysis->curves;
    const char *verdict = cycles_verdict_name(analysis->cycles.verdict), axis = "xyz"[curves->axial];
    fprintf(out, "%s: run \"%s\", seed %lld, version %s, kernels %s, %s\n", analysis->directory, run->name,
            (long long)run->seed, run->version, run->kernel_set, run->complete ? "complete" : "INCOMPLETE");
    fprintf(out, "stage \"%s\" (%d of %d), axial direction %c, %zu samples\n", curves->protocol->name,
            curves->stage + 1, (int)run->scene->n_stages, axis, curves->n);
    fprintf(out, "  %-34s %12s %12s %-6s %-22s\n", "quantity", "value", "uncertainty", "unit", "window");
    for (int k = 0; k < QUANTITIES; k++)
        if (is_shown(analysis, (enum quantity_id)k))
            quantity_print(out, (enum quantity_id)k, &analysis->quantity[k]);
    if (verdict)
        fprintf(out, "  %-34s %12s (confidence %.3f; %zu cycles; %s)\n", "cycles.classification", verdict,
                analysis->cycles.confidence, analysis->cycles.n, analysis->cycles.criterion);
}
