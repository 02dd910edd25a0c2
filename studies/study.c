#include "studies/study.h"

#include <errno.h>
#include <libgen.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/config_literals.h"
#include "studies/files.h"

#define OF(type, member) offsetof(struct type, member)
#define TEXT(name, type, member, preset, doc)                                                                          \
    {                                                                                                                  \
        name, KEY_STRING, OF(type, member), NULL, 0, 0, preset, NULL, NULL, doc                                        \
    }
#define NUMBER(name, type, member, unit, min, preset, doc)                                                             \
    {                                                                                                                  \
        name, KEY_FLOAT, OF(type, member), unit, min, INFINITY, preset, NULL, NULL, doc                                \
    }
#define SWITCH(name, type, member, preset, doc)                                                                        \
    {                                                                                                                  \
        name, KEY_BOOL, OF(type, member), NULL, 0, 0, preset, NULL, NULL, doc                                          \
    }

static const struct key study_keys[] = {
    TEXT("name", study, name, NULL, "name of the study: letters, digits, '-' and '_'"),
    TEXT("title", study, title, "", "what it is about, one line"),
    TEXT("score", study, score, "", "factor whose levels are ranked by their distance from `paper`"),
    {0}};

static const struct key series_keys[] = {
    TEXT("name", study_series, name, "all", "name of the series"),
    TEXT("scene", study_series, scene, "", "scene file, relative to the study file; in a series: default the study's"),
    TEXT("prepare", study_series, prepare, "",
         "name of a stage: up to its end runs that agree in everything share one preparation per seed, and start from "
         "its checkpoint"),
    {0}};

static const struct key factor_keys[] = {
    TEXT("name", study_factor, name, NULL, "name of what is varied: a word"),
    TEXT("label", study_factor, label, "", "how tables and figures call it; default: name"),
    TEXT("unit", study_factor, unit, "", "unit of the values"),
    NUMBER("scale", study_factor, scale, NULL, -INFINITY, "1", "the keys get values times this"),
    {0}};

static const struct key level_keys[] = {
    TEXT("name", study_level, name, "", "how it is called; default: its value"),
    NUMBER("value", study_level, value, NULL, -INFINITY, "nan", "where figures put it; default: its place in the list"),
    {0}};

static const struct key paper_keys[] = {
    TEXT("quantity", study_paper, quantity, NULL, "a key of analysis.json, or NAME.KEY of an evaluation"),
    TEXT("series", study_paper, series, "", "which series; default: any"),
    NUMBER("value", study_paper, value, NULL, -INFINITY, NULL, "the published number"),
    NUMBER("error", study_paper, error, NULL, 0, "0", "its published error; 0: none"),
    NUMBER("tolerance", study_paper, tolerance, NULL, 0, "0",
           "difference that counts as 1 in scores; 0: a tenth of the value"),
    TEXT("source", study_paper, source, "", "where it is printed"),
    {0}};

static const char *const evaluation_names[] = {"decay", "slope", "tangent", NULL};

static const struct key evaluation_keys[] = {
    {"kind", KEY_CHOICE, OF(study_evaluation, kind), NULL, 0, 0, NULL, evaluation_names, NULL,
     "decay: time in which the swings of a column die away (NAME.tau_s); slope: of a straight line through column over "
     "x "
     "(NAME.slope); tangent: common tangent of Mohr circles "
     "(NAME.tan_phi, NAME.friction_angle_deg, NAME.cohesion_pa)"},
    TEXT("name", study_evaluation, name, NULL, "name of the evaluation"),
    TEXT("series", study_evaluation, series, "", "which series; default: all"),
    TEXT("column", study_evaluation, column, "sigma_xx_pa", "decay, slope: column of curves.csv"),
    TEXT("x", study_evaluation, x, "eps_zz_log", "slope: the other column"),
    NUMBER("from", study_evaluation, from, NULL, -INFINITY, "0", "slope: window in x, from"),
    NUMBER("to", study_evaluation, to, NULL, -INFINITY, "0", "slope: to; 0: the end"),
    NUMBER("target", study_evaluation, target, NULL, -INFINITY, "nan",
           "decay: the value that it comes to; default: its last"),
    NUMBER("from_s", study_evaluation, from_s, "s", 0, "0", "decay: window, in the time of the stage, from"),
    NUMBER("to_s", study_evaluation, to_s, "s", 0, "0", "decay: to; 0: the end"),
    TEXT("along", study_evaluation, along, "", "tangent: factor whose values are the confining stresses"),
    TEXT("major", study_evaluation, major, "peak.sigma_corr_pa", "tangent: quantity that is the major stress"),
    {0}};

