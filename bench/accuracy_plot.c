#include "bench/accuracy_plot.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "bench/child.h"

static const char *const SERIES[] = {"dt", "hold", "jacobian"};
static const char *const TITLES[] = {"time step", "interval, hold", "interval, jacobian"};
enum { SERIES_COUNT = 3 };

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

/* Points "CPU error residual value" of one series of one scene, as a named block; false, and no block: none. */
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
        fprintf(out, "%.6g %s%.6g %.6g\n", json_number_value(json_object_get(row, "cpu_s")), error > 0 ? "" : "NaN #",
                error, json_number_value(json_object_get(row, "residual_ratio")));
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

/* The error of the finest run is zero by definition: it is in the right panel only. */
static void write_script(FILE *out, const json_t *cases, const char *path)
{
    size_t k;
    json_t *at;
    bool there[16][SERIES_COUNT] = {{false}};
    json_array_foreach(cases, k, at)
    {
        for (int series = 0; series < SERIES_COUNT && k < 16; series++)
            there[k][series] = write_block(out, at, (int)k, series);
    }
    fprintf(out,
            "set terminal pngcairo size 1600,800 enhanced font 'DejaVu Sans,15' linewidth 2\nset output '%s'\n"
            "set multiplot layout 1,2\nset logscale xy\nset format y '10^{%%T}'\nset grid\n"
            "set xlabel 'CPU time of the run / s'\nset key bottom left font ',12'\n",
            path);
    for (int panel = 0; panel < 2; panel++) {
        fprintf(out, "set ylabel '%s'\nplot ",
                panel ? "|ledger residual| / work" : "relative L2 error of the curve; dashed: floor");
        json_array_foreach(cases, k, at)
        {
            for (int series = 0; series < SERIES_COUNT && k < 16; series++)
                if (there[k][series])
                    fprintf(out, "$block%zu_%d using 1:%d with linespoints linecolor %zu pointtype %d title '%s: %s', ",
                            k, series, panel ? 3 : 2, k + 1, 5 + 2 * series, text_of(at, "scene"), TITLES[series]);
            if (!panel && floor_of(at) > 0)
                fprintf(out, "%.6g linecolor %zu dashtype 2 notitle, ", floor_of(at), k + 1);
        }
        fprintf(out, "\n");
    }
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
