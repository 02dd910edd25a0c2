/* The search of pairs, written once and compiled for each instruction set. The including file defines
 *   ISA            part of the names
 *   SEARCH_LANES   candidates that search_hits looks at together
 *   search_emit    appends those that were hit
 * Cells are taken one by one: their own particles and those of half of the neighbouring cells (so that each pair is met
 * once) are laid side by side in a block, and each of the cell's particles is tested against all behind it. A cell of
 * small particles is also tested against the cells of all levels of larger ones that it can reach. */
#include <math.h>

#include "sim/neighbours/pair_search.h"

#define SEARCH_JOIN_(stem, isa) stem##_##isa
#define SEARCH_JOIN(stem, isa)  SEARCH_JOIN_(stem, isa)
#define SEARCH_NAME(stem)       SEARCH_JOIN(stem, ISA)

/* A cell under work. */
struct home {
    const struct cell_grid *grid;
    int at[3];        /* its coordinates */
    double origin[3]; /* its centre [m] */
    double skin;      /* and a margin for single precision [m] */
};

/* Eight values at a time: a few more than n are written. */
static inline __attribute__((always_inline)) void to_single(float *restrict to, const double *restrict from,
                                                            double shift, int n)
{
    for (int m = 0; m < n; m += 8)
        for (int l = 0; l < 8; l++)
            to[m + l] = (float)(from[m + l] + shift);
}

static inline __attribute__((always_inline)) void copy_ids(int32_t *restrict to, const int32_t *restrict from, int n)
{
    for (int m = 0; m < n; m += 8)
        for (int l = 0; l < 8; l++)
            to[m + l] = from[m + l];
}

/* Appends by_cell[first ... last - 1] to the block, which holds n; returns how many it holds then. Rounded up to whole
 * vectors; what is too much is written over by the next row, or not looked at. */
static inline __attribute__((always_inline)) int fill_row(const struct cell_list *cells, struct search_block *block,
                                                          const struct home *home, const int dimension, int n,
                                                          int first, int last)
{
    for (int c = 0; c < dimension; c++)
        to_single(block->x[c] + n, cells->x[c] + first, -home->origin[c], last - first);
    to_single(block->reach + n, cells->radius + first, home->skin, last - first);
    copy_ids(block->id + n, cells->by_cell + first, last - first);
    return n + (last - first);
}

/* The box of cells from ... to of a grid, row by row. */
static inline __attribute__((always_inline)) int fill_box(const struct cell_list *cells, struct search_block *block,
                                                          const struct home *home, const int dimension, int n,
                                                          const struct cell_grid *grid, const int *from, const int *to)
{
    for (int k2 = from[2]; k2 <= to[2]; k2++)
        for (int k1 = from[1]; k1 <= to[1]; k1++) {
            int row = grid->first + (k2 * grid->n[1] + k1) * grid->n[0];
            n = fill_row(cells, block, home, dimension, n, cells->cell_first[row + from[0]],
                         cells->cell_first[row + to[0] + 1]);
        }
    return n;
}

/* The home cell and the half of its neighbours that comes after it. */
static inline __attribute__((always_inline)) int
fill_own_level(const struct cell_list *cells, struct search_block *block, const struct home *home, const int dimension)
{
    const struct cell_grid *grid = home->grid;
    int before[3], after[3], n;
    for (int c = 0; c < 3; c++) {
        before[c] = home->at[c] > 0 ? home->at[c] - 1 : 0;
        after[c] = home->at[c] + 1 < grid->n[c] ? home->at[c] + 1 : home->at[c];
    }
    const int to[3] = {after[0], home->at[1], home->at[2]};
    n = fill_box(cells, block, home, dimension, 0, grid, home->at, to);
    if (after[1] > home->at[1]) {
        const int row_from[3] = {before[0], after[1], home->at[2]}, row_to[3] = {after[0], after[1], home->at[2]};
        n = fill_box(cells, block, home, dimension, n, grid, row_from, row_to);
    }
    if (after[2] > home->at[2]) {
        const int layer_from[3] = {before[0], before[1], after[2]};
        n = fill_box(cells, block, home, dimension, n, grid, layer_from, after);
    }
    return n;
}

/* The cells of a level of larger particles that the home cell's reach. */
static inline __attribute__((always_inline)) int fill_larger(const struct cell_list *cells, struct search_block *block,
                                                             const struct home *home, const int dimension, int n,
                                                             const struct cell_grid *larger)
{
    int from[3] = {0, 0, 0}, to[3] = {0, 0, 0};
    double reach = home->grid->largest + larger->largest + home->skin;
    for (int c = 0; c < dimension; c++) {
        double middle = home->origin[c] - cells->lo[c], half = 0.5 * home->grid->size[c] + reach;
        from[c] = (int)fmin(fmax((middle - half) * larger->inverse_size[c], 0), larger->n[c] - 1);
        to[c] = (int)fmin(fmax((middle + half) * larger->inverse_size[c], 0), larger->n[c] - 1);
    }
    return fill_box(cells, block, home, dimension, n, larger, from, to);
}

