#include "sim/neighbours/cell_list.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim/base/aligned_array.h"

/* Up to this ratio of radii all are in one grid: a cell as wide as the largest holds few of the smallest then. */
static const double ONE_GRID_RATIO = 4;

enum status cell_list_init(struct cell_list *cells, const struct particles *p)
{
    memset(cells, 0, sizeof *cells);
    cells->dimension = p->dimension;
    size_t count = (size_t)p->count;
    TRY(array_resize(&cells->cell_of, sizeof(int32_t), count, 0));
    TRY(array_resize(&cells->by_cell, sizeof(int32_t), count, 0));
    TRY(array_resize(&cells->level_of, 1, count, 0));
    for (int c = 0; c < p->dimension; c++)
        TRY(array_resize(&cells->x[c], sizeof(double), count, 0));
    return array_resize(&cells->radius, sizeof(double), count, 0);
}

void cell_list_free(struct cell_list *cells)
{
    free(cells->cell_of);
    free(cells->cell_first);
    free(cells->by_cell);
    free(cells->level_of);
    free(cells->radius);
    for (int c = 0; c < 3; c++)
        free(cells->x[c]);
    memset(cells, 0, sizeof *cells);
}

/* Eight at a time, so that the compiler makes vectors of them. */
void cell_list_range(const double *x, int n, double *lowest, double *highest)
{
    enum { WIDTH = 8 };
    double lo[WIDTH], hi[WIDTH];
    int i = 0;
    for (int l = 0; l < WIDTH; l++)
        lo[l] = hi[l] = x[0];
    for (; i + WIDTH <= n; i += WIDTH)
        for (int l = 0; l < WIDTH; l++) {
            lo[l] = x[i + l] < lo[l] ? x[i + l] : lo[l];
            hi[l] = x[i + l] > hi[l] ? x[i + l] : hi[l];
        }
    for (; i < n; i++) {
        lo[0] = x[i] < lo[0] ? x[i] : lo[0];
        hi[0] = x[i] > hi[0] ? x[i] : hi[0];
    }
    *lowest = lo[0];
    *highest = hi[0];
    for (int l = 1; l < WIDTH; l++) {
        *lowest = fmin(*lowest, lo[l]);
        *highest = fmax(*highest, hi[l]);
    }
}

/* Classes of radii, from largest/2^(l+1) to largest/2^l, and their largest members. */
static void classify(struct cell_list *cells, const struct particles *p)
{
    double smallest, largest, bound = 0;
    cell_list_range(p->radius, p->count, &smallest, &largest);
    memset(cells->level, 0, sizeof cells->level);
    cells->n_levels = 1;
    if (largest <= ONE_GRID_RATIO * smallest) {
        memset(cells->level_of, 0, (size_t)p->count);
        cells->level[0].count = p->count;
        cells->level[0].largest = largest;
        return;
    }
    for (bound = 0.5 * largest; bound >= smallest && cells->n_levels < CELL_LEVELS_MAX; bound *= 0.5)
        cells->n_levels++;
    for (int i = 0; i < p->count; i++) {
        int l = 0;
        for (bound = 0.5 * largest; l + 1 < cells->n_levels && p->radius[i] <= bound; bound *= 0.5)
            l++;
        cells->level_of[i] = (uint8_t)l;
        cells->level[l].count++;
        cells->level[l].largest = fmax(cells->level[l].largest, p->radius[i]);
    }
}

static void lay_grid(struct cell_list *cells, struct cell_grid *grid, double skin)
{
    int total = 1;
    grid->reach = 2 * grid->largest + skin;
    for (int c = 0; c < 3; c++) {
        grid->n[c] = 1;
        if (c >= cells->dimension)
            continue;
        double extent = cells->hi[c] - cells->lo[c];
        /* never more cells along one axis than particles: a few far apart must not ask for a huge grid */
        double n = fmin(floor(extent / grid->reach), grid->count), limit = floor(4.0 * grid->count / total + 1);
        grid->n[c] = (int)fmax(1, fmin(n, limit));
        grid->size[c] = extent / grid->n[c];
        grid->inverse_size[c] = extent > 0 ? grid->n[c] / extent : 0;
        total *= grid->n[c];
    }
    grid->first = cells->total;
    cells->total += total;
}

static int cell_coordinate(const struct cell_grid *grid, int c, double from_lo)
{
    int k = (int)(from_lo * grid->inverse_size[c]);
    return k < 0 ? 0 : k >= grid->n[c] ? grid->n[c] - 1 : k;
}

struct sorting {
    struct cell_list *cells;
    const struct particles *particles;
};

enum { SORT_GRAIN = 8192 };

static void find_cells(void *context, int first, int end)
{
    const struct sorting *sorting = context;
    struct cell_list *cells = sorting->cells;
    const struct particles *p = sorting->particles;
    for (int i = first; i < end; i++) {
        const struct cell_grid *grid = &cells->level[cells->level_of[i]];
        int cell = 0;
        for (int c = p->dimension - 1; c >= 0; c--)
            cell = cell * grid->n[c] + cell_coordinate(grid, c, p->x[c][i] - cells->lo[c]);
        cells->cell_of[i] = grid->first + cell;
    }
}

/* Counting sort; first[k + 1] runs from the start of cell k to its end. */
static void count_and_place(struct cell_list *cells, int count)
{
    int32_t *first = cells->cell_first;
    memset(first, 0, ((size_t)cells->total + 2) * sizeof *first);
    for (int i = 0; i < count; i++)
        first[cells->cell_of[i] + 2]++;
    cells->most = 0;
    for (int k = 0; k < cells->total; k++) {
        cells->most = first[k + 2] > cells->most ? first[k + 2] : cells->most;
        first[k + 2] += first[k + 1];
    }
    for (int i = 0; i < count; i++)
        cells->by_cell[first[cells->cell_of[i] + 1]++] = i;
}

static void gather(void *context, int first, int end)
{
    const struct sorting *sorting = context;
    struct cell_list *cells = sorting->cells;
    const struct particles *p = sorting->particles;
    for (int m = first; m < end; m++) {
        cells->radius[m] = p->radius[cells->by_cell[m]];
        for (int c = 0; c < p->dimension; c++)
            cells->x[c][m] = p->x[c][cells->by_cell[m]];
    }
}

enum status cell_list_sort(struct cell_list *cells, const struct particles *p, double skin_m, struct thread_team *team)
{
    struct sorting sorting = {cells, p};
    if (p->count == 0)
        return STATUS_OK;
    for (int c = 0; c < p->dimension; c++)
        cell_list_range(p->x[c], p->count, &cells->lo[c], &cells->hi[c]);
    classify(cells, p);
    cells->total = 0;
    for (int l = 0; l < cells->n_levels; l++)
        if (cells->level[l].count)
            lay_grid(cells, &cells->level[l], skin_m);
    if (cells->total > cells->capacity) {
        cells->capacity = 0;
        TRY(array_resize(&cells->cell_first, sizeof(int32_t), (size_t)cells->total + 2, 0));
        cells->capacity = cells->total;
    }
    team_run_ranges(team, p->count, SORT_GRAIN, find_cells, &sorting);
    count_and_place(cells, p->count);
    team_run_ranges(team, p->count, SORT_GRAIN, gather, &sorting);
    return STATUS_OK;
}
