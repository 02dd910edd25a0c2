#include "analyzer/report_table.h"

#include <math.h>
#include <string.h>

#include "analyzer/shakedown.h"

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

static void judgement_print(FILE *out, const struct judgement *judgement)
{
    for (size_t k = 0; k < judgement->n; k++)
        fprintf(out, "  %s%s%s%s: %s\n", judgement_severity_name(judgement->note[k].severity),
                judgement->note[k].stage[0] ? " (stage \"" : "", judgement->note[k].stage,
                judgement->note[k].stage[0] ? "\")" : "", judgement->note[k].text);
    fprintf(out, "  verdict: %s\n", judgement_worth_name(judgement->verdict));
}

static void legend_print(FILE *out, const struct analysis *analysis)
{
    const int d = analysis->run.dimension;
    fprintf(out,
            "  symbols: zz axial (%c), xx mean of the lateral axes; compression positive; %s strains, slopes of "
            "logarithmic ones\n",
            "xyz"[analysis->curves.controls.axial],
            analysis -> run.scene->analysis.strain == STRAIN_LOGARITHMIC ? "logarithmic" : "engineering");
    fprintf(out,
            "           eps_v = 1 - V/V0, eps_d = eps_zz - eps_xx, q = sigma_zz - sigma_xx, p = (sigma_zz + "
            "%ssigma_xx)/%d\n",
            d == 3 ? "2 " : "", d);
    fprintf(out, "           value +- u: +- 2u is meant to hold the truth in 95 %% of runs of this sample\n");
}

/* Both classifications, by name. */
static void classes_print(FILE *out, const struct cycles *cycles)
{
    const char range[] = {cycles->range, '\0'};
    char confidence[48] = "";
    if (isfinite(cycles->confidence))
        snprintf(confidence, sizeof confidence, "confidence %.3f; ", cycles->confidence);
    fprintf(out, "  %-34s %12s (%s%zu cycles; %s)\n", "cycles.classification", shakedown_verdict_name(cycles->verdict),
            confidence, cycles->n, cycles->criterion);
    fprintf(out, "  %-34s %12s (%s)\n", "cycles.werkmeister_range", cycles->range == '?' ? "undetermined" : range,
            cycles->range_criterion);
}

void report_table_print(FILE *out, const struct analysis *analysis)
{
    const struct run *run = &analysis->run;
    const struct curves *curves = &analysis->curves;

    fprintf(out, "%s: run \"%s\", seed %lld, version %s, kernels %s, %s\n", analysis->directory, run->name,
            (long long)run->seed, run->version, run->kernel_set, analysis->judgement.headline);
    fprintf(out, "stage \"%s\" (%d of %d): %s, %zu samples\n", curves->protocol->name, curves->stage + 1,
            (int)run->scene->n_stages, stage_controls_name(&curves->controls, run->dimension), curves->n);
    fprintf(out, "  %-34s %12s %12s %-6s %-22s\n", "quantity", "value", "uncertainty", "unit", "window");
    for (int k = 0; k < QUANTITIES; k++)
        if (quantity_is_reported((enum quantity_id)k, curves->controls.kind, &analysis->quantity[k]))
            quantity_print(out, (enum quantity_id)k, &analysis->quantity[k]);
    if (analysis->cycles.n > 0)
        classes_print(out, &analysis->cycles);
    legend_print(out, analysis);
    judgement_print(out, &analysis->judgement);
}
