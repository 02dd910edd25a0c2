#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "studies/figure.h"
#include "studies/files.h"
#include "studies/table.h"

enum { GRID = 241, CIRCLE = 91 };

static enum status no_memory(void)
{
    return status_fail(STATUS_NO_MEMORY, "out of memory");
}

static enum status line_add(struct figure_lines *lines, int style, int colour, int n, struct figure_line **added)
{
    struct figure_line *larger = realloc(lines->line, ((size_t)lines->n + 1) * sizeof *larger);
    if (!larger)
        return no_memory();
    lines->line = larger;
    struct figure_line *line = &lines->line[lines->n++];
    size_t size = (size_t)(n > 0 ? n : 1) * sizeof(double);
    *line = (struct figure_line){.style = style, .colour = colour, .n = n};
    line->x = malloc(size);
    line->y = malloc(size);
    line->error = malloc(size);
    if (!line->x || !line->y || !line->error)
        return no_memory();
    *added = line;
    return STATUS_OK;
}

void figure_lines_free(struct figure_lines *lines)
{
    for (int k = 0; k < lines->n; k++) {
        free(lines->line[k].x);
        free(lines->line[k].y);
        free(lines->line[k].error);
    }
    free(lines->line);
    *lines = (struct figure_lines){0};
}

static bool cell_is_drawn(const struct study *study, const struct study_figure *figure, const struct cell *cell)
{
    struct plan_run run = {.series = cell->series};
    memcpy(run.level, cell->level, sizeof run.level);
    return cell->n_runs > 0 && plan_run_meets(study, &run, &figure->where) &&
           (!figure->series[0] || strcmp(figure->series, study->series[cell->series].name) == 0);
}

/* --- Curves ------------------------------------------------------------------------------------------------------ */

struct curve {
    double *x, *y; /* [n] */
    int n;
};

static bool in_window(const struct study_figure *figure, double x)
{
    return (figure->x_min == 0 && figure->x_max == 0) || (x >= figure->x_min && x <= figure->x_max);
}

/* Columns of one run; where curves are averaged only rows that reach a new largest x. */
static enum status curve_read(const struct results *results, const struct study_figure *figure, const char *out,
                              int run, struct curve *curve)
{
    struct table table;
    const double *x, *y;
    char path[4400];
    if (snprintf(path, sizeof path, "%s/runs/%s/%s", out, results->plan->run[run].name, figure->table) >=
        (int)sizeof path)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", out);
    TRY(table_read(&table, path));
    *curve = (struct curve){malloc((size_t)table.rows * sizeof(double) + 1),
                            malloc((size_t)table.rows * sizeof(double) + 1), 0};
    enum status status = curve->x && curve->y ? table_column(&table, figure->x, &x) : no_memory();
    if (status == STATUS_OK)
        status = table_column(&table, figure->y, &y);
    for (int k = 0; status == STATUS_OK && k < table.rows; k++) {
        bool further = curve->n == 0 || x[k] > curve->x[curve->n - 1];
        if (!isfinite(x[k]) || !isfinite(y[k]) || !in_window(figure, x[k]) || (figure->mean && !further))
            continue;
        curve->x[curve->n] = x[k];
        curve->y[curve->n++] = y[k];
    }
    table_free(&table);
    return status;
}

static void curves_free(struct curve *curve, int n)
{
    for (int k = 0; curve && k < n; k++) {
        free(curve[k].x);
        free(curve[k].y);
    }
    free(curve);
}

static double curve_at(const struct curve *curve, double x)
{
    int low = 0, high = curve->n - 1;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        *(curve->x[middle] <= x ? &low : &high) = middle;
    }
    double width = curve->x[high] - curve->x[low];
    return width > 0 ? curve->y[low] + (curve->y[high] - curve->y[low]) * (x - curve->x[low]) / width : curve->y[low];
}

/* The x that all curves have in common. */
static bool common_range(const struct curve *curve, int n, double *from, double *to)
{
    *from = -INFINITY;
    *to = INFINITY;
    for (int k = 0; k < n; k++) {
        if (curve[k].n < 2)
            return false;
        *from = fmax(*from, curve[k].x[0]);
        *to = fmin(*to, curve[k].x[curve[k].n - 1]);
    }
    return n > 0 && *to > *from;
}

