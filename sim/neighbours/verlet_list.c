#include "sim/neighbours/verlet_list.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim/base/aligned_array.h"
#include "sim/neighbours/history_transfer.h"

static enum status block_init(struct search_block *block, const struct particles *p)
{
    for (int c = 0; c < p->dimension; c++)
        TRY(array_resize(&block->x[c], sizeof(float), (size_t)p->count, 0));
    TRY(array_resize(&block->reach, sizeof(float), (size_t)p->count, 0));
    return array_resize(&block->id, sizeof(int32_t), (size_t)p->count, 0);
}

/* The same bits in whatever order the particles are. */
static double mean_radius(const struct particles *p)
{
    double sum = 0;
    for (int i = 0; i < p->count; i++)
        sum += p->radius[p->slot[i]];
    return sum / p->count;
}

enum status verlet_list_init(struct verlet_list *nb, const struct particles *p, double skin_ratio,
                             const struct contact_model *model, enum instruction_set isa)
{
    const double first_guess = 0.1;
    memset(nb, 0, sizeof *nb);
    nb->mean_radius = mean_radius(p);
    nb->skin_fixed = skin_ratio * nb->mean_radius;
    nb->skin = skin_ratio > 0 ? nb->skin_fixed : first_guess * nb->mean_radius;
    nb->search = search_select(isa);
    nb->spare_pairs.model = nb->spare_wall.model = *model;
    TRY(cell_list_init(&nb->cells, p));
    TRY(block_init(&nb->block, p));
    return array_resize(&nb->first_pair_of, sizeof(int32_t), (size_t)p->count + 2, 0);
}

void verlet_list_free(struct verlet_list *nb)
{
    cell_list_free(&nb->cells);
    for (int c = 0; c < 3; c++)
        free(nb->block.x[c]);
    free(nb->block.reach);
    free(nb->block.id);
    pair_buffer_free(&nb->found);
    pair_buffer_free(&nb->half_sorted);
    free(nb->first_pair_of);
    free(nb->source);
    contact_list_free(&nb->spare_pairs);
    contact_list_free(&nb->spare_wall);
    memset(nb, 0, sizeof *nb);
}

/* Starts of the rows of equal `key` from their number: first[v + 1] is where the first pair of v goes. */
static void count_rows(int32_t *first, int n_padded, const int32_t *key, int n)
{
    memset(first, 0, ((size_t)n_padded + 2) * sizeof *first);
    for (int k = 0; k < n; k++)
        first[key[k] + 2]++;
    for (int v = 0; v < n_padded; v++)
        first[v + 2] += first[v + 1];
}

/* Counting sort of the pairs found, by j and then by i, into the list; first_pair_of becomes the rows of i. */
static enum status sort_pairs(struct verlet_list *nb, int n_particles, struct contact_list *list, int dimension)
{
    struct pair_buffer *from = &nb->found, *half = &nb->half_sorted;
    half->count = 0;
    list->count = 0;
    TRY(pair_buffer_reserve(half, from->count));
    if (from->count > list->capacity)
        TRY(contact_list_reserve(list, from->count + from->count / 8 + 64, dimension));
    count_rows(nb->first_pair_of, n_particles, from->hi, from->count);
    for (int k = 0; k < from->count; k++) {
        int to = nb->first_pair_of[from->hi[k] + 1]++;
        half->lo[to] = from->lo[k];
        half->hi[to] = from->hi[k];
    }
    count_rows(nb->first_pair_of, n_particles, from->lo, from->count);
    for (int k = 0; k < from->count; k++) {
        int to = nb->first_pair_of[half->lo[k] + 1]++;
        list->i[to] = half->lo[k];
        list->j[to] = half->hi[k];
    }
    list->count = from->count;
    return STATUS_OK;
}

static uint64_t pair_key(const struct contact_list *list, int k)
{
    return (uint64_t)(uint32_t)list->i[k] << 32 | (uint32_t)list->j[k];
}

static enum status reserve_source(struct verlet_list *nb, int count)
{
    if (count <= nb->source_capacity)
        return STATUS_OK;
    nb->source_capacity = 0;
    TRY(array_resize(&nb->source, sizeof(int32_t), (size_t)count + (size_t)count / 8, 0));
    nb->source_capacity = count + count / 8;
    return STATUS_OK;
}

/* Closes `to` with the histories of the candidates that `from` had too; both sorted. The others start from zero. */
static enum status close_after(struct verlet_list *nb, struct contact_list *to, struct contact_list *from,
                               const struct particles *p, const struct wall *wall)
{
    TRY(reserve_source(nb, to->count));
    for (int k = 0, old = 0; k < to->count; k++) {
        uint64_t key = pair_key(to, k);
        while (old < from->count && pair_key(from, old) < key)
            old++;
        const bool known = old < from->count && pair_key(from, old) == key;
        nb->source[k] = known ? old : -1;
        old += known;
    }
    return history_transfer_close(to, p, wall, from, nb->source, &nb->search);
}

