#include "sim/neighbor.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim/memory.h"

/* Grid over the bounding box of the particles. */
struct cells {
    int n[3];
    double lo[3], inverse_size[3];
    int total;
};

static void list_model(struct contact_list *list, const struct particles *p, bool hysteretic)
{
    list->hysteretic = hysteretic;
    list->n_springs = p->n_rotations;
}

enum status neighbor_init(struct neighbor *nb, const struct particles *p, double skin_m, bool hysteretic)
{
    memset(nb, 0, sizeof *nb);
    nb->skin = skin_m;
    list_model(&nb->spare_pairs, p, hysteretic);
    list_model(&nb->spare_wall, p, hysteretic);
    nb->spare_wall.keep_forces = true;
    size_t count = (size_t)p->count;
    TRY(array_resize(&nb->cell_of, sizeof(int32_t), count, 0));
    TRY(array_resize(&nb->by_cell, sizeof(int32_t), count, 0));
    for (int c = 0; c < p->dimension; c++)
        TRY(array_resize(&nb->sorted_x[c], sizeof(double), count, 0));
    return array_resize(&nb->sorted_radius, sizeof(double), count, 0);
}

void neighbor_free(struct neighbor *nb)
{
    free(nb->cell_of);
    free(nb->cell_first);
    free(nb->by_cell);
    free(nb->sorted_radius);
    for (int c = 0; c < 3; c++)
        free(nb->sorted_x[c]);
    contact_list_free(&nb->spare_pairs);
    contact_list_free(&nb->spare_wall);
    memset(nb, 0, sizeof *nb);
}

static double largest_radius(const struct particles *p)
{
    double largest = 0;
    for (int i = 0; i < p->count; i++)
        largest = p->radius[i] > largest ? p->radius[i] : largest;
    return largest;
}

static void cells_of(struct cells *cells, const struct particles *p, double reach)
{
    cells->total = 1;
    for (int c = 0; c < 3; c++) {
        cells->n[c] = 1;
        cells->lo[c] = 0;
        cells->inverse_size[c] = 0;
        if (c >= p->dimension)
            continue;
        double lo = p->x[c][0], hi = lo;
        for (int i = 1; i < p->count; i++) {
            lo = p->x[c][i] < lo ? p->x[c][i] : lo;
            hi = p->x[c][i] > hi ? p->x[c][i] : hi;
        }
        /* never more cells along one axis than particles: a few far apart must not ask for a huge grid */
        double n = fmin(floor((hi - lo) / reach), p->count);
        double limit = floor(4.0 * p->count / cells->total + 1);
        cells->n[c] = (int)fmax(1, fmin(n, limit));
        cells->lo[c] = lo;
        cells->inverse_size[c] = hi > lo ? cells->n[c] / (hi - lo) : 0;
        cells->total *= cells->n[c];
    }
}

static int cell_coordinate(const struct cells *cells, int c, double x)
{
    int k = (int)((x - cells->lo[c]) * cells->inverse_size[c]);
    return k < 0 ? 0 : k >= cells->n[c] ? cells->n[c] - 1 : k;
}

/* Counting sort of the particles by cell, rising within each. */
static enum status sort_by_cell(struct neighbor *nb, const struct particles *p, const struct cells *cells)
{
    if (cells->total > nb->cell_capacity) {
        TRY(array_resize(&nb->cell_first, sizeof(int32_t), (size_t)cells->total + 2, 0));
        nb->cell_capacity = cells->total;
    }
    memset(nb->cell_first, 0, ((size_t)cells->total + 2) * sizeof *nb->cell_first);
    for (int i = 0; i < p->count; i++) {
        int at[3] = {0, 0, 0};
        for (int c = 0; c < p->dimension; c++)
            at[c] = cell_coordinate(cells, c, p->x[c][i]);
        nb->cell_of[i] = (at[2] * cells->n[1] + at[1]) * cells->n[0] + at[0];
        nb->cell_first[nb->cell_of[i] + 2]++;
    }
    for (int k = 0; k < cells->total; k++)
        nb->cell_first[k + 2] += nb->cell_first[k + 1];
    for (int i = 0; i < p->count; i++)
        nb->by_cell[nb->cell_first[nb->cell_of[i] + 1]++] = i;
    for (int m = 0; m < p->count; m++) {
        nb->sorted_radius[m] = p->radius[nb->by_cell[m]];
        for (int c = 0; c < p->dimension; c++)
            nb->sorted_x[c][m] = p->x[c][nb->by_cell[m]];
    }
    return STATUS_OK;
}

/* Appends the neighbours j > i among members first ... last - 1 of by_cell to `list`, which has room for all of them.
 * No branch in the loop: what to keep cannot be predicted. */
