/* The report as one HTML file that needs nothing else. */
#include <libconfig.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <hdf5.h>

#include "studies/files.h"
#include "studies/report.h"

static const char style[] =
    "body{font:16px/1.5 system-ui,sans-serif;max-width:70rem;margin:2rem auto;padding:0 1rem;color:#1a1a1a}"
    "h1{font-size:1.6rem;line-height:1.25}h2{font-size:1.25rem;margin-top:2.5rem;border-bottom:1px solid #ccc}"
    "table{border-collapse:collapse;font-size:.9rem}th,td{padding:.25rem .6rem;text-align:left;border-bottom:1px solid "
    "#ddd;vertical-align:top}td.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}"
    "th{border-bottom:2px solid #888}.wide{overflow-x:auto}figure{margin:2rem 0}figure svg{max-width:100%;height:auto}"
    "figcaption{color:#444}code,pre{font:.85rem/1.4 ui-monospace,monospace;background:#f4f4f4}pre{padding:.6rem;"
    "overflow-x:auto}.bad{color:#a00;font-weight:600}details{margin:1rem 0}";

void report_text_print(FILE *out, const char *text)
{
    for (; text && *text; text++)
        switch (*text) {
        case '&':
            fputs("&amp;", out);
            break;
        case '<':
            fputs("&lt;", out);
            break;
        case '>':
            fputs("&gt;", out);
            break;
        case '"':
            fputs("&quot;", out);
            break;
        default:
            fputc(*text, out);
        }
}

static void cell_print(FILE *out, const char *tag, const char *text)
{
    fprintf(out, "<%s>", tag);
    report_text_print(out, text);
    fprintf(out, "</%.2s>", tag);
}

static void number_print(FILE *out, const char *format, double value)
{
    fputs("<td class=\"n\">", out);
    if (isfinite(value))
        fprintf(out, format, value);
    else
        fputs("–", out);
    fputs("</td>", out);
}

static void spread_print(FILE *out, const struct spread *spread)
{
    char text[128];
    cell_print(out, "td class=\"n\"", report_spread_text(spread, text, sizeof text));
}

static void head_print(FILE *out, const struct report *report)
{
    const char *title = report->study->title[0] ? report->study->title : report->study->name;
    fputs("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
          "<meta name=\"viewport\" content=\"width=device-width\"><link rel=\"icon\" href=\"data:,\"><title>",
          out);
    report_text_print(out, title);
    fprintf(out, "</title><style>%s</style></head><body>\n<h1>", style);
    report_text_print(out, title);
    fputs("</h1>\n", out);
    for (int k = 0; k < report->study->method.n; k++) {
        fputs("<p>", out);
        report_text_print(out, report->study->method.text[k]);
        fputs("</p>\n", out);
    }
}

static void summary_print(FILE *out, const struct report *report, const struct results *results)
{
    int done = 0, sound = 0;
    for (int k = 0; k < report->plan->n_runs; k++) {
        done += report->outcome[k].done;
        sound += strcmp(report_verdict(results->analysis[k]), "sound") == 0;
    }
    fprintf(
        out,
        "<p>%d of %d runs are in this report%s. %d are sound by the verdict of their analysis, %d doubtful or failed "
        "(<a href=\"#runs\">reasons</a>).</p>\n<p>The command that makes it:</p>\n<pre>",
        done, report->plan->n_runs, done < report->plan->n_runs ? ", <span class=\"bad\">the others failed</span>" : "",
        sound, done - sound);
    report_text_print(out, report->command);
    fputs("</pre>\n", out);
}

/* --- Beside the paper -------------------------------------------------------------------------------------------- */

static void comparison_row(FILE *out, const struct study *study, const struct comparison *comparison)
{
    const struct study_paper *paper = &study->paper[comparison->paper];
    const struct spread *ours = &comparison->ours;
    fputs("<tr>", out);
    cell_print(out, "td", paper->quantity);
    fputs("<td>", out);
    for (int k = 0; k < paper->where.n; k++) {
        fputs(k ? ", " : "", out);
        report_text_print(out, paper->where.factor[k]);
        fputs(" = ", out);
        report_text_print(out, paper->where.level[k]);
    }
    fputs("</td>", out);
    cell_print(out, "td", paper->source);
    fprintf(out, paper->error > 0 ? "<td class=\"n\">%g ± %g</td>" : "<td class=\"n\">%g</td>", paper->value,
            paper->error);
    if (comparison->found && ours->n > 0) {
        spread_print(out, ours);
        number_print(out, "%.2g", spread_error(ours));
        fprintf(out, "<td class=\"n\">%d</td>", ours->n);
        number_print(out, "%+.3g", ours->mean - paper->value);
        number_print(out, "%+.1f %%", 100 * (ours->mean - paper->value) / fabs(paper->value));
    } else {
        fputs("<td class=\"n\">–</td><td></td><td class=\"n\">0</td><td></td><td></td>", out);
    }
    fputs("</tr>\n", out);
}