static void swap_lists(struct contact_list *a, struct contact_list *b)
{
    struct contact_list swap = *a;
    *a = *b;
    *b = swap;
}

static enum status build_pairs(struct verlet_list *nb, const struct particles *p, struct contact_list *pairs)
{
    struct contact_list *fresh = &nb->spare_pairs;
    TRY(cell_list_sort(&nb->cells, p, nb->skin));
    nb->found.count = 0;
    TRY(nb->search.pairs(&nb->cells, nb->skin, &nb->block, &nb->found));
    TRY(sort_pairs(nb, p->count, fresh, p->dimension));
    if (fresh->count)
        nb->search.add(fresh->reach, p->radius, fresh->i, fresh->j, fresh->count);
    fresh->search_max = pairs->search_max;
    TRY(close_after(nb, fresh, pairs, p, NULL));
    swap_lists(pairs, fresh);
    return STATUS_OK;
}

/* Particles closer to the wall than the skin, rising, into `near`, which has room for all; returns how many. No branch
 * in the loop: what to keep cannot be predicted. */
static int find_near(const struct particles *p, const struct wall *wall, double skin, int32_t *near)
{
    const double *x = p->x[wall->axis], *radius = p->radius;
    int count = 0;
    for (int i = 0; i < p->count; i++) {
        near[count] = i;
        count += wall->inward * (x[i] - wall->x) - radius[i] < skin;
    }
    return count;
}

static enum status build_wall(struct verlet_list *nb, const struct particles *p, struct wall *wall)
{
    struct contact_list *fresh = &nb->spare_wall;
    int32_t *near = nb->cells.by_cell; /* the grid is not needed any more */
    int count = find_near(p, wall, nb->skin, near);
    fresh->count = 0;
    if (count > fresh->capacity)
        TRY(contact_list_reserve(fresh, 2 * count + 64, p->dimension));
    fresh->count = count;
    for (int k = 0; k < count; k++) {
        fresh->i[k] = near[k];
        fresh->j[k] = p->count;
        fresh->reach[k] = p->radius[near[k]];
    }
    wall->x_list = wall->x;
    TRY(close_after(nb, fresh, &wall->contacts, p, wall));
    swap_lists(&wall->contacts, fresh);
    return STATUS_OK;
}

enum status verlet_list_build(struct verlet_list *nb, struct particles *p, struct contact_list *pairs,
                              struct wall *walls, int n_walls)
{
    particles_mark_listed(p, nb->skin);
    TRY(build_pairs(nb, p, pairs));
    for (int w = 0; w < n_walls; w++)
        TRY(build_wall(nb, p, &walls[w]));
    nb->rebuilds++;
    return STATUS_OK;
}

/* The farthest that a particle or wall is from where the lists were built. */
static double farthest(const struct particles *p, const struct wall *walls, int n_walls)
{
    double most2 = 0;
    for (int i = 0; i < p->count; i++) {
        double moved2 = particles_moved2_m2(p, i);
        most2 = moved2 > most2 ? moved2 : most2;
    }
    for (int w = 0; w < n_walls; w++)
        most2 = fmax(most2, (walls[w].x - walls[w].x_list) * (walls[w].x - walls[w].x_list));
    return sqrt(most2);
}

/* The skin s that costs least where it is used up at `speed` per step. A skin costs m1 s/a candidates per particle and
 * step, each as much as 1/r of building one particle's row, and s/(2 speed) steps pass from build to build: s^2 = 2 a
 * speed r/m1. m1 counts near neighbours in a dense packing. r and m1: docs/performance.md, skin. */
static double best_skin(const struct verlet_list *nb, const struct particles *p, double speed)
{
    const double smallest = 0.01, largest = 1;
    double ratio = p->dimension == 2 ? 30 / 1.4 : 15 / 3.9;
    double skin = sqrt(2 * nb->mean_radius * speed * ratio);
    return fmin(fmax(skin, smallest * nb->mean_radius), largest * nb->mean_radius);
}

void verlet_list_tune(struct verlet_list *nb, const struct particles *p, const struct wall *walls, int n_walls,
                      int64_t step)
{
    if (nb->skin_fixed > 0 || step <= nb->built_step)
        return;
    double speed = farthest(p, walls, n_walls) / (double)(step - nb->built_step);
    nb->skin = sqrt(nb->skin * best_skin(nb, p, speed)); /* half way there: speeds vary */
}

int verlet_list_search_max(const struct verlet_list *nb, int64_t step)
{
    const int64_t least = 12, most = 4096, visits = (step - nb->built_step) / 4;
    return (int)(visits < least ? least : visits < most ? visits : most);
}

bool verlet_list_is_wide(const struct verlet_list *nb, const struct particles *p, const struct wall *walls, int n_walls,
                         int64_t step)
{
    const int64_t since = step - nb->built_step, first_look = 256;
    if (nb->skin_fixed > 0 || since < first_look || (since & (since - 1)) != 0)
        return false;
    return best_skin(nb, p, farthest(p, walls, n_walls) / (double)since) < 0.5 * nb->skin;
}