static enum status mean_line(struct figure_lines *lines, const struct study_figure *figure, const struct curve *curve,
                             int n, int colour, struct figure_line **line)
{
    double from, to, *value = malloc((size_t)n * sizeof *value);
    bool logarithmic = figure->x_log, drawn = common_range(curve, n, &from, &to) && (!logarithmic || from > 0);
    enum status status = value ? line_add(lines, LINE_BAND, colour, drawn ? GRID : 0, line) : no_memory();
    for (int k = 0; status == STATUS_OK && k < (*line)->n; k++) {
        double part = (double)k / (GRID - 1), x = logarithmic ? from * pow(to / from, part) : from + part * (to - from);
        for (int j = 0; j < n; j++)
            value[j] = curve_at(&curve[j], x);
        struct spread spread = spread_of(value, n);
        (*line)->x[k] = x * figure->x_scale;
        (*line)->y[k] = spread.mean * figure->y_scale;
        (*line)->error[k] = spread.sd * fabs(figure->y_scale);
    }
    free(value);
    return status;
}

static enum status plain_line(struct figure_lines *lines, const struct study_figure *figure, const struct curve *curve,
                              int colour, struct figure_line **line)
{
    TRY(line_add(lines, LINE_PLAIN, colour, curve->n, line));
    for (int k = 0; k < curve->n; k++) {
        (*line)->x[k] = curve->x[k] * figure->x_scale;
        (*line)->y[k] = curve->y[k] * figure->y_scale;
        (*line)->error[k] = NAN;
    }
    return STATUS_OK;
}

static enum status curves_make(struct figure_lines *lines, const struct results *results,
                               const struct study_figure *figure, const char *out)
{
    int colour = 0;
    for (int c = 0; c < results->n_cells; c++) {
        const struct cell *cell = &results->cell[c];
        struct figure_line *line = NULL;
        if (!cell_is_drawn(results->study, figure, cell))
            continue;
        int n = figure->mean ? cell->n_runs : 1;
        struct curve *curve = calloc((size_t)n, sizeof *curve);
        enum status status = curve ? STATUS_OK : no_memory();
        for (int k = 0; status == STATUS_OK && k < n; k++)
            status = curve_read(results, figure, out, cell->run[k], &curve[k]);
        if (status == STATUS_OK)
            status = figure->mean ? mean_line(lines, figure, curve, n, colour, &line)
                                  : plain_line(lines, figure, curve, colour, &line);
        curves_free(curve, n);
        TRY(status);
        cell_text(results->study, cell, NULL, NULL, line->label, sizeof line->label);
        colour++;
    }
    return STATUS_OK;
}

/* --- Points ------------------------------------------------------------------------------------------------------ */

/* Cells of one line: those that differ in the factor of the abscissa alone. */
static bool same_line(const struct study *study, const struct cell *a, const struct cell *b, int factor)
{
    if (a->series != b->series)
        return false;
    for (int f = 0; f < study->series[a->series].n_factors; f++)
        if (f != factor && a->level[f] != b->level[f])
            return false;
    return true;
}

static const struct study_paper *paper_at(const struct results *results, const struct study_figure *figure,
                                          const struct cell *cell)
{
    const struct study *study = results->study;
    struct plan_run run = {.series = cell->series};
    memcpy(run.level, cell->level, sizeof run.level);
    for (int k = 0; k < study->n_paper; k++) {
        const struct study_paper *paper = &study->paper[k];
        bool named = false;
        for (int j = 0; j < paper->where.n; j++)
            named = named || strcmp(paper->where.factor[j], figure->x) == 0;
        if (named && strcmp(paper->quantity, figure->y) == 0 && plan_run_meets(study, &run, &paper->where) &&
            (!paper->series[0] || strcmp(paper->series, study->series[cell->series].name) == 0))
            return paper;
    }
    return NULL;
}