static const char *const figure_names[] = {"curves", "points", "mohr", NULL};

static const struct key figure_keys[] = {
    {"kind", KEY_CHOICE, OF(study_figure, kind), NULL, 0, 0, NULL, figure_names, NULL,
     "curves: columns of a table of each run; points: a quantity over a factor; mohr: circles and tangents"},
    TEXT("name", study_figure, name, NULL, "name of its files: letters, digits, '-' and '_'"),
    TEXT("title", study_figure, title, "", "what is to be seen; also the text alternative"),
    TEXT("series", study_figure, series, "", "which series; default: all that have the factor"),
    TEXT("table", study_figure, table, "curves.csv", "curves: file of each run, curves.csv or cycles.csv"),
    TEXT("x", study_figure, x, "", "curves: a column; points: a factor"),
    TEXT("y", study_figure, y, "", "curves: a column; points: a quantity"),
    TEXT("x_label", study_figure, x_label, "", "text of the axis, gnuplot's enhanced text"),
    TEXT("y_label", study_figure, y_label, "", "the same"),
    NUMBER("x_scale", study_figure, x_scale, NULL, -INFINITY, "1", "x is drawn times this"),
    NUMBER("y_scale", study_figure, y_scale, NULL, -INFINITY, "1", "y is drawn times this"),
    NUMBER("x_min", study_figure, x_min, NULL, -INFINITY, "0", "curves: from this x"),
    NUMBER("x_max", study_figure, x_max, NULL, -INFINITY, "0", "curves: to this x; both 0: all"),
    SWITCH("x_log", study_figure, x_log, "false", "logarithmic axis"),
    SWITCH("y_log", study_figure, y_log, "false", "logarithmic axis"),
    SWITCH("mean", study_figure, mean, "true", "curves: mean and spread over seeds; false: the first seed as it is"),
    TEXT("evaluation", study_figure, evaluation, "", "mohr: name of a tangent"),
    {0}};

enum status text_list_add(struct text_list *list, const char *text)
{
    char **larger = realloc(list->text, ((size_t)list->n + 1) * sizeof *larger);
    if (!larger)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    list->text = larger;
    list->text[list->n] = strdup(text);
    if (!list->text[list->n])
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    list->n++;
    return STATUS_OK;
}

void text_list_free(struct text_list *list)
{
    for (int k = 0; k < list->n; k++)
        free(list->text[k]);
    free(list->text);
    *list = (struct text_list){0};
}

int study_factor_find(const struct study_series *series, const char *name)
{
    for (int k = 0; k < series->n_factors; k++)
        if (strcmp(series->factor[k].name, name) == 0)
            return k;
    return -1;
}

/* "where.name", or name alone at the top. */
static const char *path_join(char *path, size_t size, const char *where, const char *name)
{
    snprintf(path, size, "%s%s%s", where, where[0] ? "." : "", name);
    return path;
}

/* The strings of a list that may be missing, or be one string. */
static enum status strings_read(const config_setting_t *parent, const char *name, const char *where,
                                struct text_list *list)
{
    char path[256];
    const config_setting_t *setting = config_setting_get_member(parent, name);
    if (!setting)
        return STATUS_OK;
    path_join(path, sizeof path, where, name);
    if (config_setting_type(setting) == CONFIG_TYPE_STRING)
        return text_list_add(list, config_setting_get_string(setting));
    if (!config_setting_is_list(setting) && !config_setting_is_array(setting))
        return config_fail(setting, path, "must be a list of strings: [ \"...\", \"...\" ]");
    for (int k = 0; k < config_setting_length(setting); k++) {
        const char *text = config_setting_get_string_elem(setting, k);
        if (!text)
            return config_fail(setting, path, "member %d is not a string", k);
        TRY(text_list_add(list, text));
    }
    return STATUS_OK;
}

static bool is_number(const config_setting_t *setting)
{
    int type = config_setting_type(setting);
    return type == CONFIG_TYPE_INT || type == CONFIG_TYPE_INT64 || type == CONFIG_TYPE_FLOAT;
}