static void collect_row(const struct neighbor *nb, const struct particles *p, int i, int first, int last,
                        struct contact_list *list)
{
    const int32_t *by_cell = nb->by_cell;
    const double *radius = nb->sorted_radius, limit = p->radius[i] + nb->skin;
    const int dimension = p->dimension;
    int count = list->count;
    for (int m = first; m < last; m++) {
        double d0 = nb->sorted_x[0][m] - p->x[0][i], d1 = nb->sorted_x[1][m] - p->x[1][i];
        double d2 = d0 * d0 + d1 * d1, reach = limit + radius[m];
        if (dimension == 3) {
            double d = nb->sorted_x[2][m] - p->x[2][i];
            d2 += d * d;
        }
        list->i[count] = i;
        list->j[count] = by_cell[m];
        count += (by_cell[m] > i) & (d2 < reach * reach);
    }
    list->count = count;
}

/* Appends the neighbours j > i in reach to `list`, unsorted. */
static enum status collect(struct neighbor *nb, const struct particles *p, const struct cells *cells, int i,
                           struct contact_list *list)
{
    int from[3], to[3], rest = nb->cell_of[i];
    for (int c = 0; c < 3; c++) {
        int at = rest % cells->n[c];
        rest /= cells->n[c];
        from[c] = at > 0 ? at - 1 : 0;
        to[c] = at + 1 < cells->n[c] ? at + 1 : at;
    }
    for (int k2 = from[2]; k2 <= to[2]; k2++)
        for (int k1 = from[1]; k1 <= to[1]; k1++) {
            int row = (k2 * cells->n[1] + k1) * cells->n[0];
            int first = nb->cell_first[row + from[0]], last = nb->cell_first[row + to[0] + 1];
            if (list->count + (last - first) > list->capacity)
                TRY(contact_list_reserve(list, 2 * list->capacity + (last - first) + 64, p->dimension));
            collect_row(nb, p, i, first, last, list);
        }
    return STATUS_OK;
}

static void sort_rising(int32_t *values, int count)
{
    for (int k = 1; k < count; k++) {
        int32_t value = values[k];
        int m = k;
        for (; m > 0 && values[m - 1] > value; m--)
            values[m] = values[m - 1];
        values[m] = value;
    }
}

static enum status build_pairs(struct neighbor *nb, const struct particles *p, struct contact_list *pairs)
{
    struct cells cells;
    struct contact_list *fresh = &nb->spare_pairs;
    fresh->count = 0;
    contact_list_read(pairs);
    cells_of(&cells, p, 2 * largest_radius(p) + nb->skin);
    TRY(sort_by_cell(nb, p, &cells));
    int old = 0;
    for (int i = 0; i < p->count; i++) {
        int first = fresh->count;
        TRY(collect(nb, p, &cells, i, fresh));
        sort_rising(fresh->j + first, fresh->count - first);
        for (int k = first; k < fresh->count; k++) {
            while (old < pairs->count && (pairs->i[old] < i || (pairs->i[old] == i && pairs->j[old] < fresh->j[k])))
                old++;
            fresh->reach[k] = p->radius[i] + p->radius[fresh->j[k]];
            bool known = old < pairs->count && pairs->i[old] == i && pairs->j[old] == fresh->j[k];
            if (known)
                contact_list_carry(fresh, k, pairs, old);
            else
                contact_list_clear(fresh, k);
        }
    }
    TRY(contact_list_close(fresh, p));
    fresh->keep_forces = pairs->keep_forces;
    struct contact_list swap = *pairs;
    *pairs = *fresh;
    *fresh = swap;
    return STATUS_OK;
}

static enum status build_wall(struct neighbor *nb, const struct particles *p, struct wall *wall)
{
    struct contact_list *fresh = &nb->spare_wall, *contacts = &wall->contacts;
    fresh->count = 0;
    contact_list_read(contacts);
    int old = 0;
    for (int i = 0; i < p->count; i++) {
        double gap = wall->inward * (p->x[wall->axis][i] - wall->x) - p->radius[i];
        if (!(gap < nb->skin))
            continue;
        if (fresh->count == fresh->capacity)
            TRY(contact_list_reserve(fresh, 2 * fresh->capacity + 64, p->dimension));
        int k = fresh->count++;
        fresh->i[k] = i;
        fresh->j[k] = p->count;
        fresh->reach[k] = p->radius[i];
        while (old < contacts->count && contacts->i[old] < i)
            old++;
        if (old < contacts->count && contacts->i[old] == i)
            contact_list_carry(fresh, k, contacts, old);
        else
            contact_list_clear(fresh, k);
    }
    TRY(contact_list_close(fresh, p));
    struct contact_list swap = *contacts;
    *contacts = *fresh;
    *fresh = swap;
    wall->x_list = wall->x;
    return STATUS_OK;
}

enum status neighbor_build(struct neighbor *nb, struct particles *p, struct contact_list *pairs, struct wall *walls,
                           int n_walls)
{
    TRY(build_pairs(nb, p, pairs));
    for (int w = 0; w < n_walls; w++)
        TRY(build_wall(nb, p, &walls[w]));
    for (int c = 0; c < p->dimension; c++)
        memcpy(p->x_list[c], p->x[c], (size_t)p->count * sizeof(double));
    nb->rebuilds++;
    return STATUS_OK;
}
