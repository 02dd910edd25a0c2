/* The numbers of a study as JSON and CSV. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "studies/files.h"
#include "studies/report.h"

static enum status no_memory(void)
{
    return status_fail(STATUS_NO_MEMORY, "out of memory");
}

static json_t *number_json(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *spread_json(const struct spread *spread, const char *unit)
{
    return json_pack("{s:o, s:o, s:o, s:i, s:s}", "mean", number_json(spread->mean), "standard_deviation",
                     number_json(spread->sd), "standard_error", number_json(spread_error(spread)), "samples", spread->n,
                     "unit", unit);
}

static json_t *levels_json(const struct study *study, int series, const int *level)
{
    json_t *object = json_object();
    const struct study_series *s = &study->series[series];
    int failed = object ? 0 : -1;
    for (int f = 0; failed == 0 && f < s->n_factors; f++)
        failed = json_object_set_new(object, s->factor[f].name, json_string(s->factor[f].level[level[f]].name));
    if (failed == 0)
        return object;
    json_decref(object);
    return NULL;
}

static json_t *cell_json(const struct results *results, const struct cell *cell)
{
    json_t *numbers = json_object();
    int failed = numbers ? 0 : -1;
    for (int k = 0; failed == 0 && k < results->key.n; k++)
        failed =
            json_object_set_new(numbers, results->key.text[k], spread_json(&cell->spread[k], results->unit.text[k]));
    if (failed != 0) {
        json_decref(numbers);
        return NULL;
    }
    return json_pack("{s:s, s:o, s:i, s:o}", "series", results->study->series[cell->series].name, "levels",
                     levels_json(results->study, cell->series, cell->level), "runs", cell->n_runs, "quantities",
                     numbers);
}

static json_t *run_json(const struct report *report, const struct results *results, int r)
{
    const struct plan_run *run = &report->plan->run[r];
    char notes[2048] = "";
    json_t *numbers = json_object();
    int failed = numbers ? 0 : -1;
    for (int k = 0; failed == 0 && results->analysis[r] && k < results->key.n; k++)
        failed = json_object_set_new(numbers, results->key.text[k],
                                     number_json(results->number[r * results->key.n + k].value));
    if (failed != 0) {
        json_decref(numbers);
        return NULL;
    }
    report_notes_text(results->analysis[r], notes, sizeof notes);
    return json_pack("{s:s, s:I, s:o, s:s, s:b, s:s, s:s, s:s, s:o}", "name", run->name, "seed", (json_int_t)run->seed,
                     "levels", levels_json(report->study, run->series, run->level), "settings", run->hash, "done",
                     (int)report->outcome[r].done, "failure",
                     report->outcome[r].reason ? report->outcome[r].reason : "", "verdict",
                     report_verdict(results->analysis[r]), "notes", notes, "quantities", numbers);
}

static json_t *tangent_json(const struct results *results, const struct tangent *tangent)
{
    json_t *numbers = json_object();
    const struct cell *cell = &results->cell[tangent->cell];
    int failed = numbers ? 0 : -1;
    for (int k = 0; failed == 0 && k < TANGENT_KEYS; k++) {
        char key[2 * CONFIG_STRING_MAX];
        tangent_key_text(results->study, tangent, (enum tangent_key)k, key, sizeof key);
        failed = json_object_set_new(numbers, key, spread_json(&tangent->spread[k], tangent_unit((enum tangent_key)k)));
    }
    char text[1024];
    cell_text(results->study, cell, results->study->evaluation[tangent->evaluation].along, NULL, text, sizeof text);
    if (failed == 0)
        return json_pack("{s:s, s:o}", "cells", text, "quantities", numbers);
    json_decref(numbers);
    return NULL;
}

static json_t *comparison_json(const struct study *study, const struct comparison *comparison)
{
    const struct study_paper *paper = &study->paper[comparison->paper];
    json_t *where = json_object();
    int failed = where ? 0 : -1;
    for (int k = 0; failed == 0 && k < paper->where.n; k++)
        failed = json_object_set_new(where, paper->where.factor[k], json_string(paper->where.level[k]));
    if (failed != 0) {
        json_decref(where);
        return NULL;
    }
    return json_pack("{s:s, s:o, s:s, s:f, s:f, s:o}", "quantity", paper->quantity, "where", where, "source",
                     paper->source, "published", paper->value, "published_error", paper->error, "ours",
                     spread_json(&comparison->ours, ""));
}

/* The map of scores; empty without one. */
static json_t *scores_json(const struct results *results)
{
    const struct study_factor *factor = results_ranked(results->study);
    json_t *scores = json_object();
    int failed = scores ? 0 : -1;
    for (int k = 0; failed == 0 && k < results->n_scores; k++)
        failed = json_object_set_new(scores, factor->level[k].name, number_json(results->score[k]));
    if (failed == 0)
        return scores;
    json_decref(scores);
    return NULL;
}

static json_t *report_json(const struct report *report, const struct results *results)
{
    json_t *runs = json_array(), *cells = json_array(), *tangents = json_array(), *papers = json_array();
    int failed = 0;
    for (int r = 0; r < report->plan->n_runs; r++)
        failed |= json_array_append_new(runs, run_json(report, results, r));
    for (int c = 0; c < results->n_cells; c++)
        failed |= json_array_append_new(cells, cell_json(results, &results->cell[c]));
    for (int t = 0; t < results->n_tangents; t++)
        failed |= json_array_append_new(tangents, tangent_json(results, &results->tangent[t]));
    for (int k = 0; k < report->study->n_paper; k++)
        failed |= json_array_append_new(papers, comparison_json(report->study, &results->comparison[k]));
    json_t *root =
        json_pack("{s:s, s:s, s:s, s:s, s:o, s:o, s:o, s:o, s:o}", "study", report->study->name, "title",
                  report->study->title, "version", SHAKEDOWN_VERSION, "command", report->command, "cells", cells,
                  "tangents", tangents, "comparison", papers, "scores", scores_json(results), "runs", runs);
    if (failed == 0)
        return root;
    json_decref(root);
    return NULL;
}

