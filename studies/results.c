#include "studies/results.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "studies/files.h"
#include "studies/table.h"

static enum status no_memory(void)
{
    return status_fail(STATUS_NO_MEMORY, "out of memory");
}

struct spread spread_of(const double *value, int n)
{
    struct spread spread = {NAN, NAN, 0};
    double sum = 0, squares = 0;
    for (int k = 0; k < n; k++)
        if (isfinite(value[k])) {
            sum += value[k];
            spread.n++;
        }
    if (spread.n == 0)
        return spread;
    spread.mean = sum / spread.n;
    for (int k = 0; k < n; k++)
        if (isfinite(value[k]))
            squares += (value[k] - spread.mean) * (value[k] - spread.mean);
    if (spread.n > 1)
        spread.sd = sqrt(squares / (spread.n - 1));
    return spread;
}

double spread_error(const struct spread *spread)
{
    return spread->n > 1 ? spread->sd / sqrt(spread->n) : NAN;
}

int results_key_find(const struct results *results, const char *key)
{
    for (int k = 0; k < results->key.n; k++)
        if (strcmp(results->key.text[k], key) == 0)
            return k;
    return -1;
}

/* --- Single runs ------------------------------------------------------------------------------------------------- */

/* The member at a dotted path, or NULL. */
static const json_t *member_find(const json_t *root, const char *path)
{
    char part[CONFIG_STRING_MAX];
    while (root) {
        size_t length = strcspn(path, ".");
        if (length >= sizeof part)
            return NULL;
        memcpy(part, path, length);
        part[length] = '\0';
        root = json_object_get(root, part);
        if (!path[length])
            return root;
        path += length + 1;
    }
    return NULL;
}

static double json_double(const json_t *value)
{
    return json_is_number(value) ? json_number_value(value) : NAN;
}

static struct number quantity_of(const json_t *analysis, const char *key)
{
    const json_t *member = member_find(analysis, key);
    if (json_is_object(member))
        return (struct number){json_double(json_object_get(member, "value")),
                               json_double(json_object_get(member, "uncertainty"))};
    return (struct number){json_double(member), NAN};
}

/* All quantities that an analysis has, for studies that name none. */
static enum status keys_collect(const json_t *object, const char *path, struct text_list *keys)
{
    const char *name;
    json_t *member;
    json_object_foreach((json_t *)object, name, member)
    {
        char joined[CONFIG_STRING_MAX];
        if (!json_is_object(member) ||
            snprintf(joined, sizeof joined, "%s%s%s", path, path[0] ? "." : "", name) >= (int)sizeof joined)
            continue;
        if (json_object_get(member, "value"))
            TRY(text_list_add(keys, joined));
        else
            TRY(keys_collect(member, joined, keys));
    }
    return STATUS_OK;
}

static enum status analyses_read(struct results *results, const struct outcome *outcome, const char *out)
{
    for (int k = 0; k < results->plan->n_runs; k++) {
        char path[4200];
        json_error_t error;
        if (!outcome[k].done)
            continue;
        if (snprintf(path, sizeof path, "%s/runs/%s/analysis.json", out, results->plan->run[k].name) >=
            (int)sizeof path)
            return status_fail(STATUS_USAGE, "%.60s...: the path is too long", out);
        results->analysis[k] = json_load_file(path, 0, &error);
        if (!results->analysis[k])
            return status_fail(STATUS_FORMAT, "%s: %s", path, error.text);
    }
    return STATUS_OK;
}

/* Key of an evaluation of single runs; false if it is of another kind. */
static bool run_key(const struct study_evaluation *evaluation, char *key, size_t size)
{
    if (evaluation->kind == EVALUATION_TANGENT)
        return false;
    snprintf(key, size, "%s.%s", evaluation->name, evaluation->kind == EVALUATION_DECAY ? "tau_s" : "slope");
    return true;
}

static enum status keys_make(struct results *results)
{
    const struct study *study = results->study;
    char key[2 * CONFIG_STRING_MAX];
    for (int k = 0; k < study->quantities.n; k++)
        TRY(text_list_add(&results->key, study->quantities.text[k]));
    for (int k = 0; study->quantities.n == 0 && results->key.n == 0 && k < results->plan->n_runs; k++)
        if (results->analysis[k])
            TRY(keys_collect(results->analysis[k], "", &results->key));
    for (int k = 0; k < study->n_evaluations; k++)
        if (run_key(&study->evaluation[k], key, sizeof key))
            TRY(text_list_add(&results->key, key));
    return STATUS_OK;
}