static double number_of(const config_setting_t *setting)
{
    if (config_setting_type(setting) == CONFIG_TYPE_FLOAT)
        return config_setting_get_float(setting);
    return (double)config_setting_get_int64(setting);
}

static bool is_word(const char *text)
{
    return text[0] && strspn(text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_") == strlen(text);
}

static enum status word_check(const config_setting_t *at, const char *where, const char *name)
{
    if (is_word(name))
        return STATUS_OK;
    return config_fail(at, where, "name \"%s\" must be letters, digits, '-' and '_'", name);
}

/* A list of groups below `parent`, or nothing. */
static enum status groups_find(const config_setting_t *parent, const char *name, const char *where,
                               const config_setting_t **list, int *n)
{
    char path[256];
    *list = config_setting_get_member(parent, name);
    *n = *list ? config_setting_length(*list) : 0;
    path_join(path, sizeof path, where, name);
    if (*list && !config_setting_is_list(*list))
        return config_fail(*list, path, "must be a list of groups: %s = ( { ... }, { ... } )", name);
    for (int k = 0; k < *n; k++)
        if (!config_setting_is_group(config_setting_get_elem(*list, (unsigned)k)))
            return config_fail(*list, path, "member %d must be a group: { ... }", k);
    return STATUS_OK;
}

/* `n` zeroed items; no items is not an error. */
static enum status items_make(void **items, int n, size_t size)
{
    *items = calloc((size_t)n + 1, size);
    return *items ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "out of memory");
}

/* What the tables can say of a group: defaults, keys, missing keys. `lists` are read by the caller. */
static enum status group_read(const config_setting_t *setting, const struct key *table, const char *where,
                              const char *const *lists, void *target)
{
    config_defaults(table, target);
    TRY(config_group_read(setting, table, where, lists, target));
    return config_require(setting, table, where);
}

static enum status level_keys_set(struct study_level *level, const struct text_list *keys, double value)
{
    char assignment[512];
    for (int k = 0; k < keys->n; k++) {
        if (snprintf(assignment, sizeof assignment, "%s=%.17g", keys->text[k], value) >= (int)sizeof assignment)
            return status_fail(STATUS_CONFIG, "the key %.60s... is too long", keys->text[k]);
        if (!strpbrk(strchr(assignment, '='), ".en")) /* libconfig's integers are no floats in lists */
            strcat(assignment, ".0");
        TRY(text_list_add(&level->set, assignment));
    }
    return STATUS_OK;
}

static enum status values_read(const config_setting_t *values, const char *where, const struct text_list *keys,
                               struct study_factor *factor)
{
    if (!config_setting_is_list(values) && !config_setting_is_array(values))
        return config_fail(values, where, "values must be a list of numbers: [a, b, ...]");
    factor->n_levels = config_setting_length(values);
    factor->numeric = true;
    TRY(items_make((void **)&factor->level, factor->n_levels, sizeof *factor->level));
    for (int k = 0; k < factor->n_levels; k++) {
        const config_setting_t *member = config_setting_get_elem(values, (unsigned)k);
        struct study_level *level = &factor->level[k];
        if (!is_number(member))
            return config_fail(values, where, "member %d of values is not a number", k);
        level->value = number_of(member);
        snprintf(level->name, sizeof level->name, "%g", level->value);
        TRY(level_keys_set(level, keys, level->value * factor->scale));
    }
    return STATUS_OK;
}

static enum status levels_read(const config_setting_t *list, int n, const char *where, const struct text_list *keys,
                               struct study_factor *factor)
{
    static const char *const own[] = {"set", NULL};
    char path[256];
    factor->n_levels = n;
    factor->numeric = true;
    TRY(items_make((void **)&factor->level, n, sizeof *factor->level));
    for (int k = 0; k < n; k++) {
        const config_setting_t *setting = config_setting_get_elem(list, (unsigned)k);
        struct study_level *level = &factor->level[k];
        snprintf(path, sizeof path, "%.200s.levels.%d", where, k);
        TRY(group_read(setting, level_keys, path, own, level));
        if (isfinite(level->value))
            TRY(level_keys_set(level, keys, level->value * factor->scale));
        else
            factor->numeric = false;
        TRY(strings_read(setting, "set", path, &level->set));
        if (!level->name[0] && isfinite(level->value))
            snprintf(level->name, sizeof level->name, "%g", level->value);
        if (!level->name[0])
            return config_fail(setting, path, "needs a name or a value");
    }
    for (int k = 0; k < n && !factor->numeric; k++)
        factor->level[k].value = isfinite(factor->level[k].value) ? factor->level[k].value : k;
    return STATUS_OK;
}

