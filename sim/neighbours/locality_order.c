#include "sim/neighbours/locality_order.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim/base/aligned_array.h"
#include "sim/contacts/contact_list.h"
#include "sim/grains/particle_order.h"
#include "sim/neighbours/bisection.h"
#include "sim/neighbours/neighbour_chains.h"

/* Smaller samples take a few microseconds a step as they are. */
enum { SMALLEST_SAMPLE = 1000, STEPS_BETWEEN = 4096 };

int64_t locality_order_interval(int64_t scene_steps, int count)
{
    return scene_steps >= 0 ? scene_steps : count >= SMALLEST_SAMPLE ? STEPS_BETWEEN : 0;
}

static enum status no_memory(void)
{
    return status_fail(STATUS_NO_MEMORY, "no memory for a new order of the particles");
}

/* Axes from the shortest side to the longest, so that slabs across the longest are small. */
static void sort_axes(const double *side, int dimension, int *axis)
{
    for (int c = 0; c < dimension; c++)
        axis[c] = c;
    for (int c = 1; c < dimension; c++)
        for (int b = c; b > 0 && side[axis[b]] < side[axis[b - 1]]; b--) {
            int swap = axis[b];
            axis[b] = axis[b - 1];
            axis[b - 1] = swap;
        }
}

/* Cell of every particle in a grid of about one particle per cell. Returns the number of cells. */
static int find_cells(const struct particles *p, int32_t *cell)
{
    double lo[3], hi[3], side[3], volume = 1;
    int axis[3], total = 1;
    for (int c = 0; c < p->dimension; c++) {
        cell_list_range(p->x[c], p->count, &lo[c], &hi[c]);
        side[c] = fmax(hi[c] - lo[c], 1e-300);
        volume *= side[c];
    }
    sort_axes(side, p->dimension, axis);
    double size = pow(volume / p->count, 1.0 / p->dimension);
    memset(cell, 0, (size_t)p->count * sizeof *cell);
    for (int k = p->dimension - 1; k >= 0; k--) {
        const int c = axis[k], n = (int)fmax(1, fmin(floor(side[c] / size), 4.0 * p->count / total));
        for (int i = 0; i < p->count; i++) {
            int at = (int)((p->x[c][i] - lo[c]) * (n / side[c]));
            cell[i] = cell[i] * n + (at < n ? at : n - 1);
        }
        total *= n;
    }
    return total;
}