static enum status units_make(struct results *results)
{
    for (int k = 0; k < results->key.n; k++) {
        const char *unit = NULL;
        for (int r = 0; !unit && r < results->plan->n_runs; r++)
            unit = json_string_value(json_object_get(member_find(results->analysis[r], results->key.text[k]), "unit"));
        if (!unit && strstr(results->key.text[k], ".tau_s"))
            unit = "s";
        TRY(text_list_add(&results->unit, unit && strcmp(unit, "1") != 0 ? unit : ""));
    }
    return STATUS_OK;
}

/* The rows of an increasing column that lie in a window; `to` 0: to the end. */
static void window_find(const double *x, int rows, double from, double to, int *first, int *end)
{
    *first = 0;
    *end = rows;
    while (*first < *end && x[*first] < from)
        (*first)++;
    while (to > 0 && *end > *first && x[*end - 1] > to)
        (*end)--;
}

static enum status run_evaluate(const struct study_evaluation *evaluation, const char *folder, struct number *number)
{
    bool decay = evaluation->kind == EVALUATION_DECAY;
    struct table table;
    const double *x, *y;
    char path[4400];
    int first, end;
    TRY(files_join(path, sizeof path, folder, "curves.csv"));
    TRY(table_read(&table, path));
    enum status status = table_column(&table, decay ? "stage_time_s" : evaluation->x, &x);
    if (status == STATUS_OK)
        status = table_column(&table, evaluation->column, &y);
    if (status == STATUS_OK) {
        window_find(x, table.rows, decay ? evaluation->from_s : evaluation->from,
                    decay ? evaluation->to_s : evaluation->to, &first, &end);
        *number = decay ? decay_fit(x + first, y + first, end - first, evaluation->target)
                        : slope_fit(x + first, y + first, end - first);
    }
    table_free(&table);
    return status;
}

static enum status run_evaluations(struct results *results, const char *out, int run)
{
    const struct study *study = results->study;
    char folder[4200], key[2 * CONFIG_STRING_MAX];
    snprintf(folder, sizeof folder, "%s/runs/%s", out, results->plan->run[run].name);
    for (int k = 0; k < study->n_evaluations; k++) {
        const struct study_evaluation *evaluation = &study->evaluation[k];
        const char *series = study->series[results->plan->run[run].series].name;
        if (!run_key(evaluation, key, sizeof key) || (evaluation->series[0] && strcmp(evaluation->series, series) != 0))
            continue;
        TRY(run_evaluate(evaluation, folder, &results->number[run * results->key.n + results_key_find(results, key)]));
    }
    return STATUS_OK;
}

static enum status numbers_make(struct results *results, const char *out)
{
    int keys = results->key.n;
    results->number = calloc((size_t)(results->plan->n_runs * keys) + 1, sizeof *results->number);
    if (!results->number)
        return no_memory();
    for (int r = 0; r < results->plan->n_runs; r++) {
        for (int k = 0; k < keys; k++)
            results->number[r * keys + k] = quantity_of(results->analysis[r], results->key.text[k]);
        if (results->analysis[r])
            TRY(run_evaluations(results, out, r));
    }
    return STATUS_OK;
}

/* --- Cells ------------------------------------------------------------------------------------------------------- */

static bool same_cell(const struct cell *cell, const struct plan_run *run, int n_factors)
{
    return cell->series == run->series && memcmp(cell->level, run->level, (size_t)n_factors * sizeof *run->level) == 0;
}

