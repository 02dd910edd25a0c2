#include "analyzer/series.h"
#include "analyzer/plots.h"

#include <ctype.h>
#include <errno.h>
#include <libconfig.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Columns of the printed table and curves of the plot; `plotted` ones must have one unit. */
struct series_column {
    enum quantity_id id;
    const char *title;
    bool plotted;
};

static const struct series_column cyclic_columns[] = {
    {QUANTITY_CYCLES_FIRST, "first cycle", false},
    {QUANTITY_CYCLES_RATE, "rate per cycle", true},
    {QUANTITY_CYCLES_EPS_D, "eps_D at end", false},
    {QUANTITY_CYCLES_EPS_V, "eps_V at end", false},
    {QUANTITY_CYCLES_LOOP_AREA, "loop J/m^3", false},
    {QUANTITY_CYCLES_RESILIENT_MODULUS, "modulus Pa", false},
    {QUANTITY_CYCLES_DAMPING_RATIO, "damping", false},
    {QUANTITY_ENERGY_RESIDUAL, "energy resid.", false},
    {QUANTITIES, NULL, false},
};

static const struct series_column strain_columns[] = {
    {QUANTITY_INITIAL_PHI, "initial phi", false},       {QUANTITY_PEAK_SIN_PHI, "peak sin phi", true},
    {QUANTITY_PEAK_EPS_ZZ, "peak strain", false},       {QUANTITY_CRITICAL_SIN_PHI, "crit. sin phi", true},
    {QUANTITY_CRITICAL_Q_OVER_P, "crit. q/p", false},   {QUANTITY_DILATANCY_ANGLE, "psi deg", false},
    {QUANTITY_ENERGY_RESIDUAL, "energy resid.", false}, {QUANTITIES, NULL, false},
};

static const struct series_column *columns_of(const struct ensemble *ensemble)
{
    for (size_t k = 0; k < ensemble->n; k++)
        if (isfinite(ensemble->member[k].quantity[QUANTITY_CYCLES_FIRST].value))
            return cyclic_columns;
    return strain_columns;
}

/* "stages.2.dt_s" as libconfig writes it: "stages.[2].dt_s". */
static void libconfig_path(const char *key, char *path, size_t size)
{
    size_t used = 0;
    bool number = false;
    for (const char *c = key; *c && used + 3 < size; c++) {
        if ((c == key || c[-1] == '.') && isdigit((unsigned char)*c)) {
            path[used++] = '[';
            number = true;
        }
        path[used++] = *c;
        if (number && (c[1] == '\0' || c[1] == '.')) {
            path[used++] = ']';
            number = false;
        }
    }
    path[used] = '\0';
}

/* The numbers of the group that a path leads to but for its last part; "" if there is no such group. */
static void neighbours_list(const config_t *config, const char *path, char *list, size_t size)
{
    char group[256];
    snprintf(group, sizeof group, "%s", path);
    char *dot = strrchr(group, '.');
    if (dot)
        *dot = '\0';
    const config_setting_t *parent = dot ? config_lookup(config, group) : config_root_setting(config);
    size_t used = 0;
    for (int k = 0; parent && config_setting_is_group(parent) && k < config_setting_length(parent); k++) {
        const config_setting_t *member = config_setting_get_elem(parent, (unsigned)k);
        if (!config_setting_is_number(member))
            continue;
        const int length = snprintf(list + used, size - used, "%s%s", used ? ", " : "", config_setting_name(member));
        if (length < 0 || (size_t)length >= size - used)
            return;
        used += (size_t)length;
    }
}

static enum status lookup(const char *text, const char *key, double *value)
{
    config_t config;
    char path[256] = "";
    enum status status = STATUS_OK;
    config_init(&config);
    libconfig_path(key, path, sizeof path);
    if (config_read_string(&config, text) != CONFIG_TRUE)
        status = status_fail(STATUS_FORMAT, "the scene in force cannot be read: %s", config_error_text(&config));
    char keys[700] = "";
    neighbours_list(&config, path, keys, sizeof keys);
    const config_setting_t *found = status == STATUS_OK ? config_lookup(&config, path) : NULL;
    if (found && config_setting_is_aggregate(found) && !config_setting_is_group(found) &&
        config_setting_length(found) == 1)
        found = config_setting_get_elem(found, 0); /* a bound of a condition is a list of one */
    if (status == STATUS_OK && !(found && config_setting_is_number(found)))
        status = status_fail(STATUS_USAGE, "--series: '%s' is no number of the scene%s%s", key,
                             keys[0] ? "; numbers there: " : "; keys: docs/scene-reference.md", keys);
    else if (status == STATUS_OK && config_setting_type(found) == CONFIG_TYPE_FLOAT)
        *value = config_setting_get_float(found);
    else if (status == STATUS_OK)
        *value = (double)config_setting_get_int64(found);
    config_destroy(&config);
    return status;
}