enum status report_json_write(const struct report *report, const struct results *results)
{
    char path[4400];
    json_t *root = report_json(report, results);
    char *text = root ? json_dumps(root, JSON_INDENT(2)) : NULL;
    json_decref(root);
    if (!text)
        return no_memory();
    enum status status = files_join(path, sizeof path, report->out, "results.json");
    if (status == STATUS_OK)
        status = files_write(path, text);
    free(text);
    return status;
}

/* --- CSV --------------------------------------------------------------------------------------------------------- */

static void csv_text(FILE *out, const char *text)
{
    fputc('"', out);
    for (; text && *text; text++) {
        if (*text == '"')
            fputc('"', out);
        fputc(*text == '\n' ? ' ' : *text, out);
    }
    fputc('"', out);
}

static void csv_number(FILE *out, double value)
{
    fputc(',', out);
    if (isfinite(value))
        fprintf(out, "%.10g", value);
}

static void runs_csv(FILE *out, const struct report *report, const struct results *results)
{
    fputs("run,seed,done,verdict", out);
    for (int k = 0; k < results->key.n; k++)
        fprintf(out, ",%s", results->key.text[k]);
    fputc('\n', out);
    for (int r = 0; r < report->plan->n_runs; r++) {
        csv_text(out, report->plan->run[r].name);
        fprintf(out, ",%lld,%d,", (long long)report->plan->run[r].seed, (int)report->outcome[r].done);
        csv_text(out, report_verdict(results->analysis[r]));
        for (int k = 0; k < results->key.n; k++)
            csv_number(out, results->analysis[r] ? results->number[r * results->key.n + k].value : NAN);
        fputc('\n', out);
    }
}

static void spread_row(FILE *out, const char *cell, const char *key, const char *unit, const struct spread *spread)
{
    csv_text(out, cell);
    fprintf(out, ",%s,%s,%d", key, unit, spread->n);
    csv_number(out, spread->mean);
    csv_number(out, spread->sd);
    csv_number(out, spread_error(spread));
    fputc('\n', out);
}

static void cells_csv(FILE *out, const struct report *report, const struct results *results)
{
    char text[1024], key[2 * CONFIG_STRING_MAX];
    fputs("cell,quantity,unit,samples,mean,standard_deviation,standard_error\n", out);
    for (int c = 0; c < results->n_cells; c++) {
        cell_text(report->study, &results->cell[c], NULL, NULL, text, sizeof text);
        for (int k = 0; k < results->key.n; k++)
            spread_row(out, text, results->key.text[k], results->unit.text[k], &results->cell[c].spread[k]);
    }
    for (int t = 0; t < results->n_tangents; t++) {
        const struct tangent *tangent = &results->tangent[t];
        cell_text(report->study, &results->cell[tangent->cell], report->study->evaluation[tangent->evaluation].along,
                  NULL, text, sizeof text);
        for (int k = 0; k < TANGENT_KEYS; k++) {
            tangent_key_text(report->study, tangent, (enum tangent_key)k, key, sizeof key);
            spread_row(out, text, key, tangent_unit((enum tangent_key)k), &tangent->spread[k]);
        }
    }
}

static void comparison_csv(FILE *out, const struct report *report, const struct results *results)
{
    fputs("quantity,where,source,published,published_error,mean,standard_deviation,samples\n", out);
    for (int k = 0; k < report->study->n_paper; k++) {
        const struct study_paper *paper = &report->study->paper[k];
        const struct spread *ours = &results->comparison[k].ours;
        fprintf(out, "%s,\"", paper->quantity);
        for (int j = 0; j < paper->where.n; j++)
            fprintf(out, "%s%s=%s", j ? " " : "", paper->where.factor[j], paper->where.level[j]);
        fputs("\",", out);
        csv_text(out, paper->source);
        csv_number(out, paper->value);
        csv_number(out, paper->error > 0 ? paper->error : NAN);
        csv_number(out, ours->n > 0 ? ours->mean : NAN);
        csv_number(out, ours->n > 0 ? ours->sd : NAN);
        fprintf(out, ",%d\n", ours->n);
    }
}

enum status report_csv_write(const struct report *report, const struct results *results)
{
    static const struct {
        const char *name;
        void (*print)(FILE *, const struct report *, const struct results *);
    } file[] = {{"runs.csv", runs_csv}, {"cells.csv", cells_csv}, {"comparison.csv", comparison_csv}};
    for (size_t k = 0; k < sizeof file / sizeof *file; k++) {
        char path[4400], *text = NULL;
        size_t size = 0;
        FILE *out = open_memstream(&text, &size);
        if (!out)
            return no_memory();
        file[k].print(out, report, results);
        enum status status = fclose(out) == 0 ? STATUS_OK : no_memory();
        if (status == STATUS_OK)
            status = files_join(path, sizeof path, report->out, file[k].name);
        if (status == STATUS_OK)
            status = files_write(path, text);
        free(text);
        TRY(status);
    }
    return STATUS_OK;
}