static enum status cell_fill(struct results *results, struct cell *cell)
{
    const struct plan *plan = results->plan;
    int n_factors = results->study->series[cell->series].n_factors;
    cell->run = calloc((size_t)plan->n_runs, sizeof *cell->run);
    cell->spread = calloc((size_t)results->key.n + 1, sizeof *cell->spread);
    double *value = calloc((size_t)plan->n_runs, sizeof *value);
    if (!cell->run || !cell->spread || !value) {
        free(value);
        return no_memory();
    }
    for (int r = 0; r < plan->n_runs; r++)
        if (results->analysis[r] && same_cell(cell, &plan->run[r], n_factors))
            cell->run[cell->n_runs++] = r;
    for (int a = 1; a < cell->n_runs; a++) /* by seed, whatever the order of starting */
        for (int b = a; b > 0 && plan->run[cell->run[b - 1]].seed > plan->run[cell->run[b]].seed; b--) {
            int other = cell->run[b];
            cell->run[b] = cell->run[b - 1];
            cell->run[b - 1] = other;
        }
    for (int k = 0; k < results->key.n; k++) {
        for (int j = 0; j < cell->n_runs; j++)
            value[j] = results->number[cell->run[j] * results->key.n + k].value;
        cell->spread[k] = spread_of(value, cell->n_runs);
    }
    free(value);
    return STATUS_OK;
}

static enum status cells_make(struct results *results)
{
    const struct study *study = results->study;
    int most = 0;
    for (int s = 0; s < study->n_series; s++) {
        int n = 1;
        for (int f = 0; f < study->series[s].n_factors; f++)
            n *= study->series[s].factor[f].n_levels;
        most += n;
    }
    results->cell = calloc((size_t)most + 1, sizeof *results->cell);
    if (!results->cell)
        return no_memory();
    for (int s = 0; s < study->n_series; s++) {
        const struct study_series *series = &study->series[s];
        int n = 1;
        for (int f = 0; f < series->n_factors; f++)
            n *= series->factor[f].n_levels;
        for (int c = 0; c < n; c++) {
            struct cell *cell = &results->cell[results->n_cells++];
            int rest = c;
            cell->series = s;
            for (int f = series->n_factors - 1; f >= 0; f--) {
                cell->level[f] = rest % series->factor[f].n_levels;
                rest /= series->factor[f].n_levels;
            }
            TRY(cell_fill(results, cell));
        }
    }
    return STATUS_OK;
}

void cell_text(const struct study *study, const struct cell *cell, const char *without, const char *nor, char *text,
               size_t size)
{
    const struct study_series *series = &study->series[cell->series];
    size_t used = 0;
    text[0] = '\0';
    if (study->n_series > 1)
        used = (size_t)snprintf(text, size, "%s", series->name);
    for (int f = 0; f < series->n_factors && used < size; f++) {
        const struct study_factor *factor = &series->factor[f];
        if ((without && strcmp(factor->name, without) == 0) || (nor && strcmp(factor->name, nor) == 0))
            continue;
        used += (size_t)snprintf(text + used, size - used, "%s%s = %s%s%s", used ? ", " : "", factor->label,
                                 factor->level[cell->level[f]].name, factor->unit[0] ? " " : "", factor->unit);
    }
    if (!text[0])
        snprintf(text, size, "all runs");
}

/* --- Tangents ---------------------------------------------------------------------------------------------------- */

const char *tangent_unit(enum tangent_key key)
{
    return key == TANGENT_FRICTION_ANGLE ? "deg" : key == TANGENT_COHESION ? "Pa" : "";
}

void tangent_key_text(const struct study *study, const struct tangent *tangent, enum tangent_key key, char *text,
                      size_t size)
{
    static const char *const name[] = {"tan_phi", "friction_angle_deg", "cohesion_pa"};
    snprintf(text, size, "%s.%s", study->evaluation[tangent->evaluation].name, name[key]);
}

void tangent_fit(const double *sigma_3, const double *sigma_1, int n, double number[TANGENT_KEYS])
{
    double x = 0, y = 0, xx = 0, xy = 0;
    int count = 0;
    for (int k = 0; k < TANGENT_KEYS; k++)
        number[k] = NAN;
    for (int k = 0; k < n; k++)
        if (isfinite(sigma_1[k])) {
            x += sigma_3[k];
            y += sigma_1[k];
            count++;
        }
    if (count < 2)
        return;
    x /= count;
    y /= count;
    for (int k = 0; k < n; k++)
        if (isfinite(sigma_1[k])) {
            xx += (sigma_3[k] - x) * (sigma_3[k] - x);
            xy += (sigma_3[k] - x) * (sigma_1[k] - y);
        }
    double b = xy / xx, sine = (b - 1) / (b + 1), a = y - b * x;
    if (!(fabs(sine) < 1)) /* of equal stresses, or falling */
        return;
    number[TANGENT_TAN_PHI] = sine / sqrt(1 - sine * sine);
    number[TANGENT_FRICTION_ANGLE] = asin(sine) * 180 / M_PI;
    number[TANGENT_COHESION] = a * (1 - sine) / (2 * sqrt(1 - sine * sine));
}