static void comparison_print(FILE *out, const struct results *results)
{
    if (results->study->n_paper == 0 || results->n_scores > 0)
        return;
    fputs("<h2 id=\"paper\">Beside the published numbers</h2>\n<p>Ours: mean ± standard deviation over samples; the "
          "error of the mean beside it.</p>\n<div "
          "class=\"wide\"><table><tr><th>quantity</th><th>where</th><th>source</th>"
          "<th>paper</th><th>ours</th><th>error of the mean</th><th>samples</th><th>difference</th><th></th></tr>\n",
          out);
    for (int k = 0; k < results->study->n_paper; k++)
        comparison_row(out, results->study, &results->comparison[k]);
    fputs("</table></div>\n", out);
}

static void paper_head(FILE *out, const struct study_paper *paper)
{
    fputs("<th>", out);
    report_text_print(out, paper->quantity);
    for (int k = 0; k < paper->where.n; k++) {
        fputs(k ? ", " : "<br>", out);
        report_text_print(out, paper->where.factor[k]);
        fputs(" = ", out);
        report_text_print(out, paper->where.level[k]);
    }
    fputs("</th>", out);
}

/* The map: for each level of the ranked factor ours beside every published number, and the score. */
static void scores_print(FILE *out, const struct results *results)
{
    const struct study *study = results->study;
    const struct study_factor *factor = results_ranked(study);
    if (!factor)
        return;
    fputs(
        "<h2 id=\"score\">Score</h2>\n<p>Root mean square of (ours − paper)/tolerance over all published numbers here; "
        "the smaller the nearer. Ours: mean ± standard deviation over samples.</p>\n<div class=\"wide\"><table><tr>",
        out);
    cell_print(out, "th", factor->label);
    fputs("<th>score</th>", out);
    for (int p = 0; p < study->n_paper; p++)
        paper_head(out, &study->paper[p]);
    fputs("</tr>\n<tr><td>paper</td><td></td>", out);
    for (int p = 0; p < study->n_paper; p++)
        number_print(out, "%g", study->paper[p].value);
    fputs("</tr>\n<tr><td>tolerance</td><td></td>", out);
    for (int p = 0; p < study->n_paper; p++)
        number_print(out, "%g",
                     study->paper[p].tolerance > 0 ? study->paper[p].tolerance : 0.1 * fabs(study->paper[p].value));
    fputs("</tr>\n", out);
    for (int k = 0; k < results->n_scores; k++) {
        fputs("<tr>", out);
        cell_print(out, "td", factor->level[k].name);
        number_print(out, "%.3g", results->score[k]);
        for (int p = 0; p < study->n_paper; p++)
            spread_print(out, &results->scored[k * study->n_paper + p]);
        fputs("</tr>\n", out);
    }
    fputs("</table></div>\n", out);
}

/* --- Figures ----------------------------------------------------------------------------------------------------- */

/* gnuplot names the parts of every drawing alike; several in one page need names of their own. */
static void svg_print(FILE *out, const char *svg, const char *name)
{
    static const char *const marks[] = {"id='", "id=\"", "href='#", "href=\"#", "url(#"};
    for (const char *p = svg; *p;) {
        size_t length = 0;
        for (size_t k = 0; k < sizeof marks / sizeof *marks && length == 0; k++)
            if (strncmp(p, marks[k], strlen(marks[k])) == 0)
                length = strlen(marks[k]);
        if (length == 0) {
            fputc(*p++, out);
            continue;
        }
        fprintf(out, "%.*s%s-", (int)length, p, name);
        p += length;
    }
}