enum status series_key_value(const struct scene *scene, const char *key, double *value)
{
    char *text = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&text, &size);
    if (!stream)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    scene_print_every_key(stream, scene);
    enum status status = fclose(stream) == 0 ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "out of memory");
    if (status == STATUS_OK)
        status = lookup(text, key, value);
    free(text);
    return status;
}

static int by_name_and_value(const void *a, const void *b)
{
    const struct ensemble_member *one = a, *other = b;
    int names = strcmp(one->name, other->name);
    return names ? names : (one->key_value > other->key_value) - (one->key_value < other->key_value);
}

enum status series_check(const struct ensemble *ensemble, const char *key)
{
    for (size_t k = 1; k < ensemble->n; k++)
        if (ensemble->member[k].key_value != ensemble->member[0].key_value)
            return STATUS_OK;
    if (ensemble->n < 2)
        return STATUS_OK;
    return status_fail(
        STATUS_USAGE,
        "--series: all %zu runs have %s = %g, so that there is nothing to plot over it; without --series "
        "they are an ensemble",
        ensemble->n, key, ensemble->member[0].key_value);
}

void series_sort(struct ensemble *ensemble)
{
    qsort(ensemble->member, ensemble->n, sizeof *ensemble->member, by_name_and_value);
}

static void cell_print(FILE *out, const struct quantity *quantity)
{
    char error[32] = "";
    if (quantity->uncertainty > 0)
        snprintf(error, sizeof error, "+- %.1e", quantity->uncertainty);
    if (isfinite(quantity->value))
        fprintf(out, " %10.4g %-10s", quantity->value, error);
    else
        fprintf(out, " %10s %-10s", "-", "");
}

void series_print(FILE *out, const struct ensemble *ensemble, const char *key)
{
    const struct series_column *columns = columns_of(ensemble);
    fprintf(out, "series over %s\n  %-24s %10s", key, "run", "value");
    for (const struct series_column *c = columns; c->title; c++)
        fprintf(out, " %21s", c->title);
    fputc('\n', out);
    for (size_t k = 0; k < ensemble->n; k++) {
        const struct ensemble_member *member = &ensemble->member[k];
        fprintf(out, "  %-24s %10g", member->name, member->key_value);
        for (const struct series_column *c = columns; c->title; c++)
            cell_print(out, &member->quantity[c->id]);
        fprintf(out, " %s%s\n", member->verdict, member->complete ? "" : " INCOMPLETE");
    }
}

/* True if member k begins another curve than the one before it. */
static bool begins_curve(const struct ensemble *ensemble, size_t k)
{
    return k > 0 && strcmp(ensemble->member[k].name, ensemble->member[k - 1].name) != 0;
}

static enum status file_close(FILE *out, const char *path)
{
    int failed = ferror(out); /* sticky: covers every write before */
    if (fclose(out) != 0 || failed)
        return status_fail(STATUS_IO, "%s: cannot be written: %s", path, strerror(errno));
    return STATUS_OK;
}

static enum status csv_write(const struct ensemble *ensemble, const char *key, const char *path)
{
    FILE *out = fopen(path, "w");
    if (!out)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    fprintf(out, "name,%s,seed,classification", key);
    for (int id = 0; id < QUANTITIES; id++)
        fprintf(out, ",%s,u(%s)", quantity_key((enum quantity_id)id), quantity_key((enum quantity_id)id));
    fputc('\n', out);
    for (size_t k = 0; k < ensemble->n; k++) {
        const struct ensemble_member *member = &ensemble->member[k];
        fputs(begins_curve(ensemble, k) ? "\n\n" : "", out);
        plots_quoted(out, member->name, '"');
        fprintf(out, ",%.12g,%lld,%s", member->key_value, (long long)member->seed, member->verdict);
        for (int id = 0; id < QUANTITIES; id++)
            fprintf(out, ",%.12g,%.12g", member->quantity[id].value, member->quantity[id].uncertainty);
        fputc('\n', out);
    }
    return file_close(out, path);
}