/* The number of that seed in a cell; NaN if the run is missing. */
static double seed_value(const struct results *results, const struct cell *cell, int key, int64_t seed)
{
    for (int k = 0; k < cell->n_runs; k++)
        if (results->plan->run[cell->run[k]].seed == seed)
            return results->number[cell->run[k] * results->key.n + key].value;
    return NAN;
}

static enum status tangent_evaluate(const struct results *results, struct tangent *tangent, int factor, int key)
{
    const struct study_series *series = &results->study->series[results->cell[tangent->cell].series];
    double *fitted = calloc((size_t)series->n_seeds * TANGENT_KEYS, sizeof *fitted);
    double *stress = calloc((size_t)tangent->n_circles * 2, sizeof *stress);
    if (!fitted || !stress) {
        free(fitted);
        free(stress);
        return no_memory();
    }
    for (int s = 0; s < series->n_seeds; s++) {
        double number[TANGENT_KEYS];
        for (int k = 0; k < tangent->n_circles; k++) {
            const struct cell *cell = &results->cell[tangent->circle[k]];
            stress[k] = series->factor[factor].level[cell->level[factor]].value * series->factor[factor].scale;
            stress[tangent->n_circles + k] = seed_value(results, cell, key, series->seed[s]);
        }
        tangent_fit(stress, stress + tangent->n_circles, tangent->n_circles, number);
        for (int k = 0; k < TANGENT_KEYS; k++)
            fitted[k * series->n_seeds + s] = number[k];
    }
    for (int k = 0; k < TANGENT_KEYS; k++)
        tangent->spread[k] = spread_of(fitted + k * series->n_seeds, series->n_seeds);
    free(fitted);
    free(stress);
    return STATUS_OK;
}

static bool differ_along(const struct results *results, const struct cell *a, const struct cell *b, int factor)
{
    if (a->series != b->series)
        return false;
    for (int f = 0; f < results->study->series[a->series].n_factors; f++)
        if (f != factor && a->level[f] != b->level[f])
            return false;
    return true;
}

static enum status tangents_of(struct results *results, int evaluation)
{
    const struct study *study = results->study;
    const struct study_evaluation *e = &study->evaluation[evaluation];
    int key = results_key_find(results, e->major);
    if (key < 0)
        return status_fail(STATUS_CONFIG, "%s: evaluate %s: %s is not among the quantities", study->path, e->name,
                           e->major);
    for (int c = 0; c < results->n_cells; c++) {
        const struct cell *cell = &results->cell[c];
        int factor = study_factor_find(&study->series[cell->series], e->along);
        if (factor < 0 || cell->level[factor] != 0 ||
            (e->series[0] && strcmp(e->series, study->series[cell->series].name) != 0))
            continue;
        struct tangent *tangent = &results->tangent[results->n_tangents++];
        *tangent = (struct tangent){.evaluation = evaluation, .cell = c};
        tangent->circle = calloc((size_t)results->n_cells, sizeof *tangent->circle);
        if (!tangent->circle)
            return no_memory();
        for (int k = c; k < results->n_cells; k++)
            if (differ_along(results, cell, &results->cell[k], factor))
                tangent->circle[tangent->n_circles++] = k;
        TRY(tangent_evaluate(results, tangent, factor, key));
    }
    return STATUS_OK;
}

static enum status tangents_make(struct results *results)
{
    const struct study *study = results->study;
    results->tangent = calloc((size_t)results->n_cells * (size_t)study->n_evaluations + 1, sizeof *results->tangent);
    if (!results->tangent)
        return no_memory();
    for (int k = 0; k < study->n_evaluations; k++)
        if (study->evaluation[k].kind == EVALUATION_TANGENT)
            TRY(tangents_of(results, k));
    return STATUS_OK;
}

/* --- Decay ------------------------------------------------------------------------------------------------------- */