static enum status figure_print(FILE *out, const struct report *report, const struct study_figure *figure)
{
    char path[4400], *text;
    if (snprintf(path, sizeof path, "%s/figures/%s.svg", report->out, figure->name) >= (int)sizeof path)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", report->out);
    if (!files_exist(path)) {
        fputs("<p>No data for: ", out);
        report_text_print(out, figure->title);
        fputs("</p>\n", out);
        return STATUS_OK;
    }
    TRY(files_read(path, &text));
    const char *svg = strstr(text, "<svg");
    if (!svg) {
        free(text);
        return status_fail(STATUS_FORMAT, "%s: no drawing", path);
    }
    fprintf(out, "<figure id=\"figure-%s\"><svg role=\"img\" aria-label=\"", figure->name);
    report_text_print(out, figure->title[0] ? figure->title : figure->name);
    fputc('"', out);
    svg_print(out, svg + strlen("<svg"), figure->name);
    fputs("<figcaption>", out);
    report_text_print(out, figure->title);
    fprintf(out, " (figures/%s: .svg, .pdf, .png, .csv)</figcaption></figure>\n", figure->name);
    free(text);
    return STATUS_OK;
}

static enum status figures_print(FILE *out, const struct report *report)
{
    if (report->study->n_figures > 0)
        fputs("<h2 id=\"figures\">Figures</h2>\n", out);
    for (int k = 0; k < report->study->n_figures; k++)
        TRY(figure_print(out, report, &report->study->figure[k]));
    return STATUS_OK;
}

/* --- Tables ------------------------------------------------------------------------------------------------------ */

static void cells_print(FILE *out, const struct results *results)
{
    fputs("<h2 id=\"cells\">All quantities</h2>\n<p>Mean ± standard deviation over samples.</p>\n<div "
          "class=\"wide\"><table><tr><th>runs of</th><th>samples</th>",
          out);
    for (int k = 0; k < results->key.n; k++) {
        fputs("<th>", out);
        report_text_print(out, results->key.text[k]);
        fputs(results->unit.text[k][0] ? ", " : "", out);
        report_text_print(out, results->unit.text[k]);
        fputs("</th>", out);
    }
    fputs("</tr>\n", out);
    for (int c = 0; c < results->n_cells; c++) {
        char text[1024];
        cell_text(results->study, &results->cell[c], NULL, NULL, text, sizeof text);
        fputs("<tr>", out);
        cell_print(out, "td", text);
        fprintf(out, "<td class=\"n\">%d</td>", results->cell[c].n_runs);
        for (int k = 0; k < results->key.n; k++)
            spread_print(out, &results->cell[c].spread[k]);
        fputs("</tr>\n", out);
    }
    fputs("</table></div>\n", out);
}

static void tangents_print(FILE *out, const struct results *results)
{
    if (results->n_tangents == 0)
        return;
    fputs("<h2 id=\"tangents\">Common tangents of Mohr's circles</h2>\n<p>One tangent for each seed, then mean ± "
          "standard deviation over seeds; in brackets the error of the mean.</p>\n<table><tr><th>runs of</th><th>tan "
          "φ</th><th>φ, deg</th><th>c, Pa</th></tr>\n",
          out);
    for (int t = 0; t < results->n_tangents; t++) {
        const struct tangent *tangent = &results->tangent[t];
        char text[1024], number[128];
        cell_text(results->study, &results->cell[tangent->cell], results->study->evaluation[tangent->evaluation].along,
                  NULL, text, sizeof text);
        fputs("<tr>", out);
        cell_print(out, "td", text);
        for (int k = 0; k < TANGENT_KEYS; k++) {
            fprintf(out, "<td class=\"n\">%s", report_spread_text(&tangent->spread[k], number, sizeof number));
            if (tangent->spread[k].n > 1)
                fprintf(out, " (%.2g)", spread_error(&tangent->spread[k]));
            fputs("</td>", out);
        }
        fputs("</tr>\n", out);
    }
    fputs("</table>\n", out);
}