static enum status factor_read(const config_setting_t *setting, const char *where, struct study_factor *factor)
{
    static const char *const own[] = {"keys", "values", "levels", NULL};
    const config_setting_t *values = config_setting_get_member(setting, "values"), *levels;
    struct text_list keys = {0};
    int n;
    TRY(group_read(setting, factor_keys, where, own, factor));
    TRY(word_check(setting, where, factor->name));
    TRY(groups_find(setting, "levels", where, &levels, &n));
    if (!factor->label[0])
        memcpy(factor->label, factor->name, sizeof factor->label);
    if (!values == !levels)
        return config_fail(setting, where, "needs either values = [ ... ] or levels = ( { ... } )");
    enum status status = strings_read(setting, "keys", where, &keys);
    if (status == STATUS_OK)
        status = values ? values_read(values, where, &keys, factor) : levels_read(levels, n, where, &keys, factor);
    text_list_free(&keys);
    if (status == STATUS_OK && factor->n_levels == 0)
        return config_fail(setting, where, "has no levels");
    return status;
}

static enum status factors_read(const config_setting_t *setting, const char *where, struct study_series *series)
{
    const config_setting_t *list;
    char path[256];
    int n;
    TRY(groups_find(setting, "vary", where, &list, &n));
    if (series->n_factors + n > STUDY_FACTORS_MAX)
        return config_fail(list, where, "varies more than %d keys at once", STUDY_FACTORS_MAX);
    for (int k = 0; k < n; k++) {
        snprintf(path, sizeof path, "%.200s%svary.%d", where, where[0] ? "." : "", k);
        TRY(factor_read(config_setting_get_elem(list, (unsigned)k), path, &series->factor[series->n_factors++]));
    }
    return STATUS_OK;
}

/* A number of seeds, 1 to N, or a list of them. */
static enum status seeds_read(const config_setting_t *seeds, const char *where, struct study_series *series)
{
    enum { MOST = 10000 };
    bool counted = config_setting_type(seeds) == CONFIG_TYPE_INT;
    int n = counted ? config_setting_get_int(seeds) : config_setting_length(seeds);
    if (!counted && !config_setting_is_array(seeds) && !config_setting_is_list(seeds))
        return config_fail(seeds, where, "seeds must be a number, or a list of seeds: [1, 2, 5]");
    if (n < 1 || n > MOST)
        return config_fail(seeds, where, "%d seeds; allowed: 1 to %d", n, MOST);
    free(series->seed);
    series->n_seeds = n;
    TRY(items_make((void **)&series->seed, n, sizeof *series->seed));
    for (int k = 0; k < n; k++) {
        const config_setting_t *member = counted ? NULL : config_setting_get_elem(seeds, (unsigned)k);
        if (member && config_setting_type(member) != CONFIG_TYPE_INT &&
            config_setting_type(member) != CONFIG_TYPE_INT64)
            return config_fail(seeds, where, "member %d of seeds is not a whole number", k);
        series->seed[k] = member ? config_setting_get_int64(member) : k + 1;
        if (series->seed[k] < 0)
            return config_fail(seeds, where, "seeds are at least 0");
    }
    return STATUS_OK;
}

/* What the study says for all series, then what the series says itself. */
static enum status series_read(const config_setting_t *root, const config_setting_t *setting, const char *where,
                               struct study_series *series)
{
    static const char *const own[] = {"set", "vary", "seeds", NULL};
    struct study_series common = {0};
    static const char *const others[] = {"name",  "title",    "score",   "method", "quantities", "set",  "vary",
                                         "seeds", "evaluate", "figures", "paper",  "series",     "sets", NULL};
    const config_setting_t *seeds = config_setting_get_member(root, "seeds");
    config_defaults(series_keys, &common);
    TRY(config_group_read(root, series_keys, "", others, &common));
    *series = common;
    TRY(strings_read(root, "set", "", &series->set));
    TRY(factors_read(root, "", series));
    if (setting) {
        TRY(config_group_read(setting, series_keys, where, own, series));
        TRY(word_check(setting, where, series->name));
        TRY(strings_read(setting, "set", where, &series->set));
        TRY(factors_read(setting, where, series));
        if (config_setting_get_member(setting, "seeds"))
            seeds = config_setting_get_member(setting, "seeds");
    }
    if (!series->scene[0])
        return config_fail(setting ? setting : root, "scene", "missing; the scene file, relative to the study file");
    if (seeds)
        return seeds_read(seeds, where, series);
    series->n_seeds = 1;
    TRY(items_make((void **)&series->seed, 1, sizeof *series->seed));
    series->seed[0] = 1;
    return STATUS_OK;
}