static enum status paper_line(struct figure_lines *lines, const struct results *results,
                              const struct study_figure *figure, const int *member, int n, int factor, int colour)
{
    struct figure_line *line;
    int found = 0;
    TRY(line_add(lines, LINE_PAPER, colour, n, &line));
    for (int k = 0; k < n; k++) {
        const struct cell *cell = &results->cell[member[k]];
        const struct study_paper *paper = paper_at(results, figure, cell);
        if (!paper)
            continue;
        line->x[found] =
            results->study->series[cell->series].factor[factor].level[cell->level[factor]].value * figure->x_scale;
        line->y[found] = paper->value * figure->y_scale;
        line->error[found++] = paper->error > 0 ? paper->error * fabs(figure->y_scale) : NAN;
    }
    line->n = found;
    snprintf(line->label, sizeof line->label, "paper");
    return STATUS_OK;
}

/* What a figure of points draws: a quantity of each cell, or a number of each tangent, which stands at its first cell.
 */
struct drawn {
    int key;           /* of results; -1: of tangents */
    int tangent_key;   /* enum tangent_key */
    const char *along; /* the factor that tangents go over; NULL: none */
};

static bool drawn_find(const struct results *results, const char *quantity, struct drawn *drawn)
{
    *drawn = (struct drawn){.key = results_key_find(results, quantity)};
    for (int t = 0; drawn->key < 0 && t < results->n_tangents; t++) {
        const struct tangent *tangent = &results->tangent[t];
        for (int k = 0; k < TANGENT_KEYS; k++) {
            char text[2 * CONFIG_STRING_MAX];
            tangent_key_text(results->study, tangent, (enum tangent_key)k, text, sizeof text);
            if (strcmp(text, quantity) != 0)
                continue;
            drawn->tangent_key = k;
            drawn->along = results->study->evaluation[tangent->evaluation].along;
            return true;
        }
    }
    return drawn->key >= 0;
}

/* NULL: nothing is drawn at this cell. */
static const struct spread *drawn_at(const struct results *results, const struct drawn *drawn, int cell)
{
    if (drawn->key >= 0)
        return &results->cell[cell].spread[drawn->key];
    for (int t = 0; t < results->n_tangents; t++)
        if (results->tangent[t].cell == cell)
            return &results->tangent[t].spread[drawn->tangent_key];
    return NULL;
}

static enum status points_line(struct figure_lines *lines, const struct results *results,
                               const struct study_figure *figure, int first, int factor, const struct drawn *drawn,
                               int colour)
{
    const struct study *study = results->study;
    struct figure_line *line;
    int *member = calloc((size_t)results->n_cells, sizeof *member), n = 0;
    if (!member)
        return no_memory();
    for (int c = first; c < results->n_cells; c++)
        if (same_line(study, &results->cell[first], &results->cell[c], factor) &&
            cell_is_drawn(study, figure, &results->cell[c]))
            member[n++] = c;
    enum status status = line_add(lines, LINE_POINTS, colour, n, &line);
    for (int k = 0; status == STATUS_OK && k < n; k++) {
        const struct cell *cell = &results->cell[member[k]];
        const struct spread *spread = drawn_at(results, drawn, member[k]);
        line->x[k] = study->series[cell->series].factor[factor].level[cell->level[factor]].value * figure->x_scale;
        line->y[k] = spread ? spread->mean * figure->y_scale : NAN;
        line->error[k] = spread ? spread->sd * fabs(figure->y_scale) : NAN;
    }
    if (status == STATUS_OK) {
        cell_text(study, &results->cell[first], figure->x, drawn->along, line->label, sizeof line->label);
        status = paper_line(lines, results, figure, member, n, factor, colour);
    }
    free(member);
    return status;
}

