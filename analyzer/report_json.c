#include "analyzer/report_json.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analyzer/shakedown.h"

json_t *report_json_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *report_json_quantity(enum quantity_id id, const struct quantity *quantity)
{
    json_t *object = json_object();
    if (!object)
        return NULL;
    bool undefined = !isfinite(quantity->value);
    int failed = json_object_set_new(object, "value", report_json_number(quantity->value));
    failed |= json_object_set_new(object, "unit", json_string(quantity_unit(id)));
    failed |= json_object_set_new(object, "uncertainty", report_json_number(quantity->uncertainty));
    failed |= json_object_set_new(object, "window",
                                  quantity->has_window ? json_pack("[f, f]", quantity->window[0], quantity->window[1])
                                                       : json_null());
    if (quantity->text[0])
        failed |= json_object_set_new(object, undefined ? "reason" : "note", json_string(quantity->text));
    if (!failed)
        return object;
    json_decref(object);
    return NULL;
}

int report_json_set(json_t *root, const char *key, json_t *value)
{
    const char *dot = strchr(key, '.');
    if (!dot)
        return json_object_set_new(root, key, value);
    char group[64];
    snprintf(group, sizeof group, "%.*s", (int)(dot - key), key);
    json_t *inner = json_object_get(root, group);
    if (!inner && json_object_set_new(root, group, inner = json_object()) != 0) {
        json_decref(value);
        return -1;
    }
    return report_json_set(inner, dot + 1, value);
}

static json_t *run_json(const struct analysis *analysis)
{
    const struct run *run = &analysis->run;
    json_t *object =
        json_pack("{s:s, s:I, s:s, s:s, s:s, s:i, s:b, s:o, s:I, s:s}", "name", run->name, "seed",
                  (json_int_t)run->seed, "version", run->version, "kernel_set", run->kernel_set, "controller",
                  run->controller, "dimension", run->dimension, "complete", (int)run->complete, "elapsed_s",
                  report_json_number(run->elapsed_s), "steps", (json_int_t)run->steps, "reason", run->reason);
    return object;
}

static json_t *stage_json(const struct analysis *analysis)
{
    const struct curves *curves = &analysis->curves;
    char axis[2] = {"xyz"[curves->controls.axial], '\0'};
    return json_pack("{s:s, s:i, s:s, s:s, s:I, s:o}", "name", curves->protocol->name, "index", curves->stage, "kind",
                     stage_controls_name(&curves->controls, curves->dimension), "axial", axis, "samples",
                     (json_int_t)curves->n, "lateral_pressure_pa",
                     report_json_number(curves->controls.lateral_pressure_pa));
}

static json_t *notes_json(const struct judgement *judgement)
{
    json_t *list = json_array();
    int failed = 0;
    for (size_t k = 0; k < judgement->n; k++)
        failed |= json_array_append_new(
            list, json_pack("{s:s, s:s, s:s}", "stage", judgement->note[k].stage, "severity",
                            judgement_severity_name(judgement->note[k].severity), "text", judgement->note[k].text));
    if (!failed)
        return list;
    json_decref(list);
    return NULL;
}

static json_t *cycle_json(const struct cycle *cycle, size_t number)
{
    return json_pack("{s:I, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "cycle", (json_int_t)number,
                     "eps_d", report_json_number(cycle->eps_d), "eps_v", report_json_number(cycle->eps_v), "rate_d",
                     report_json_number(cycle->rate_d), "rate_v", report_json_number(cycle->rate_v),
                     "loop_area_j_per_m3", report_json_number(cycle->loop_area_j_per_m3), "resilient_modulus_pa",
                     report_json_number(cycle->resilient_modulus_pa), "damping_ratio",
                     report_json_number(cycle->damping_ratio), "secant_e_pa", report_json_number(cycle->secant_e_pa),
                     "secant_g_pa", report_json_number(cycle->secant_g_pa), "amplitude",
                     report_json_number(cycle->amplitude), "r_u", report_json_number(cycle->r_u));
}

/* The parts of "cycles" that are no quantities. */
static int cycles_set(json_t *root, const struct cycles *cycles)
{
    const char *verdict = shakedown_verdict_name(cycles->verdict);
    const char range[2] = {cycles->range, 0};
    json_t *list = json_array();
    int failed = 0;
    for (size_t k = 0; k < cycles->n; k++)
        failed |= json_array_append_new(list, cycle_json(&cycles->cycle[k], k + 1));
    failed |= report_json_set(root, "cycles.count", json_integer((json_int_t)cycles->n));
    failed |= report_json_set(root, "cycles.classification", json_string(verdict));
    failed |= report_json_set(root, "cycles.werkmeister_range",
                              cycles->range == '?' ? json_string("undetermined") : json_string(range));
    failed |= report_json_set(root, "cycles.werkmeister_criterion", json_string(cycles->range_criterion));
    failed |= report_json_set(root, "cycles.negligible_rate", report_json_number(cycles->negligible));
    failed |= report_json_set(root, "cycles.confidence", report_json_number(cycles->confidence));
    failed |= report_json_set(root, "cycles.criterion", json_string(cycles->criterion));
    failed |= report_json_set(root, "cycles.per_cycle", list);
    return failed;
}

static json_t *analysis_json(const struct analysis *analysis)
{
    json_t *root = json_object();
    bool cyclic = analysis->curves.controls.kind == TEST_CYCLIC;
    int failed = report_json_set(root, "run", run_json(analysis));
    failed |= report_json_set(root, "stage", stage_json(analysis));
    failed |= report_json_set(root, "analyzer_version", json_string(SHAKEDOWN_VERSION));
    failed |= report_json_set(root, "verdict", json_string(judgement_worth_name(analysis->judgement.verdict)));
    failed |= report_json_set(root, "notes", notes_json(&analysis->judgement));
    failed |= report_json_set(root, "complete", json_boolean(analysis->run.complete));
    for (int k = 0; k < QUANTITIES; k++)
        if (quantity_is_reported((enum quantity_id)k, analysis->curves.controls.kind, &analysis->quantity[k]))
            failed |= report_json_set(root, quantity_key((enum quantity_id)k),
                                      report_json_quantity((enum quantity_id)k, &analysis->quantity[k]));
    if (cyclic)
        failed |= cycles_set(root, &analysis->cycles);
    else
        failed |= report_json_set(root, "cycles", json_null());
    if (!failed)
        return root;
    json_decref(root);
    return NULL;
}

enum status report_json_dump(json_t *document, const char *path)
{
    char temporary[2048];
    int length = snprintf(temporary, sizeof temporary, "%s.tmp", path);
    if (!document)
        return status_fail(STATUS_NO_MEMORY, "%s: out of memory", path);
    int failed = length >= (int)sizeof temporary || json_dump_file(document, temporary, JSON_INDENT(2)) != 0;
    json_decref(document);
    if (failed || rename(temporary, path) != 0)
        return status_fail(STATUS_IO, "%s: cannot be written: %s", path, strerror(errno));
    return STATUS_OK;
}

enum status report_json_write(const struct analysis *analysis, const char *path)
{
    return report_json_dump(analysis_json(analysis), path);
}