static enum status all_series_read(const config_setting_t *root, struct study *study)
{
    const config_setting_t *list;
    char where[64];
    int n;
    TRY(groups_find(root, "series", "", &list, &n));
    study->n_series = n > 0 ? n : 1;
    TRY(items_make((void **)&study->series, study->n_series, sizeof *study->series));
    if (n == 0)
        return series_read(root, NULL, "", &study->series[0]);
    for (int k = 0; k < n; k++) {
        snprintf(where, sizeof where, "series.%d", k);
        TRY(series_read(root, config_setting_get_elem(list, (unsigned)k), where, &study->series[k]));
        for (int j = 0; j < k; j++)
            if (strcmp(study->series[j].name, study->series[k].name) == 0)
                return config_fail(list, where, "name \"%s\" is taken; series need names that differ",
                                   study->series[k].name);
    }
    return STATUS_OK;
}

static bool level_exists(const struct study *study, const char *factor, const char *level)
{
    for (int s = 0; s < study->n_series; s++) {
        int f = study_factor_find(&study->series[s], factor);
        for (int k = 0; f >= 0 && k < study->series[s].factor[f].n_levels; k++)
            if (strcmp(study->series[s].factor[f].level[k].name, level) == 0)
                return true;
    }
    return false;
}

/* `where = { factor = level; ... }`, levels by name or by number. */
static enum status where_read(const config_setting_t *parent, const char *path, const struct study *study,
                              struct study_where *where)
{
    const config_setting_t *setting = config_setting_get_member(parent, "where");
    if (!setting)
        return STATUS_OK;
    if (!config_setting_is_group(setting) || config_setting_length(setting) > STUDY_FACTORS_MAX)
        return config_fail(setting, path, "where must be a group: where = { factor = level; }");
    where->n = config_setting_length(setting);
    for (int k = 0; k < where->n; k++) {
        const config_setting_t *member = config_setting_get_elem(setting, (unsigned)k);
        const char *text = config_setting_get_string(member);
        snprintf(where->factor[k], sizeof where->factor[k], "%s", config_setting_name(member));
        if (text)
            snprintf(where->level[k], sizeof where->level[k], "%s", text);
        else if (is_number(member))
            snprintf(where->level[k], sizeof where->level[k], "%g", number_of(member));
        if (!level_exists(study, where->factor[k], where->level[k]))
            return config_fail(member, path, "no series varies \"%s\" with a level \"%s\"", where->factor[k],
                               where->level[k]);
    }
    return STATUS_OK;
}

/* Suffixes of the numbers that each kind of evaluation gives (enum evaluation_kind). */
static const char *const evaluation_numbers[][4] = {
    [EVALUATION_DECAY] = {"tau_s"},
    [EVALUATION_SLOPE] = {"slope"},
    [EVALUATION_TANGENT] = {"tan_phi", "friction_angle_deg", "cohesion_pa"},
};

static bool is_number_of(const struct study_evaluation *evaluation, const char *quantity)
{
    size_t length = strlen(evaluation->name);
    const char *const *suffix = evaluation_numbers[evaluation->kind];
    if (strncmp(quantity, evaluation->name, length) != 0 || quantity[length] != '.')
        return false;
    for (int k = 0; k < 4 && suffix[k]; k++)
        if (strcmp(quantity + length + 1, suffix[k]) == 0)
            return true;
    return false;
}

/* Whether a number is one of the study's. Without `quantities` all of analysis.json are, which only runs can tell. */
static enum status quantity_check(const struct study *study, const config_setting_t *at, const char *path,
                                  const char *quantity)
{
    bool known = study->quantities.n == 0;
    for (int k = 0; k < study->quantities.n; k++)
        known = known || strcmp(study->quantities.text[k], quantity) == 0;
    for (int k = 0; k < study->n_evaluations; k++)
        known = known || is_number_of(&study->evaluation[k], quantity);
    if (!known)
        return config_fail(
            at, path, "\"%s\" is neither among the quantities of the study nor a number of an evaluation", quantity);
    return STATUS_OK;
}