static inline __attribute__((always_inline)) enum status search_cell(const struct cell_list *cells,
                                                                     struct search_block *block,
                                                                     const struct home *home, const int dimension,
                                                                     int level, int own, struct pair_buffer *pairs)
{
    int n = fill_own_level(cells, block, home, dimension);
    for (int l = 0; l < level; l++)
        if (cells->level[l].count)
            n = fill_larger(cells, block, home, dimension, n, &cells->level[l]);
    for (int a = 0; a < own; a++) {
        if (n - a > pairs->capacity - pairs->count)
            TRY(pair_buffer_reserve(pairs, n - a));
        pairs->count +=
            search_emit(block, dimension, a, n, (float)home->skin, pairs->lo + pairs->count, pairs->hi + pairs->count);
    }
    return STATUS_OK;
}

static inline __attribute__((always_inline)) enum status search_level(const struct cell_list *cells, double skin,
                                                                      int piece, int pieces, struct search_block *block,
                                                                      const int dimension, int level,
                                                                      struct pair_buffer *pairs)
{
    struct home home = {.grid = &cells->level[level]};
    const int *size = home.grid->n;
    double widest = 0;
    for (int c = 0; c < dimension; c++)
        widest = fmax(widest, cells->level[0].count ? cells->level[0].reach : home.grid->reach);
    for (int c = 0; c < dimension; c++)
        widest = fmax(widest, fmin(home.grid->size[c], cells->hi[c] - cells->lo[c]));
    home.skin = skin + 1e-6 * widest;
    const int64_t total = (int64_t)size[0] * size[1] * size[2];
    for (int k = (int)(total * piece / pieces), end = (int)(total * (piece + 1) / pieces); k < end; k++) {
        int own = cells->cell_first[home.grid->first + k + 1] - cells->cell_first[home.grid->first + k], rest = k;
        if (own == 0)
            continue;
        for (int c = 0; c < 3; c++) {
            home.at[c] = rest % size[c];
            rest /= size[c];
            home.origin[c] = c < dimension ? cells->lo[c] + (home.at[c] + 0.5) * home.grid->size[c] : 0;
        }
        TRY(search_cell(cells, block, &home, dimension, level, own, pairs));
    }
    return STATUS_OK;
}

static enum status SEARCH_NAME(pairs)(const struct cell_list *cells, double skin, int k, int n,
                                      struct search_block *block, struct pair_buffer *pairs)
{
    for (int l = 0; l < cells->n_levels; l++)
        if (cells->level[l].count)
            TRY(cells->dimension == 2 ? search_level(cells, skin, k, n, block, 2, l, pairs)
                                      : search_level(cells, skin, k, n, block, 3, l, pairs));
    return STATUS_OK;
}

#define DEFINE_CARRY(real)                                                                                             \
    static inline __attribute__((always_inline)) void SEARCH_NAME(carry_each_##real)(                                  \
        real *restrict to, const real *restrict from, const int32_t *restrict source, int count, const bool turns)     \
    {                                                                                                                  \
        for (int s = 0; s < count; s++) {                                                                              \
            const int32_t there = ~(source[s] >> 31); /* all bits or none; no branch: it could not be predicted */     \
            const real value = from[(source[s] >> 1) & there];                                                         \
            to[s] = there ? (turns ? (real)(1 - 2 * (source[s] & 1)) * value : value) : 0;                             \
        }                                                                                                              \
    }                                                                                                                  \
    static void SEARCH_NAME(carry_##real)(real * to, const real *from, const int32_t *source, int count, bool turns)   \
    {                                                                                                                  \
        if (turns)                                                                                                     \
            SEARCH_NAME(carry_each_##real)(to, from, source, count, true);                                             \
        else                                                                                                           \
            SEARCH_NAME(carry_each_##real)(to, from, source, count, false);                                            \
    }
DEFINE_CARRY(double)
DEFINE_CARRY(float)

static void SEARCH_NAME(add)(double *restrict to, const double *restrict value, const int32_t *restrict i,
                             const int32_t *restrict j, int count)
{
    for (int k = 0; k < count; k++)
        to[k] = value[i[k]] + value[j[k]];
}

extern const struct search SEARCH_NAME(search);
const struct search SEARCH_NAME(search) = {SEARCH_NAME(pairs), SEARCH_NAME(carry_double), SEARCH_NAME(carry_float),
                                           SEARCH_NAME(add)};
