#include "studies/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "studies/figure.h"
#include "studies/files.h"

const char *report_spread_text(const struct spread *spread, char *text, size_t size)
{
    if (spread->n == 0)
        snprintf(text, size, "–");
    else if (!(spread->sd > 0))
        snprintf(text, size, "%.4g", spread->mean);
    else {
        double largest = fmax(fabs(spread->mean), spread->sd);
        int place = (int)floor(log10(spread->sd)) - 1, top = (int)floor(log10(largest));
        if (top >= 6 || top < -3) /* both in units of the power of ten of the larger */
            snprintf(text, size, "(%.*f ± %.*f)·10^%d", top - place, spread->mean / pow(10, top), top - place,
                     spread->sd / pow(10, top), top);
        else
            snprintf(text, size, "%.*f ± %.*f", place < 0 ? -place : 0, spread->mean, place < 0 ? -place : 0,
                     spread->sd);
    }
    return text;
}

const char *report_verdict(const json_t *analysis)
{
    const char *text = json_string_value(json_object_get(analysis, "verdict"));
    return text ? text : "";
}

static size_t note_add(char *text, size_t size, size_t used, const char *key, const char *note)
{
    if (used >= size || !note || !note[0])
        return used;
    return used +
           (size_t)snprintf(text + used, size - used, "%s%s%s%s", used ? "; " : "", key, key[0] ? ": " : "", note);
}

static size_t notes_collect(const json_t *object, const char *key, char *text, size_t size, size_t used)
{
    const char *name;
    json_t *member;
    json_object_foreach((json_t *)object, name, member)
    {
        if (strcmp(name, "note") == 0)
            used = note_add(text, size, used, key, json_string_value(member));
        else if (json_is_object(member))
            used = notes_collect(member, name, text, size, used);
    }
    return used;
}

void report_notes_text(const json_t *analysis, char *text, size_t size)
{
    size_t used = 0, index;
    json_t *note;
    text[0] = '\0';
    json_array_foreach(json_object_get(analysis, "notes"), index, note)
    {
        const char *stage = json_string_value(json_object_get(note, "stage"));
        used = note_add(text, size, used, stage ? stage : "", json_string_value(json_object_get(note, "text")));
    }
    (void)notes_collect(analysis, "", text, size, used);
}

static enum status figures_write(const struct report *report, const struct results *results)
{
    char folder[4200];
    TRY(files_join(folder, sizeof folder, report->out, "figures"));
    TRY(files_make_folder(folder));
    for (int k = 0; k < report->study->n_figures; k++) {
        struct figure_lines lines;
        TRY(figure_lines_make(&lines, results, &report->study->figure[k], report->out));
        enum status status = figure_draw(&lines, &report->study->figure[k], folder);
        figure_lines_free(&lines);
        TRY(status);
    }
    return STATUS_OK;
}

static void where_print(const struct study_where *where)
{
    for (int k = 0; k < where->n; k++)
        printf("%s%s = %s", k ? ", " : " (", where->factor[k], where->level[k]);
    if (where->n > 0)
        putchar(')');
}

static void comparison_print(const struct study *study, const struct comparison *comparison)
{
    const struct study_paper *paper = &study->paper[comparison->paper];
    char text[128];
    printf("  %s", paper->quantity);
    where_print(&paper->where);
    printf(": paper %g, ours %s", paper->value, report_spread_text(&comparison->ours, text, sizeof text));
    if (comparison->ours.n > 0)
        printf(" (%d), %+.1f %%", comparison->ours.n, 100 * (comparison->ours.mean / paper->value - 1));
    putchar('\n');
}

static void scores_print(const struct results *results)
{
    const struct study *study = results->study;
    const struct study_factor *factor = results_ranked(study);
    char number[128];
    puts("score: root mean square of (ours - paper)/tolerance");
    for (int k = 0; k < results->n_scores; k++) {
        printf("  %-28s %6.3f ", factor->level[k].name, results->score[k]);
        for (int p = 0; p < study->n_paper; p++)
            printf(" | %s", report_spread_text(&results->scored[k * study->n_paper + p], number, sizeof number));
        putchar('\n');
    }
}

static void results_print(const struct results *results)
{
    const struct study *study = results->study;
    char text[1024], number[128];
    for (int c = 0; c < results->n_cells; c++) {
        const struct cell *cell = &results->cell[c];
        cell_text(study, cell, NULL, NULL, text, sizeof text);
        printf("%s: %d runs\n", text, cell->n_runs);
        for (int k = 0; k < results->key.n && cell->n_runs > 0; k++)
            printf("  %-34s %s %s\n", results->key.text[k], report_spread_text(&cell->spread[k], number, sizeof number),
                   results->unit.text[k]);
    }
    for (int t = 0; t < results->n_tangents; t++) {
        const struct tangent *tangent = &results->tangent[t];
        cell_text(study, &results->cell[tangent->cell], study->evaluation[tangent->evaluation].along, NULL, text,
                  sizeof text);
        printf("%s:\n", text);
        for (int k = 0; k < TANGENT_KEYS; k++) {
            tangent_key_text(study, tangent, (enum tangent_key)k, text, sizeof text);
            printf("  %-34s %s %s\n", text, report_spread_text(&tangent->spread[k], number, sizeof number),
                   tangent_unit((enum tangent_key)k));
        }
    }
    if (results->n_scores > 0) {
        scores_print(results);
        return;
    }
    if (study->n_paper > 0)
        puts("beside the paper, mean ± standard deviation (samples):");
    for (int k = 0; k < study->n_paper; k++)
        if (results->comparison[k].found)
            comparison_print(study, &results->comparison[k]);
}

enum status report_write(const struct report *report)
{
    struct results results;
    TRY(results_make(&results, report->study, report->plan, report->outcome, report->out));
    enum status status = figures_write(report, &results);
    if (status == STATUS_OK)
        status = report_json_write(report, &results);
    if (status == STATUS_OK)
        status = report_csv_write(report, &results);
    if (status == STATUS_OK)
        status = report_html_write(report, &results);
    if (status == STATUS_OK) {
        results_print(&results);
        printf("report: %s/report.html\n", report->out);
    }
    results_free(&results);
    return status;
}