static enum status papers_read(const config_setting_t *root, struct study *study)
{
    static const char *const own[] = {"where", NULL};
    const config_setting_t *list;
    char path[64];
    TRY(groups_find(root, "paper", "", &list, &study->n_paper));
    TRY(items_make((void **)&study->paper, study->n_paper, sizeof *study->paper));
    for (int k = 0; k < study->n_paper; k++) {
        const config_setting_t *setting = config_setting_get_elem(list, (unsigned)k);
        snprintf(path, sizeof path, "paper.%d", k);
        TRY(group_read(setting, paper_keys, path, own, &study->paper[k]));
        TRY(where_read(setting, path, study, &study->paper[k].where));
        TRY(quantity_check(study, setting, path, study->paper[k].quantity));
    }
    return STATUS_OK;
}

static enum status series_check(const struct study *study, const config_setting_t *at, const char *path,
                                const char *name)
{
    for (int k = 0; k < study->n_series; k++)
        if (!name[0] || strcmp(study->series[k].name, name) == 0)
            return STATUS_OK;
    return config_fail(at, path, "there is no series \"%s\"", name);
}

static bool factor_exists(const struct study *study, const char *name)
{
    for (int k = 0; k < study->n_series; k++)
        if (study_factor_find(&study->series[k], name) >= 0)
            return true;
    return false;
}

static enum status evaluations_read(const config_setting_t *root, struct study *study)
{
    const config_setting_t *list;
    char path[64];
    TRY(groups_find(root, "evaluate", "", &list, &study->n_evaluations));
    TRY(items_make((void **)&study->evaluation, study->n_evaluations, sizeof *study->evaluation));
    for (int k = 0; k < study->n_evaluations; k++) {
        const config_setting_t *setting = config_setting_get_elem(list, (unsigned)k);
        struct study_evaluation *evaluation = &study->evaluation[k];
        snprintf(path, sizeof path, "evaluate.%d", k);
        TRY(group_read(setting, evaluation_keys, path, NULL, evaluation));
        TRY(word_check(setting, path, evaluation->name));
        TRY(series_check(study, setting, path, evaluation->series));
        if (evaluation->kind == EVALUATION_TANGENT && !factor_exists(study, evaluation->along))
            return config_fail(setting, path, "along = \"%s\" is no factor of the study", evaluation->along);
        if (evaluation->kind == EVALUATION_TANGENT)
            TRY(quantity_check(study, setting, path, evaluation->major));
    }
    return STATUS_OK;
}

static enum status figure_check(const struct study *study, const config_setting_t *at, const char *path,
                                const struct study_figure *figure)
{
    TRY(word_check(at, path, figure->name));
    TRY(series_check(study, at, path, figure->series));
    if (figure->kind != FIGURE_MOHR && (!figure->x[0] || !figure->y[0]))
        return config_fail(at, path, "needs x and y");
    if (figure->kind == FIGURE_POINTS && !factor_exists(study, figure->x))
        return config_fail(at, path, "x = \"%s\" is no factor of the study", figure->x);
    if (figure->kind == FIGURE_POINTS)
        TRY(quantity_check(study, at, path, figure->y));
    if (figure->kind == FIGURE_CURVES && strcmp(figure->table, "curves.csv") != 0 &&
        strcmp(figure->table, "cycles.csv") != 0)
        return config_fail(at, path, "table must be \"curves.csv\" or \"cycles.csv\"");
    for (int k = 0; figure->kind == FIGURE_MOHR && k < study->n_evaluations; k++)
        if (study->evaluation[k].kind == EVALUATION_TANGENT &&
            strcmp(study->evaluation[k].name, figure->evaluation) == 0)
            return STATUS_OK;
    if (figure->kind == FIGURE_MOHR)
        return config_fail(at, path, "evaluation = \"%s\" is no tangent of the study", figure->evaluation);
    return STATUS_OK;
}