/* Whether the curve that begins at member k has a point. */
static bool has_points(const struct ensemble *ensemble, size_t k, enum quantity_id id)
{
    do {
        if (isfinite(ensemble->member[k].quantity[id].value))
            return true;
        k++;
    } while (k < ensemble->n && !begins_curve(ensemble, k));
    return false;
}

/* One curve per plotted quantity and name, blocks of series.csv told apart by `index`; returns their number. */
static int curves_write(FILE *out, const struct ensemble *ensemble)
{
    int block = 0, curves = 0;
    char title[512];
    for (size_t k = 0; k < ensemble->n; k++) {
        block += begins_curve(ensemble, k);
        if (k > 0 && !begins_curve(ensemble, k))
            continue;
        for (const struct series_column *c = columns_of(ensemble); c->title; c++) {
            if (!c->plotted || !has_points(ensemble, k, c->id))
                continue;
            curves++;
            fprintf(out,
                    "%s'series.csv' index %d using 2:%d:(valid(%d) ? $%d : 0) with yerrorlines linewidth 1.5 "
                    "pointtype %d pointsize 0.8 linecolor %d dashtype %d title ",
                    curves == 1 ? "plot " : ", \\\n     ", block, 5 + 2 * (int)c->id, 6 + 2 * (int)c->id,
                    6 + 2 * (int)c->id, 6 + curves % 2, curves, 1 + block);
            snprintf(title, sizeof title, "%s, %s", ensemble->member[k].name, c->title);
            plots_quoted(out, title, '\'');
        }
    }
    fputc('\n', out);
    return curves;
}

/* Opens the script `path` of a figure NAME.svg of series.csv and writes what all have in common. */
static enum status script_open(const char *path, const char *name, FILE **out)
{
    *out = fopen(path, "w");
    if (!*out)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    fprintf(*out,
            "# Made by analyzer; run `gnuplot %s.gp` here to make the plot again.\n"
            "set encoding utf8\nset datafile separator ','\nset datafile missing 'nan'\n"
            "set terminal svg size 720,500 enhanced font 'DejaVu Sans,15' background 'white'\n"
            "set output '%s.svg'\nset grid\n",
            name, name);
    return STATUS_OK;
}

static enum status script_write(const struct ensemble *ensemble, const char *key, const char *path, int *curves)
{
    FILE *out;
    TRY(script_open(path, "series", &out));
    fprintf(out,
            "set colorsequence podo\n"
            "set key outside above horizontal Left reverse noenhanced\n"
            "set offsets graph 0.02, graph 0.02, graph 0.05, graph 0.05\n"
            "set xlabel '%s' noenhanced\nset ylabel '%s'\n",
            key, columns_of(ensemble) == cyclic_columns ? "strain per cycle" : "sin(friction angle)");
    *curves = curves_write(out, ensemble);
    fprintf(out, "unset output\n");
    return file_close(out, path);
}

enum status series_write(const struct ensemble *ensemble, const char *key, const char *directory, int *curves)
{
    char path[2048];
    if (snprintf(path, sizeof path, "%s/series.csv", directory) >= (int)sizeof path)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", directory);
    TRY(csv_write(ensemble, key, path));
    snprintf(path, sizeof path, "%s/series.gp", directory);
    return script_write(ensemble, key, path, curves);
}

enum status series_liquefaction_write(const struct ensemble *ensemble, const char *directory, bool *liquefied)
{
    char path[2048];
    *liquefied = false;
    for (size_t k = 0; k < ensemble->n; k++)
        *liquefied |= isfinite(ensemble->member[k].quantity[QUANTITY_CYCLES_LIQUEFACTION].value) != 0;
    if (!*liquefied)
        return STATUS_OK;
    if (snprintf(path, sizeof path, "%s/liquefaction.gp", directory) >= (int)sizeof path)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", directory);
    FILE *out;
    TRY(script_open(path, "liquefaction", &out));
    fprintf(out,
            "set logscale x\nset yrange [0:*]\nunset key\n"
            "set offsets 0, 0, graph 0.05, 0\n"
            "set xlabel 'cycles to liquefaction'\nset ylabel 'cyclic stress ratio q_{cyc}/(2 p_0)'\n"
            "plot 'series.csv' using %d:%d with points pointtype 7\nunset output\n",
            5 + 2 * QUANTITY_CYCLES_LIQUEFACTION, 5 + 2 * QUANTITY_CYCLES_STRESS_RATIO);
    return file_close(out, path);
}