static enum status points_make(struct figure_lines *lines, const struct results *results,
                               const struct study_figure *figure)
{
    const struct study *study = results->study;
    struct drawn drawn;
    int colour = 0;
    if (!drawn_find(results, figure->y, &drawn))
        return status_fail(STATUS_CONFIG, "%s: figure %s: %s is not among the quantities", study->path, figure->name,
                           figure->y);
    for (int c = 0; c < results->n_cells; c++) {
        const struct cell *cell = &results->cell[c];
        int factor = study_factor_find(&study->series[cell->series], figure->x);
        bool begun = false;
        if (factor < 0 || !cell_is_drawn(study, figure, cell) || !drawn_at(results, &drawn, c))
            continue;
        for (int k = 0; k < c && !begun; k++)
            begun =
                same_line(study, cell, &results->cell[k], factor) && cell_is_drawn(study, figure, &results->cell[k]);
        if (!begun)
            TRY(points_line(lines, results, figure, c, factor, &drawn, colour++));
    }
    return STATUS_OK;
}

/* --- Mohr's circles ---------------------------------------------------------------------------------------------- */

static enum status circle_line(struct figure_lines *lines, const struct study_figure *figure, double minor,
                               double major, int colour)
{
    struct figure_line *line;
    TRY(line_add(lines, LINE_PLAIN, colour, CIRCLE, &line));
    for (int k = 0; k < CIRCLE; k++) {
        double angle = M_PI * k / (CIRCLE - 1);
        line->x[k] = ((major + minor) / 2 + (major - minor) / 2 * cos(angle)) * figure->x_scale;
        line->y[k] = (major - minor) / 2 * sin(angle) * figure->y_scale;
        line->error[k] = NAN;
    }
    return STATUS_OK;
}

static enum status tangent_lines(struct figure_lines *lines, const struct results *results,
                                 const struct study_figure *figure, const struct tangent *tangent, int colour)
{
    const struct study *study = results->study;
    const struct study_evaluation *evaluation = &study->evaluation[tangent->evaluation];
    const struct cell *first = &results->cell[tangent->cell];
    int key = results_key_find(results, evaluation->major);
    int factor = study_factor_find(&study->series[first->series], evaluation->along);
    double furthest = 0;
    struct figure_line *line;
    for (int k = 0; k < tangent->n_circles; k++) {
        const struct cell *cell = &results->cell[tangent->circle[k]];
        const struct study_factor *f = &study->series[cell->series].factor[factor];
        double minor = f->level[cell->level[factor]].value * f->scale, major = cell->spread[key].mean;
        if (!isfinite(major))
            continue;
        TRY(circle_line(lines, figure, minor, major, colour));
        furthest = fmax(furthest, major);
    }
    TRY(line_add(lines, LINE_PLAIN, colour, 2, &line));
    for (int k = 0; k < 2; k++) {
        line->x[k] = k * furthest * figure->x_scale;
        line->y[k] = (tangent->spread[TANGENT_COHESION].mean + tangent->spread[TANGENT_TAN_PHI].mean * k * furthest) *
                     figure->y_scale;
        line->error[k] = NAN;
    }
    cell_text(study, first, evaluation->along, NULL, line->label, sizeof line->label);
    return STATUS_OK;
}

static enum status mohr_make(struct figure_lines *lines, const struct results *results,
                             const struct study_figure *figure)
{
    int colour = 0;
    for (int t = 0; t < results->n_tangents; t++) {
        const struct tangent *tangent = &results->tangent[t];
        if (strcmp(results->study->evaluation[tangent->evaluation].name, figure->evaluation) == 0 &&
            tangent->spread[TANGENT_TAN_PHI].n > 0 &&
            cell_is_drawn(results->study, figure, &results->cell[tangent->cell]))
            TRY(tangent_lines(lines, results, figure, tangent, colour++));
    }
    return STATUS_OK;
}

enum status figure_lines_make(struct figure_lines *lines, const struct results *results,
                              const struct study_figure *figure, const char *out)
{
    enum status status;
    *lines = (struct figure_lines){0};
    if (figure->kind == FIGURE_CURVES)
        status = curves_make(lines, results, figure, out);
    else if (figure->kind == FIGURE_POINTS)
        status = points_make(lines, results, figure);
    else
        status = mohr_make(lines, results, figure);
    if (status != STATUS_OK)
        figure_lines_free(lines);
    return status;
}