struct number slope_fit(const double *x, const double *y, int n)
{
    if (n < 3)
        return (struct number){NAN, NAN};
    double mx = 0, my = 0, xx = 0, xy = 0, rest = 0;
    for (int k = 0; k < n; k++) {
        mx += x[k] / n;
        my += y[k] / n;
    }
    for (int k = 0; k < n; k++) {
        xx += (x[k] - mx) * (x[k] - mx);
        xy += (x[k] - mx) * (y[k] - my);
    }
    double slope = xy / xx;
    for (int k = 0; k < n; k++) {
        double off = y[k] - my - slope * (x[k] - mx);
        rest += off * off;
    }
    return (struct number){slope, sqrt(rest / (n - 2) / xx)};
}

/* Largest distances from the target between crossings, as logarithms; how many. */
static int swings_find(const double *time_s, const double *value, int n, double target, double *time, double *log_size,
                       int most)
{
    static const double noise = 1e-2; /* of the largest swing: below it other motions are seen */
    double largest = 0;
    int swings = 0;
    for (int k = 0; k < n && swings < most;) {
        bool above = value[k] > target;
        int top = k;
        for (; k < n && (value[k] > target) == above; k++)
            if (fabs(value[k] - target) > fabs(value[top] - target))
                top = k;
        double size = fabs(value[top] - target);
        largest = fmax(largest, size);
        if (k == n || !(size > noise * largest)) /* the last is cut off */
            break;
        time[swings] = time_s[top];
        log_size[swings++] = log(size);
    }
    return swings;
}

/* The same of every sample from the largest distance to the first below a fiftieth of it. */
static int approach_find(const double *time_s, const double *value, int n, double target, double *time,
                         double *log_size)
{
    int top = 0, found = 0;
    for (int k = 1; k < n; k++)
        if (fabs(value[k] - target) > fabs(value[top] - target))
            top = k;
    for (int k = top; k < n && fabs(value[k] - target) > 0.02 * fabs(value[top] - target); k++) {
        time[found] = time_s[k];
        log_size[found++] = log(fabs(value[k] - target));
    }
    return found;
}

struct number decay_fit(const double *time_s, const double *value, int n, double target)
{
    enum { SWINGS_MIN = 4, SAMPLES_MIN = 5 };
    struct number none = {NAN, NAN};
    double *time = malloc((size_t)n * 2 * sizeof *time + 1), *log_size = time + n;
    if (!time || n < SAMPLES_MIN) {
        free(time);
        return none;
    }
    if (!isfinite(target))
        target = value[n - 1];
    int found = swings_find(time_s, value, n, target, time, log_size, n);
    if (found < SWINGS_MIN)
        found = approach_find(time_s, value, n, target, time, log_size);
    struct number slope = found < SWINGS_MIN ? none : slope_fit(time, log_size, found);
    free(time);
    if (!(slope.value < 0))
        return none;
    return (struct number){-1 / slope.value, slope.uncertainty / (slope.value * slope.value)};
}

/* --- Beside the paper -------------------------------------------------------------------------------------------- */

static bool cell_meets(const struct study *study, const struct cell *cell, const struct study_where *where)
{
    struct plan_run run = {.series = cell->series};
    memcpy(run.level, cell->level, sizeof run.level);
    return plan_run_meets(study, &run, where);
}

static bool series_is(const struct study *study, int series, const char *name)
{
    return !name[0] || strcmp(study->series[series].name, name) == 0;
}

static bool level_is(const struct study *study, const struct cell *cell, const char *factor, int level)
{
    int f = study_factor_find(&study->series[cell->series], factor);
    return level < 0 || (f >= 0 && cell->level[f] == level);
}

/* Ours for a published number: the first cell, or tangent, that meets its condition, at `level` of the ranked factor
 * (-1: any). */