static void runs_print(FILE *out, const struct report *report, const struct results *results)
{
    fputs("<h2 id=\"runs\">Runs</h2>\n<p>Each run again, with the programs of the processes: <code>./shakedown run "
          "runs/RUN/scene.cfg --in-process</code>.</p>\n<div class=\"wide\"><table><tr><th>run</th><th>seed</th>"
          "<th>state</th><th>verdict</th><th>notes</th><th>settings</th></tr>\n",
          out);
    for (int r = 0; r < report->plan->n_runs; r++) {
        const struct plan_run *run = &report->plan->run[r];
        char notes[2048];
        report_notes_text(results->analysis[r], notes, sizeof notes);
        fputs("<tr>", out);
        cell_print(out, "td", run->name);
        fprintf(out, "<td class=\"n\">%lld</td>", (long long)run->seed);
        fputs(report->outcome[r].done ? "<td>complete</td>" : "<td class=\"bad\">failed</td>", out);
        cell_print(out, "td", report_verdict(results->analysis[r]));
        cell_print(out, "td", report->outcome[r].done ? notes : report->outcome[r].reason);
        fputs("<td><code>", out);
        report_text_print(out, run->hash);
        fputs("</code></td></tr>\n", out);
    }
    fputs("</table></div>\n", out);
}

/* --- Settings and versions --------------------------------------------------------------------------------------- */

static void factor_print(FILE *out, const struct study_factor *factor)
{
    fputs("<li>", out);
    report_text_print(out, factor->label);
    fputs(": ", out);
    for (int k = 0; k < factor->n_levels; k++) {
        fputs(k ? ", " : "", out);
        report_text_print(out, factor->level[k].name);
    }
    fputc(' ', out);
    report_text_print(out, factor->unit);
    fputs("</li>", out);
}

static void series_print(FILE *out, const struct study_series *series)
{
    fputs("<li>", out);
    report_text_print(out, series->name);
    fputs(": scene <code>", out);
    report_text_print(out, series->scene);
    fputs("</code>", out);
    if (series->prepare[0]) {
        fputs(", prepared up to the end of stage ", out);
        report_text_print(out, series->prepare);
    }
    fputs(", seeds", out);
    for (int k = 0; k < series->n_seeds; k++)
        fprintf(out, "%s %lld", k ? "," : "", (long long)series->seed[k]);
    fputs("<ul>", out);
    for (int f = 0; f < series->n_factors; f++)
        factor_print(out, &series->factor[f]);
    for (int k = 0; k < series->set.n; k++)
        cell_print(out, "li", series->set.text[k]);
    fputs("</ul></li>\n", out);
}

static const char *first_string(const struct results *results, const char *key)
{
    for (int r = 0; r < results->plan->n_runs; r++) {
        const char *text = json_string_value(json_object_get(json_object_get(results->analysis[r], "run"), key));
        if (text)
            return text;
    }
    return "unknown";
}

static void settings_print(FILE *out, const struct report *report, const struct results *results)
{
    fputs("<h2 id=\"settings\">Settings and versions</h2>\n<ul>\n", out);
    for (int s = 0; s < report->study->n_series; s++)
        series_print(out, &report->study->series[s]);
    fprintf(out,
            "</ul>\n<p>Shakedown %s, kernels <code>%s</code>, HDF5 %d.%d.%d, libconfig %d.%d.%d, jansson %s. Effective "
            "configuration of each run: <code>runs/RUN/scene.cfg</code>.</p>\n",
            SHAKEDOWN_VERSION, first_string(results, "kernel_set"), H5_VERS_MAJOR, H5_VERS_MINOR, H5_VERS_RELEASE,
            LIBCONFIG_VER_MAJOR, LIBCONFIG_VER_MINOR, LIBCONFIG_VER_REVISION, JANSSON_VERSION);
    fputs("<details><summary>The study file</summary><pre>", out);
    report_text_print(out, report->study->text);
    fputs("</pre></details>\n", out);
}

static enum status page_print(FILE *out, const struct report *report, const struct results *results)
{
    head_print(out, report);
    summary_print(out, report, results);
    comparison_print(out, results);
    scores_print(out, results);
    TRY(figures_print(out, report));
    if (report->pictures)
        TRY(report_pictures_print(out, report, results));
    tangents_print(out, results);
    cells_print(out, results);
    settings_print(out, report, results);
    runs_print(out, report, results);
    fputs("</body></html>\n", out);
    return STATUS_OK;
}

enum status report_html_write(const struct report *report, const struct results *results)
{
    char path[4400], *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = page_print(out, report, results);
    if (fclose(out) != 0 && status == STATUS_OK)
        status = status_fail(STATUS_NO_MEMORY, "out of memory");
    if (status == STATUS_OK)
        status = files_join(path, sizeof path, report->out, "report.html");
    if (status == STATUS_OK)
        status = files_write(path, text);
    free(text);
    return status;
}
