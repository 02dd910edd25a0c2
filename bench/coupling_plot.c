#include <stdio.h>
#include <string.h>

#include "bench/child.h"
#include "bench/coupling_bench.h"

/* Colours that stay apart for colour-blind readers (Okabe & Ito 2008). */
static const struct {
    const char *scheme, *color;
    int point;
} lines[] = {{"hold", "#999999", 4},      {"jacobian", "#0072B2", 6}, {"compensated", "#E69F00", 5},
             {"pipelined", "#D55E00", 8}, {"adaptive", "#CC79A7", 2}, {"impedance", "#009E73", 7}};
enum { LINES = sizeof lines / sizeof *lines };

static const char *text_of(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

static double number_of(const json_t *object, const char *key)
{
    return json_number_value(json_object_get(object, key));
}

/* Points "time error n" of a scheme as a named block; false, and no block: none. Equal bits have no error to draw. */
static bool write_block(FILE *out, const json_t *at, size_t index, int line)
{
    size_t k;
    json_t *point;
    bool any = false;
    json_array_foreach(json_object_get(at, "points"), k, point)
    {
        if (strcmp(text_of(point, "scheme"), lines[line].scheme) != 0 || !json_is_true(json_object_get(point, "ran")) ||
            !(number_of(point, "error") > 0))
            continue;
        if (!any)
            fprintf(out, "$block%zu_%d << END\n", index, line);
        any = true;
        double tolerance = number_of(point, "tolerance");
        fprintf(out, "%.6g %.6g ", number_of(point, "time_ratio"), number_of(point, "error"));
        if (tolerance > 0)
            fprintf(out, "%.0e\n", tolerance);
        else
            fprintf(out, "%.0f\n", number_of(point, "interval_steps"));
    }
    if (any)
        fprintf(out, "END\n");
    return any;
}

static void write_targets(FILE *out, const json_t *at)
{
    size_t k;
    json_t *target;
    json_array_foreach(json_object_get(at, "targets"), k, target)
    {
        double error = number_of(target, "error"), ratio = number_of(target, "ratio");
        fprintf(out,
                "set arrow from graph 0,first %g to first %g,%g nohead dashtype 3 linecolor 'black' front\n"
                "set arrow from first %g,%g to first %g,graph 0 nohead dashtype 3 linecolor 'black' front\n"
                "set label 'target' at first %g,%g right offset -0.5,0.5 font ',10'\n",
                error, ratio, error, ratio, error, ratio, ratio, error);
    }
}

static void write_panel(FILE *out, const json_t *at, size_t index)
{
    bool there[LINES];
    for (int line = 0; line < LINES; line++)
        there[line] = write_block(out, at, index, line);
    fprintf(out, "unset arrow\nunset label\nset title '%s'\n", text_of(at, "title"));
    write_targets(out, at);
    fprintf(out, "plot ");
    for (int line = 0; line < LINES; line++)
        if (there[line])
            fprintf(out,
                    "$block%zu_%d using 1:2 with linespoints linecolor '%s' linewidth 1.5 pointtype %d title '%s', "
                    "'' using 1:2:3 with labels offset 0.3,0.6 left font ',8' textcolor '%s' notitle, ",
                    index, line, lines[line].color, lines[line].point, lines[line].scheme, lines[line].color);
    double floor = number_of(at, "floor");
    fprintf(out, "%g with lines dashtype 2 linecolor 'black' title 'floor: one particle moved by 10^{-13} m'\n",
            floor > 0 ? floor : 1e-16);
}

static void write_script(FILE *out, const json_t *cases, const char *path)
{
    size_t k, n = json_array_size(cases);
    json_t *at;
    fprintf(out,
            "set encoding utf8\nset terminal pngcairo size %zu,640 enhanced font 'DejaVu Sans,12' background 'white'\n"
            "set output '%s'\nset multiplot layout 1,%zu\nset logscale xy\nset format y '10^{%%T}'\n"
            "set xtics (1, 1.1, 1.2, 1.5, 2, 3, 4, 6, 10)\nset xrange [0.9:*]\n"
            "set grid linecolor '#cccccc'\nset key above font ',10' maxrows 3\n"
            "set xlabel 'time over that of the exact loop in one process'\n",
            720 * (n > 0 ? n : 1), path, n > 0 ? n : 1);
    json_array_foreach(cases, k, at)
    {
        const char *measure = text_of(at, "measure");
        fprintf(out, "set ylabel '%s'\n",
                strcmp(measure, "strain") == 0 ? "error of the strain over its range"
                                               : "relative L2 error of the stress");
        write_panel(out, at, k);
    }
    fprintf(out, "unset multiplot\n");
}

enum status coupling_plot(const json_t *cases, const char *folder, const char *path)
{
    char script[COUPLING_PATH_MAX + 16], log[COUPLING_PATH_MAX + 16];
    snprintf(script, sizeof script, "%s/plot.gp", folder);
    snprintf(log, sizeof log, "%s/plot.log", folder);
    FILE *out = fopen(script, "w");
    if (!out)
        return status_fail(STATUS_IO, "%s cannot be written", script);
    write_script(out, cases, path);
    if (fclose(out) != 0)
        return status_fail(STATUS_IO, "%s cannot be written", script);
    const char *const argv[] = {"gnuplot", script, NULL};
    struct child child = {.argv = argv, .log = log};
    return child_run(&child);
}
