#include "bench/accuracy_plot.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "bench/child.h"

static const char *const SERIES[] = {"dt", "hold", "jacobian"};
static const char *const TITLES[] = {"time step", "interval, hold", "interval, jacobian"};
enum { SERIES_COUNT = 3, CASES_MAX = 16 };

static const char *text_of(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

static double last_error(const json_t *row)
{
    const json_t *errors = json_object_get(row, "error");
    return json_number_value(json_array_get(errors, json_array_size(errors) - 1));
}

/* Points "CPU error residual value" of one series of one scene, as a named block; false, and no block: none. The error
 * of the finest run is zero by definition: no point. */
static bool write_block(FILE *out, const json_t *at, int index, int series)
{
    size_t k;
    json_t *row;
    bool any = false;
    json_array_foreach(json_object_get(at, "rows"), k, row)
    {
        if (strcmp(text_of(row, "series"), SERIES[series]) != 0 || !json_is_true(json_object_get(row, "ran")))
            continue;
        double error = last_error(row);
        if (!any)
            fprintf(out, "$block%d_%d << END\n", index, series);
        any = true;
        fprintf(out, "%.6g ", json_number_value(json_object_get(row, "cpu_s")));
        fprintf(out, error > 0 ? "%.6g" : "NaN", error);
        fprintf(out, " %.6g %.6g\n", json_number_value(json_object_get(row, "residual_ratio")),
                json_number_value(json_object_get(row, "value")));
    }
    if (any)
        fprintf(out, "END\n");
    return any;
}

static double floor_of(const json_t *at)
{
    size_t k;
    json_t *row;
    json_array_foreach(json_object_get(at, "rows"), k, row)
    {
        if (strcmp(text_of(row, "series"), "floor") == 0)
            return last_error(row);
    }
    return 0;
}

struct panel {
    const char *x_label, *y_label, *columns; /* of a block */
    int first, last;                         /* series */
    bool floor;
};
static const struct panel PANELS[] = {
    {"CPU time of the run / s", "relative L2 error of the curve; dashed: floor", "1:2", 0, 0, true},
    {"CPU time of the run / s", "|ledger residual| / work", "1:3", 0, 0, false},
    {"exchange interval / steps", "relative L2 error of the curve; dashed: floor", "4:2", 1, SERIES_COUNT - 1, true},
};
enum { PANEL_COUNT = sizeof PANELS / sizeof *PANELS };

static void write_panel(FILE *out, const json_t *cases, const struct panel *panel, bool there[][SERIES_COUNT])
{
    size_t k;
    json_t *at;
    fprintf(out, "set xlabel '%s'\nset ylabel '%s'\nplot ", panel->x_label, panel->y_label);
    json_array_foreach(cases, k, at)
    {
        for (int series = panel->first; series <= panel->last && k < CASES_MAX; series++)
            if (there[k][series])
                fprintf(out, "$block%zu_%d using %s with linespoints linecolor %zu pointtype %d title '%s: %s', ", k,
                        series, panel->columns, k + 1, 5 + 2 * series, text_of(at, "scene"), TITLES[series]);
        if (panel->floor && floor_of(at) > 0)
            fprintf(out, "%.6g linecolor %zu dashtype 2 notitle, ", floor_of(at), k + 1);
    }
    fprintf(out, "\n");
}

static void write_script(FILE *out, const json_t *cases, const char *path)
{
    size_t k;
    json_t *at;
    bool there[CASES_MAX][SERIES_COUNT] = {{false}};
    json_array_foreach(cases, k, at)
    {
        for (int series = 0; series < SERIES_COUNT && k < CASES_MAX; series++)
            there[k][series] = write_block(out, at, (int)k, series);
    }
    fprintf(out,
            "set terminal pngcairo size 1800,650 enhanced font 'DejaVu Sans,13' linewidth 2\nset output '%s'\n"
            "set multiplot layout 1,%d\nset logscale xy\nset format y '10^{%%T}'\nset grid\n"
            "set key above font ',11'\n",
            path, PANEL_COUNT);
    for (int panel = 0; panel < PANEL_COUNT; panel++)
        write_panel(out, cases, &PANELS[panel], there);
}

enum status accuracy_plot(const json_t *report, const char *folder, const char *path)
{
    char script[1100], log[1100];
    snprintf(script, sizeof script, "%s/plot.gp", folder);
    snprintf(log, sizeof log, "%s/plot.log", folder);
    FILE *out = fopen(script, "w");
    if (!out)
        return status_fail(STATUS_IO, "%s cannot be written", script);
    write_script(out, json_object_get(report, "cases"), path);
    if (fclose(out) != 0)
        return status_fail(STATUS_IO, "%s cannot be written", script);
    const char *const argv[] = {"gnuplot", script, NULL};
    struct child child = {.argv = argv, .log = log};
    return child_run(&child);
}