static bool ours_find(const struct results *results, const struct study_paper *paper, int level, struct spread *ours)
{
    const struct study *study = results->study;
    int key = results_key_find(results, paper->quantity);
    for (int c = 0; key >= 0 && c < results->n_cells; c++) {
        const struct cell *cell = &results->cell[c];
        if (series_is(study, cell->series, paper->series) && cell_meets(study, cell, &paper->where) &&
            level_is(study, cell, study->score, level)) {
            *ours = cell->spread[key];
            return true;
        }
    }
    for (int t = 0; t < results->n_tangents; t++) {
        const struct tangent *tangent = &results->tangent[t];
        const struct cell *cell = &results->cell[tangent->cell];
        char text[2 * CONFIG_STRING_MAX];
        for (int k = 0; k < TANGENT_KEYS; k++) {
            tangent_key_text(study, tangent, (enum tangent_key)k, text, sizeof text);
            if (strcmp(text, paper->quantity) != 0 || !series_is(study, cell->series, paper->series) ||
                !cell_meets(study, cell, &paper->where) || !level_is(study, cell, study->score, level))
                continue;
            *ours = tangent->spread[k];
            return true;
        }
    }
    return false;
}

const struct study_factor *results_ranked(const struct study *study)
{
    for (int s = 0; study->score[0] && s < study->n_series; s++) {
        int f = study_factor_find(&study->series[s], study->score);
        if (f >= 0)
            return &study->series[s].factor[f];
    }
    return NULL;
}

static double score_of(const struct results *results, int level)
{
    const struct study *study = results->study;
    double sum = 0;
    int n = 0;
    for (int k = 0; k < study->n_paper; k++) {
        const struct study_paper *paper = &study->paper[k];
        double tolerance = paper->tolerance > 0 ? paper->tolerance : 0.1 * fabs(paper->value);
        struct spread *ours = &results->scored[level * study->n_paper + k];
        *ours = (struct spread){NAN, NAN, 0};
        if (!ours_find(results, paper, level, ours) || ours->n == 0)
            continue;
        sum += (ours->mean - paper->value) * (ours->mean - paper->value) / (tolerance * tolerance);
        n++;
    }
    return n > 0 ? sqrt(sum / n) : NAN;
}

static enum status comparisons_make(struct results *results)
{
    const struct study *study = results->study;
    const struct study_factor *ranked = results_ranked(study);
    results->comparison = calloc((size_t)study->n_paper + 1, sizeof *results->comparison);
    results->n_scores = ranked ? ranked->n_levels : 0;
    results->score = calloc((size_t)results->n_scores + 1, sizeof *results->score);
    results->scored = calloc((size_t)results->n_scores * (size_t)study->n_paper + 1, sizeof *results->scored);
    if (!results->comparison || !results->score || !results->scored)
        return no_memory();
    for (int k = 0; k < study->n_paper; k++) {
        struct comparison *comparison = &results->comparison[k];
        comparison->paper = k;
        comparison->found = ours_find(results, &study->paper[k], -1, &comparison->ours);
    }
    for (int k = 0; k < results->n_scores; k++)
        results->score[k] = score_of(results, k);
    return STATUS_OK;
}

/* ----------------------------------------------------------------------------------------------------------------- */

static enum status make(struct results *results, const struct outcome *outcome, const char *out)
{
    results->analysis = calloc((size_t)results->plan->n_runs + 1, sizeof *results->analysis);
    if (!results->analysis)
        return no_memory();
    TRY(analyses_read(results, outcome, out));
    TRY(keys_make(results));
    TRY(units_make(results));
    TRY(numbers_make(results, out));
    TRY(cells_make(results));
    TRY(tangents_make(results));
    return comparisons_make(results);
}

enum status results_make(struct results *results, const struct study *study, const struct plan *plan,
                         const struct outcome *outcome, const char *out)
{
    *results = (struct results){.study = study, .plan = plan};
    enum status status = make(results, outcome, out);
    if (status != STATUS_OK)
        results_free(results);
    return status;
}

void results_free(struct results *results)
{
    for (int k = 0; results->analysis && k < results->plan->n_runs; k++)
        json_decref(results->analysis[k]);
    for (int k = 0; k < results->n_cells; k++) {
        free(results->cell[k].run);
        free(results->cell[k].spread);
    }
    for (int k = 0; k < results->n_tangents; k++)
        free(results->tangent[k].circle);
    text_list_free(&results->key);
    text_list_free(&results->unit);
    free(results->analysis);
    free(results->number);
    free(results->cell);
    free(results->tangent);
    free(results->comparison);
    free(results->score);
    free(results->scored);
    *results = (struct results){0};
}