static int by_key(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Large samples: boxes of a span each, and within these by cell. */
static void order_boxes(const struct particles *p, const int32_t *cell, int32_t *order)
{
    uint64_t key[SPAN_WIDTH];
    bisection_order(p, SPAN_WIDTH, order);
    for (int first = 0; first < p->count; first += SPAN_WIDTH) {
        const int n = p->count - first < SPAN_WIDTH ? p->count - first : SPAN_WIDTH;
        for (int k = 0; k < n; k++)
            key[k] = (uint64_t)(uint32_t)cell[order[first + k]] << 32 | (uint32_t)order[first + k];
        qsort(key, (size_t)n, sizeof *key, by_key);
        for (int k = 0; k < n; k++)
            order[first + k] = (int32_t)(key[k] & UINT32_MAX);
    }
}

/* order[new slot] = old slot: counting sort by cell. */
static enum status spatial_order(const struct particles *p, int32_t *order)
{
    int32_t *cell = malloc((size_t)p->count * sizeof *cell), *first = NULL;
    int total = cell ? find_cells(p, cell) : 0;
    first = cell ? calloc((size_t)total + 1, sizeof *first) : NULL;
    for (int i = 0; first && i < p->count; i++)
        first[cell[i] + 1]++;
    for (int k = 0; first && k < total; k++)
        first[k + 1] += first[k];
    for (int i = 0; first && i < p->count; i++)
        order[first[cell[i]]++] = i;
    if (first && p->count >= PARTICLES_LARGE_SAMPLE)
        order_boxes(p, cell, order);
    enum status status = first ? STATUS_OK : no_memory();
    free(cell);
    free(first);
    return status;
}

/* `count` members of `size` bytes, or nothing if there is no such array. */
static void permute(void *array, size_t size, int count, const int32_t *order, void *scratch)
{
    const unsigned char *from = array;
    unsigned char *to = scratch;
    if (!array)
        return;
    for (int k = 0; k < count; k++)
        memcpy(to + size * (size_t)k, from + size * (size_t)order[k], size);
    memcpy(array, scratch, size * (size_t)count);
}

/* The same of a column of the views. */
static void permute_view(const struct particles *p, void *column, const int32_t *order, void *scratch)
{
    const size_t size = p->mixed ? sizeof(float) : sizeof(double);
    unsigned char *at = column, *by_slot = scratch;
    if (!column)
        return;
    for (int k = 0; k < p->count; k++)
        memcpy(by_slot + size * (size_t)k, at + size * particles_view_at(p, order[k]), size);
    for (int k = 0; k < p->count; k++)
        memcpy(at + size * particles_view_at(p, k), by_slot + size * (size_t)k, size);
}

/* What steps go on with in the views; and mixed. */
static void permute_steps(struct particles *p, const int32_t *order, void *scratch)
{
    for (int c = 0; c < 3; c++) {
        permute_view(p, p->view_v[c], order, scratch);
        permute_view(p, p->view_omega[c], order, scratch);
        permute_view(p, p->view_u[c], order, scratch);
        permute(p->u_rest[c], sizeof(float), p->count, order, scratch);
        permute(p->v_rest[c], sizeof(float), p->count, order, scratch);
        permute(p->omega_rest[c], sizeof(float), p->count, order, scratch);
    }
}

/* All that a particle carries from step to step. */
static enum status permute_particles(struct particles *p, const int32_t *order, int32_t *slot_before)
{
    double *scratch = malloc((size_t)p->count * sizeof *scratch);
    if (!scratch)
        return no_memory();
    for (int c = 0; c < 3; c++) {
        permute(p->x[c], sizeof(double), p->count, order, scratch);
        permute(p->v[c], sizeof(double), p->count, order, scratch);
        permute(p->a[c], sizeof(double), p->count, order, scratch);
        permute(p->x_list[c], sizeof(double), p->count, order, scratch);
        permute(p->omega[c], sizeof(double), p->count, order, scratch);
        permute(p->alpha[c], sizeof(double), p->count, order, scratch);
    }
    permute(p->radius, sizeof(double), p->count, order, scratch);
    permute(p->mass, sizeof(double), p->count, order, scratch);
    permute(p->inv_mass, sizeof(double), p->count, order, scratch);
    permute(p->inv_inertia, sizeof(double), p->count, order, scratch);
    permute_steps(p, order, scratch);
    free(scratch);
    for (int k = 0; k < p->count; k++)
        slot_before[k] = p->id[order[k]]; /* only lent: the new ids */
    memcpy(p->id, slot_before, (size_t)p->count * sizeof *p->id);
    for (int k = 0; k < p->count; k++)
        slot_before[order[k]] = k;
    return particles_set_slots(p);
}

/* A member of a list under its new numbers, and where its history is. */
struct moved {
    int32_t i, j, from;
    bool swapped;
};

static int by_numbers(const void *a, const void *b)
{
    const struct moved *x = a, *y = b;
    return x->i != y->i ? (x->i > y->i) - (x->i < y->i) : (x->j > y->j) - (x->j < y->j);
}

static struct moved move(const struct contact_list *list, int k, const int32_t *slot, int count)
{
    int32_t i = slot[list->i[k]], j = list->j[k] < count ? slot[list->j[k]] : list->j[k];
    return (struct moved){.i = i < j ? i : j, .j = i < j ? j : i, .from = k, .swapped = i > j};
}

/* One array of the list after the other into the order of `moved`. */
static void permute_history(double *values, const struct moved *moved, int count, double *scratch)
{
    if (!values)
        return;
    for (int k = 0; k < count; k++)
        scratch[k] = values[moved[k].from];
    memcpy(values, scratch, (size_t)count * sizeof *values);
}

/* A column of the history, with the other sign where that changes as i and j change places. */
static void permute_column(struct contact_list *list, int c, const struct moved *moved, double *scratch)
{
    permute_history(list->history[c], moved, list->count, scratch);
    for (int k = 0; history_is_odd(&list->model, c) && k < list->count; k++)
        if (moved[k].swapped)
            list->history[c][k] = -list->history[c][k];
}

static enum status locality_order_list(struct contact_list *list, const struct particles *p, const struct wall *wall,
                                       const int32_t *slot)
{
    contact_list_read(list);
    struct moved *moved = malloc((size_t)(list->count + 1) * sizeof *moved);
    double *scratch = malloc((size_t)(list->count + 1) * sizeof *scratch);
    if (!moved || !scratch) {
        free(moved);
        free(scratch);
        return no_memory();
    }
    for (int k = 0; k < list->count; k++)
        moved[k] = move(list, k, slot, p->count);
    qsort(moved, (size_t)list->count, sizeof *moved, by_numbers);
    for (int k = 0; k < list->count; k++) {
        list->i[k] = moved[k].i;
        list->j[k] = moved[k].j;
    }
    permute_history(list->reach, moved, list->count, scratch);
    for (int c = 0; c < HISTORY_COLUMNS; c++)
        if (history_has(&list->model, c))
            permute_column(list, c, moved, scratch);
    free(moved);
    free(scratch);
    return contact_list_close(list, p, wall);
}

enum status locality_order_apply(struct particles *p, struct contact_list *pairs, struct wall *walls, int n_walls)
{
    int32_t *order = malloc((size_t)p->count * sizeof *order), *slot = malloc((size_t)p->count * sizeof *slot);
    enum status status = order && slot ? spatial_order(p, order) : no_memory();
    if (status == STATUS_OK)
        status = neighbour_chains_order(pairs, p->count, order);
    if (status == STATUS_OK)
        status = permute_particles(p, order, slot);
    if (status == STATUS_OK)
        status = locality_order_list(pairs, p, NULL, slot);
    for (int w = 0; status == STATUS_OK && w < n_walls; w++)
        status = locality_order_list(&walls[w].contacts, p, &walls[w], slot);
    free(order);
    free(slot);
    return status;
}
