#include "analyzer/ensemble.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analyzer/report_json.h"
#include "analyzer/shakedown.h"

enum status ensemble_add(struct ensemble *ensemble, const struct analysis *analysis)
{
    struct ensemble_member *grown = realloc(ensemble->member, (ensemble->n + 1) * sizeof *grown);
    if (!grown)
        return status_fail(STATUS_NO_MEMORY, "out of memory for %zu runs", ensemble->n + 1);
    ensemble->member = grown;
    struct ensemble_member *member = &grown[ensemble->n++];
    const char *verdict = analysis->cycles.n > 0 ? shakedown_verdict_name(analysis->cycles.verdict) : NULL;
    memset(member, 0, sizeof *member);
    snprintf(member->directory, sizeof member->directory, "%s", analysis->directory);
    snprintf(member->name, sizeof member->name, "%s", analysis->run.name);
    snprintf(member->verdict, sizeof member->verdict, "%s", verdict ? verdict : "");
    member->seed = analysis->run.seed;
    member->complete = analysis->run.complete;
    memcpy(member->quantity, analysis->quantity, sizeof member->quantity);
    return STATUS_OK;
}

void ensemble_free(struct ensemble *ensemble)
{
    free(ensemble->member);
    memset(ensemble, 0, sizeof *ensemble);
}

enum status ensemble_item(const struct ensemble *ensemble, enum quantity_id id, struct ensemble_item *item)
{
    double *values = calloc(ensemble->n + 1, sizeof *values), squares = 0, with_error = 0;
    memset(item, 0, sizeof *item);
    if (!values)
        return status_fail(STATUS_NO_MEMORY, "out of memory for %zu runs", ensemble->n);
    for (size_t k = 0; k < ensemble->n; k++) {
        const struct quantity *quantity = &ensemble->member[k].quantity[id];
        if (!isfinite(quantity->value))
            continue;
        values[item->n++] = quantity->value;
        if (isfinite(quantity->uncertainty)) {
            squares += quantity->uncertainty * quantity->uncertainty;
            with_error++;
        }
    }
    item->mean = statistics_plain_mean(values, item->n, &item->standard_deviation);
    item->within = with_error > 0 ? sqrt(squares / with_error) : NAN;
    free(values);
    return STATUS_OK;
}

static json_t *members_json(const struct ensemble *ensemble)
{
    json_t *list = json_array();
    int failed = 0;
    for (size_t k = 0; k < ensemble->n; k++) {
        const struct ensemble_member *member = &ensemble->member[k];
        failed |= json_array_append_new(list, json_pack("{s:s, s:s, s:I, s:b, s:s*}", "directory", member->directory,
                                                        "name", member->name, "seed", (json_int_t)member->seed,
                                                        "complete", (int)member->complete, "classification",
                                                        member->verdict[0] ? member->verdict : NULL));
    }
    if (!failed)
        return list;
    json_decref(list);
    return NULL;
}

static json_t *item_json(enum quantity_id id, const struct ensemble_item *item)
{
    return json_pack("{s:o, s:s, s:I, s:o, s:o, s:o}", "mean", report_json_number(item->mean.value), "unit",
                     quantity_unit(id), "n", (json_int_t)item->n, "standard_deviation",
                     report_json_number(item->standard_deviation), "standard_error",
                     report_json_number(item->mean.error), "uncertainty_within_runs", report_json_number(item->within));
}

static size_t incomplete_count(const struct ensemble *ensemble)
{
    size_t count = 0;
    for (size_t k = 0; k < ensemble->n; k++)
        count += !ensemble->member[k].complete;
    return count;
}

enum status ensemble_write(const struct ensemble *ensemble, const char *path)
{
    json_t *root = json_object();
    int failed = report_json_set(root, "n_runs", json_integer((json_int_t)ensemble->n));
    failed |= report_json_set(root, "n_incomplete", json_integer((json_int_t)incomplete_count(ensemble)));
    failed |= report_json_set(root, "runs", members_json(ensemble));
    for (int k = 0; k < QUANTITIES; k++) {
        struct ensemble_item item;
        enum status status = ensemble_item(ensemble, (enum quantity_id)k, &item);
        if (status != STATUS_OK) {
            json_decref(root);
            return status;
        }
        if (item.n > 0 || quantity_belongs((enum quantity_id)k, TEST_NONE))
            failed |= report_json_set(root, quantity_key((enum quantity_id)k), item_json((enum quantity_id)k, &item));
    }
    if (failed) {
        json_decref(root);
        root = NULL;
    }
    return report_json_dump(root, path);
}

enum status ensemble_print(FILE *out, const struct ensemble *ensemble)
{
    fprintf(out, "ensemble of %zu runs (%zu incomplete)\n", ensemble->n, incomplete_count(ensemble));
    fprintf(out, "  %-34s %5s %12s %12s %12s %12s %s\n", "quantity", "runs", "mean", "std error", "std dev",
            "within runs", "unit");
    for (int k = 0; k < QUANTITIES; k++) {
        struct ensemble_item item;
        TRY(ensemble_item(ensemble, (enum quantity_id)k, &item));
        if (item.n > 0)
            fprintf(out, "  %-34s %5zu %12.5g %12.2g %12.2g %12.2g %s\n", quantity_key((enum quantity_id)k), item.n,
                    item.mean.value, item.mean.error, item.standard_deviation, item.within,
                    quantity_unit((enum quantity_id)k));
    }
    return STATUS_OK;
}
