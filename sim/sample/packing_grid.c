#include "sim/sample/packing_grid.h"

#include <math.h>
#include <stdlib.h>

static int coordinate(const struct packing_grid *grid, int c, double x)
{
    int k = (int)((x - grid->lo[c]) / grid->size[c]);
    return k < 0 ? 0 : k >= grid->cells[c] ? grid->cells[c] - 1 : k;
}

static bool overlaps(const struct particles *p, const double *x, double radius, int j, double ratio)
{
    double d2 = 0, reach = radius + p->radius[j] - ratio * fmin(radius, p->radius[j]);
    for (int c = 0; c < p->dimension; c++)
        d2 += (x[c] - p->x[c][j]) * (x[c] - p->x[c][j]);
    return d2 < reach * reach;
}

int packing_grid_overlap(const struct packing_grid *grid, const struct particles *p, const double *x, double radius,
                         double ratio)
{
    int from[3] = {0, 0, 0}, to[3] = {0, 0, 0};
    for (int c = 0; c < p->dimension; c++) {
        int k = coordinate(grid, c, x[c]);
        from[c] = k > 0 ? k - 1 : 0;
        to[c] = k + 1 < grid->cells[c] ? k + 1 : k;
    }
    for (int k2 = from[2]; k2 <= to[2]; k2++)
        for (int k1 = from[1]; k1 <= to[1]; k1++)
            for (int k0 = from[0]; k0 <= to[0]; k0++)
                for (int j = grid->first[(k2 * grid->cells[1] + k1) * grid->cells[0] + k0]; j >= 0; j = grid->next[j])
                    if (overlaps(p, x, radius, j, ratio))
                        return j;
    return -1;
}

enum status packing_grid_init(struct packing_grid *grid, const struct particles *p, const double *lo, const double *hi,
                              double diameter_m)
{
    size_t total = 1;
    const double cells_max = ceil(pow(4.0 * p->count, 1.0 / p->dimension));
    double volume = 1;
    for (int c = 0; c < p->dimension; c++)
        volume *= hi[c] - lo[c];
    diameter_m = fmax(diameter_m, pow(volume, 1.0 / p->dimension) / cells_max);
    *grid = (struct packing_grid){.cells = {1, 1, 1}, .size = {1, 1, 1}};
    for (int c = 0; c < p->dimension; c++) {
        grid->lo[c] = lo[c];
        grid->cells[c] = (int)fmax(1, floor((hi[c] - lo[c]) / diameter_m));
        grid->size[c] = (hi[c] - lo[c]) / grid->cells[c];
        total *= (size_t)grid->cells[c];
    }
    grid->first = malloc(total * sizeof *grid->first);
    grid->next = malloc((size_t)p->count * sizeof *grid->next);
    if (!grid->first || !grid->next)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    for (size_t k = 0; k < total; k++)
        grid->first[k] = -1;
    return STATUS_OK;
}

void packing_grid_free(struct packing_grid *grid)
{
    free(grid->first);
    free(grid->next);
}

void packing_grid_insert(struct packing_grid *grid, const struct particles *p, int i)
{
    int at[3] = {0, 0, 0};
    for (int c = 0; c < p->dimension; c++)
        at[c] = coordinate(grid, c, p->x[c][i]);
    int cell = (at[2] * grid->cells[1] + at[1]) * grid->cells[0] + at[0];
    grid->next[i] = grid->first[cell];
    grid->first[cell] = i;
}
