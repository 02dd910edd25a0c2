#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "studies/figure.h"
#include "studies/files.h"
#include "studies/process.h"

/* Colours that stay apart for colour-blind readers (Okabe & Ito 2008). */
static const char *const colours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                      "#56B4E9", "#E69F00", "#000000", "#999999"};
enum { COLOURS = sizeof colours / sizeof *colours, KEY_MAX = 16 };

static const char *colour_of(const struct figure_line *line)
{
    return colours[line->colour % COLOURS];
}

/* A string for gnuplot in single quotes: nothing in it is carried out. */
static void quoted(FILE *out, const char *text)
{
    fputc('\'', out);
    for (; *text; text++) {
        if (*text == '\'')
            fputc('\'', out);
        fputc(*text == '\n' ? ' ' : *text, out);
    }
    fputc('\'', out);
}

static void number_print(FILE *out, double value)
{
    if (isfinite(value))
        fprintf(out, "%.8g", value);
    else
        fputs("NaN", out);
}

static void data_print(FILE *out, const struct figure_lines *lines)
{
    for (int k = 0; k < lines->n; k++) {
        const struct figure_line *line = &lines->line[k];
        fprintf(out, "$d%d << END\n", k);
        for (int j = 0; j < line->n; j++) {
            number_print(out, line->x[j]);
            fputc(' ', out);
            number_print(out, line->y[j]);
            fputc(' ', out);
            number_print(out, isfinite(line->error[j]) ? line->error[j] : 0);
            fputc('\n', out);
        }
        fputs("END\n", out);
    }
}

static void title_print(FILE *out, const struct figure_line *line)
{
    if (line->label[0]) {
        fputs(" title ", out);
        quoted(out, line->label);
    } else {
        fputs(" notitle", out);
    }
}

/* Dashes tell lines apart that share a colour, and where colours run out. */
static int dash_of(const struct figure_line *line)
{
    return 1 + line->colour / COLOURS % 5;
}

static void line_print(FILE *out, const struct figure_line *line, int k, const char *separator)
{
    const char *colour = colour_of(line);
    fputs(separator, out);
    if (line->style == LINE_BAND) {
        fprintf(out,
                "$d%d using 1:($2-$3):($2+$3) with filledcurves linecolor '%s' fillstyle transparent solid 0.18 "
                "noborder notitle",
                k, colour);
        fprintf(out, ", \\\n     $d%d using 1:2 with lines linewidth 1.8 dashtype %d linecolor '%s'", k, dash_of(line),
                colour);
    } else if (line->style == LINE_POINTS) {
        fprintf(out,
                "$d%d using 1:2:3 with yerrorlines pointtype %d pointsize 0.7 linewidth 1.5 dashtype %d linecolor '%s'",
                k, 5 + 2 * (line->colour % 3), dash_of(line), colour);
    } else if (line->style == LINE_PAPER) {
        fprintf(out, "$d%d using 1:2:3 with yerrorbars pointtype %d pointsize 1.2 linewidth 1.5 linecolor '%s'", k,
                4 + 2 * (line->colour % 3), colour);
    } else {
        fprintf(out, "$d%d using 1:2 with lines linewidth 1.5 dashtype %d linecolor '%s'", k, dash_of(line), colour);
    }
    title_print(out, line);
}

static void axes_print(FILE *out, const struct study_figure *figure)
{
    fputs("set xlabel ", out);
    quoted(out, figure->x_label[0] ? figure->x_label : figure->x);
    fputs("\nset ylabel ", out);
    quoted(out, figure->y_label[0] ? figure->y_label : figure->y);
    fputc('\n', out);
    if (figure->x_log)
        fputs("set logscale x\n", out);
    if (figure->y_log)
        fputs("set logscale y\n", out);
    if (figure->kind == FIGURE_MOHR)
        fputs("set size ratio -1\nset yrange [0:]\n", out);
}

static void script_print(FILE *out, const struct figure_lines *lines, const struct study_figure *figure)
{
    const char *separator = "plot ";
    fprintf(out,
            "# gnuplot %s.gp makes the figure again, here.\n"
            "set encoding utf8\n"
            "set border 31 linewidth 1.2\nset tics nomirror in scale 0.8\nset mxtics 2\nset mytics 2\n"
            "set grid linewidth 0.6 linecolor '#cccccc'\nset offsets graph 0.02, graph 0.02, graph 0.03, graph 0.03\n"
            "set key outside below horizontal Left reverse samplen 2 spacing 1.15 font ',11'\n",
            figure->name);
    data_print(out, lines);
    axes_print(out, figure);
    fprintf(out,
            "set terminal svg size 720,540 enhanced font 'DejaVu Sans,14' background 'white'\nset output '%s.svg'\n",
            figure->name);
    for (int k = 0; k < lines->n; k++) {
        if (lines->line[k].n == 0)
            continue;
        line_print(out, &lines->line[k], k, separator);
        separator = ", \\\n     ";
    }
    fprintf(out,
            "\nset terminal pdfcairo size 16cm,12cm enhanced font 'DejaVu Sans,11'\nset output '%s.pdf'\nreplot\n"
            "set terminal pngcairo size 1440,1080 enhanced font 'DejaVu Sans,14' fontscale 2 linewidth 2 pointscale 2 "
            "background 'white'\nset output '%s.png'\nreplot\nunset output\n",
            figure->name, figure->name);
}

static void csv_print(FILE *out, const struct figure_lines *lines)
{
    fputs("line,x,y,spread\n", out);
    for (int k = 0; k < lines->n; k++) {
        const struct figure_line *line = &lines->line[k];
        for (int j = 0; j < line->n; j++) {
            fprintf(out, "\"%s%s\",%.10g,%.10g,", line->label[0] ? line->label : "circle",
                    line->style == LINE_PAPER ? " (published)" : "", line->x[j], line->y[j]);
            if (isfinite(line->error[j]))
                fprintf(out, "%.10g", line->error[j]);
            fputc('\n', out);
        }
    }
}

static enum status text_write(const char *folder, const char *name, const char *suffix,
                              const struct figure_lines *lines, const struct study_figure *figure)
{
    char path[4400], *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    if (strcmp(suffix, "gp") == 0)
        script_print(out, lines, figure);
    else
        csv_print(out, lines);
    enum status status = fclose(out) == 0 ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "out of memory");
    if (snprintf(path, sizeof path, "%s/%s.%s", folder, name, suffix) >= (int)sizeof path)
        status = status_fail(STATUS_USAGE, "%.60s...: the path is too long", folder);
    if (status == STATUS_OK)
        status = files_write(path, text);
    free(text);
    return status;
}

static bool has_points(const struct figure_lines *lines)
{
    for (int k = 0; k < lines->n; k++)
        if (lines->line[k].n > 0)
            return true;
    return false;
}

enum status figure_draw(const struct figure_lines *lines, const struct study_figure *figure, const char *folder)
{
    char script[CONFIG_STRING_MAX + 8], log[4400];
    const char *const argv[] = {"gnuplot", script, NULL};
    int code;
    TRY(text_write(folder, figure->name, "gp", lines, figure));
    TRY(text_write(folder, figure->name, "csv", lines, figure));
    if (!has_points(lines))
        return STATUS_OK;
    snprintf(script, sizeof script, "%s.gp", figure->name);
    TRY(files_join(log, sizeof log, folder, "gnuplot.log"));
    TRY(process_run(argv, folder, log, &code));
    if (code != 0)
        return status_fail(STATUS_IO, "gnuplot %s/%s failed; see %s", folder, script, log);
    return STATUS_OK;
}