static enum status figures_read(const config_setting_t *root, struct study *study)
{
    static const char *const own[] = {"where", NULL};
    const config_setting_t *list;
    char path[64];
    TRY(groups_find(root, "figures", "", &list, &study->n_figures));
    TRY(items_make((void **)&study->figure, study->n_figures, sizeof *study->figure));
    for (int k = 0; k < study->n_figures; k++) {
        const config_setting_t *setting = config_setting_get_elem(list, (unsigned)k);
        snprintf(path, sizeof path, "figures.%d", k);
        TRY(group_read(setting, figure_keys, path, own, &study->figure[k]));
        TRY(where_read(setting, path, study, &study->figure[k].where));
        TRY(figure_check(study, setting, path, &study->figure[k]));
        for (int j = 0; j < k; j++)
            if (strcmp(study->figure[j].name, study->figure[k].name) == 0)
                return config_fail(setting, path, "name \"%s\" is taken", study->figure[k].name);
    }
    return STATUS_OK;
}

static enum status study_read(const config_setting_t *root, struct study *study)
{
    static const char *const own[] = {"method",  "quantities", "set",    "vary",  "seeds",   "evaluate",
                                      "figures", "paper",      "series", "scene", "prepare", NULL};
    TRY(group_read(root, study_keys, "", own, study));
    TRY(word_check(root, "name", study->name));
    TRY(strings_read(root, "method", "", &study->method));
    TRY(strings_read(root, "quantities", "", &study->quantities));
    TRY(all_series_read(root, study));
    TRY(evaluations_read(root, study));
    TRY(papers_read(root, study));
    TRY(figures_read(root, study));
    if (study->score[0] && !factor_exists(study, study->score))
        return config_fail(root, "score", "\"%s\" is no factor of the study", study->score);
    return STATUS_OK;
}

/* Assignments for the scenes come last, so that they win. */
static enum status scene_assignments_add(struct study *study, const char *const *set, int n_set)
{
    for (int k = 0; k < n_set; k++) {
        if (strncmp(set[k], "study.", 6) == 0)
            continue;
        for (int s = 0; s < study->n_series; s++)
            TRY(text_list_add(&study->series[s].set, set[k]));
    }
    return STATUS_OK;
}

static enum status parse(struct study *study, config_t *config, const char *const *set, int n_set)
{
    char *checked; /* no includes, and no numbers that libconfig would change; arrays of integers stay what they are */
    TRY(config_literals(study->text, study->path, &checked));
    free(checked);
    if (config_read_string(config, study->text) != CONFIG_TRUE)
        return status_fail(STATUS_CONFIG, "%s:%d: %s", study->path, config_error_line(config),
                           config_error_text(config));
    for (int k = 0; k < n_set; k++)
        if (strncmp(set[k], "study.", 6) == 0)
            TRY(config_override(config, set[k] + 6));
    config_source_name(study->path);
    TRY(study_read(config_root_setting(config), study));
    return scene_assignments_add(study, set, n_set);
}

enum status study_load(struct study *study, const char *path, const char *const *set, int n_set)
{
    config_t config;
    char copy[STUDY_PATH_MAX];
    memset(study, 0, sizeof *study);
    if (strlen(path) >= sizeof study->path)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", path);
    snprintf(study->path, sizeof study->path, "%s", path);
    snprintf(copy, sizeof copy, "%s", path);
    snprintf(study->folder, sizeof study->folder, "%s", dirname(copy));
    TRY(files_read(path, &study->text));
    config_init(&config);
    enum status status = parse(study, &config, set, n_set);
    config_destroy(&config);
    if (status != STATUS_OK)
        study_free(study);
    return status;
}

static void series_free(struct study_series *series)
{
    for (int f = 0; f < series->n_factors; f++) {
        for (int k = 0; series->factor[f].level && k < series->factor[f].n_levels; k++)
            text_list_free(&series->factor[f].level[k].set);
        free(series->factor[f].level);
    }
    text_list_free(&series->set);
    free(series->seed);
}

void study_free(struct study *study)
{
    for (int k = 0; study->series && k < study->n_series; k++)
        series_free(&study->series[k]);
    text_list_free(&study->method);
    text_list_free(&study->quantities);
    free(study->series);
    free(study->paper);
    free(study->evaluation);
    free(study->figure);
    free(study->text);
    memset(study, 0, sizeof *study);
}

void study_print_reference(FILE *out)
{
    static const struct {
        const char *path;
        const struct key *table;
    } part[] = {
        {"", study_keys},      {"series", series_keys},       {"vary", factor_keys},   {"vary.levels", level_keys},
        {"paper", paper_keys}, {"evaluate", evaluation_keys}, {"figures", figure_keys}};
    for (size_t k = 0; k < sizeof part / sizeof *part; k++)
        config_print_reference(out, part[k].table, part[k].path);
}
