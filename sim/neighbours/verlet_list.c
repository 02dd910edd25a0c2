#include "sim/neighbours/verlet_list.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim/base/aligned_array.h"
#include "sim/neighbours/history_transfer.h"

/* Pieces of the search for each thread: some cells hold more than others. */
enum { PIECES_PER_THREAD = 4, PIECES_MAX = 256 };

/* The same bits in whatever order the particles are. */
static double mean_radius(const struct particles *p)
{
    double sum = 0;
    for (int i = 0; i < p->count; i++)
        sum += p->radius[p->slot[i]];
    return sum / p->count;
}

static enum status init_pieces(struct verlet_list *nb, const struct particles *p)
{
    const int n = PIECES_PER_THREAD * thread_team_in_use(nb->team);
    nb->n_pieces = !nb->team ? 1 : n < PIECES_MAX ? n : PIECES_MAX;
    nb->n_spans = (p->count + SPAN_WIDTH - 1) / SPAN_WIDTH;
    nb->piece = calloc((size_t)nb->n_pieces, sizeof *nb->piece);
    if (!nb->piece)
        return status_fail(STATUS_NO_MEMORY, "no memory for the search of neighbours");
    for (int k = 0; k < nb->n_pieces; k++)
        TRY(array_resize(&nb->piece[k].of_span, sizeof(int32_t), (size_t)nb->n_spans, 0));
    return array_resize(&nb->span_first, sizeof(int32_t), (size_t)nb->n_spans + 1, 0);
}

enum status verlet_list_init(struct verlet_list *nb, const struct particles *p, double skin_ratio,
                             const struct contact_model *model, enum instruction_set isa, struct thread_team *team)
{
    const double first_guess = 0.1;
    memset(nb, 0, sizeof *nb);
    nb->team = team;
    nb->spare_pairs.team = team;
    nb->mean_radius = mean_radius(p);
    nb->skin_fixed = skin_ratio * nb->mean_radius;
    nb->skin = skin_ratio > 0 ? nb->skin_fixed : first_guess * nb->mean_radius;
    nb->search = search_select(isa);
    nb->spare_pairs.model = nb->spare_wall.model = *model;
    TRY(cell_list_init(&nb->cells, p));
    TRY(init_pieces(nb, p));
    return array_resize(&nb->first_pair_of, sizeof(int32_t), (size_t)p->count + 2, 0);
}

static void free_piece(struct verlet_piece *piece)
{
    search_block_free(&piece->block);
    pair_buffer_free(&piece->found);
    free(piece->of_span);
}

void verlet_list_free(struct verlet_list *nb)
{
    cell_list_free(&nb->cells);
    for (int k = 0; nb->piece && k < nb->n_pieces; k++)
        free_piece(&nb->piece[k]);
    free(nb->piece);
    free(nb->span_first);
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

static enum status reserve_pairs(struct verlet_list *nb, int count, struct contact_list *list, int dimension)
{
    nb->half_sorted.count = 0;
    list->count = 0;
    TRY(pair_buffer_reserve(&nb->half_sorted, count));
    if (count > list->capacity)
        TRY(contact_list_reserve(list, count + count / 8 + 64, dimension));
    list->count = count;
    return STATUS_OK;
}

/* Counting sort of the pairs found, by j and then by i, into the list; first_pair_of becomes the rows of i. */
static void sort_pairs(struct verlet_list *nb, int n_particles, struct contact_list *list)
{
    struct pair_buffer *from = &nb->piece[0].found, *half = &nb->half_sorted;
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
}

static uint64_t pair_key(const struct contact_list *list, int k)
{
    return (uint64_t)(uint32_t)list->i[k] << 32 | (uint32_t)list->j[k];
}

/* The first member whose key is not less. */
static int first_of(const struct contact_list *list, uint64_t key)
{
    int lo = 0, hi = list->count;
    while (lo < hi) {
        const int middle = lo + (hi - lo) / 2;
        if (pair_key(list, middle) < key)
            lo = middle + 1;
        else
            hi = middle;
    }
    return lo;
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

/* Where the history of members first ... end - 1 of `to` comes from, both lists being sorted; those that `from` does
 * not have start from zero. */
static void find_known(struct verlet_list *nb, const struct contact_list *to, const struct contact_list *from,
                       int first, int end)
{
    int old = 0;
    if (first < end)
        old = first_of(from, pair_key(to, first));
    for (int k = first; k < end; k++) {
        uint64_t key = pair_key(to, k);
        while (old < from->count && pair_key(from, old) < key)
            old++;
        const bool known = old < from->count && pair_key(from, old) == key;
        nb->source[k] = known ? old : -1;
        old += known;
    }
}

/* A large list under construction. */
struct build {
    struct verlet_list *nb;
    const struct particles *particles;
    struct contact_list *to;
    const struct contact_list *from;
};

static void search_piece(void *context, int m)
{
    const struct build *build = context;
    struct verlet_list *nb = build->nb;
    struct verlet_piece *piece = &nb->piece[m];
    piece->found.count = 0;
    memset(piece->of_span, 0, (size_t)nb->n_spans * sizeof *piece->of_span);
    piece->status = search_block_reserve(&piece->block, &nb->cells, build->particles->count);
    if (piece->status == STATUS_OK)
        piece->status = nb->search.pairs(&nb->cells, nb->skin, m, nb->n_pieces, &piece->block, &piece->found);
    for (int k = 0; k < piece->found.count; k++)
        piece->of_span[piece->found.lo[k] / SPAN_WIDTH]++;
}

/* Counts become the places of the first pairs, span by span. STATUS_LIMIT if there are too many. */
static enum status count_pairs(struct verlet_list *nb)
{
    int64_t all = 0;
    for (int m = 0; m < nb->n_pieces; m++) {
        TRY(nb->piece[m].status);
        all += nb->piece[m].found.count;
    }
    if (all > INT32_MAX / 2)
        return status_fail(STATUS_LIMIT, "more than %d pairs are near each other", INT32_MAX / 2);
    int32_t before = 0;
    for (int s = 0; s < nb->n_spans; s++) {
        nb->span_first[s] = before;
        for (int m = 0; m < nb->n_pieces; m++) {
            const int32_t n = nb->piece[m].of_span[s];
            nb->piece[m].of_span[s] = before;
            before += n;
        }
    }
    nb->span_first[nb->n_spans] = before;
    return STATUS_OK;
}

static void scatter_piece(void *context, int m)
{
    const struct build *build = context;
    struct verlet_piece *piece = &build->nb->piece[m];
    struct pair_buffer *half = &build->nb->half_sorted;
    for (int k = 0; k < piece->found.count; k++) {
        const int to = piece->of_span[piece->found.lo[k] / SPAN_WIDTH]++;
        half->lo[to] = piece->found.lo[k];
        half->hi[to] = piece->found.hi[k];
    }
}

/* The few j of one i, rising. */
static void sort_row(int32_t *j, int n)
{
    for (int k = 1; k < n; k++) {
        const int32_t value = j[k];
        int to = k;
        for (; to > 0 && j[to - 1] > value; to--)
            j[to] = j[to - 1];
        j[to] = value;
    }
}

/* The pairs of span s: in order, with their reach and the place of their history. */
static void finish_span(void *context, int s)
{
    const struct build *build = context;
    struct verlet_list *nb = build->nb;
    struct contact_list *to = build->to;
    const int first = nb->span_first[s], end = nb->span_first[s + 1];
    int32_t next[SPAN_WIDTH + 2] = {0};
    for (int k = first; k < end; k++)
        next[nb->half_sorted.lo[k] % SPAN_WIDTH + 2]++;
    next[1] = first;
    for (int v = 1; v <= SPAN_WIDTH; v++)
        next[v + 1] += next[v];
    for (int k = first; k < end; k++) {
        const int32_t at = next[nb->half_sorted.lo[k] % SPAN_WIDTH + 1]++;
        to->i[at] = nb->half_sorted.lo[k];
        to->j[at] = nb->half_sorted.hi[k];
    }
    for (int v = 0, row = first; v < SPAN_WIDTH; row = next[++v])
        sort_row(to->j + row, next[v + 1] - row);
    if (first < end)
        nb->search.add(to->reach + first, build->particles->radius, to->i + first, to->j + first, end - first);
    find_known(nb, to, build->from, first, end);
}

/* By the team, the same list as by the caller alone. */
static enum status find_pairs_together(struct verlet_list *nb, const struct particles *p, struct contact_list *to,
                                       const struct contact_list *from)
{
    struct build build = {nb, p, to, from};
    thread_team_run(nb->team, nb->n_pieces, search_piece, &build);
    TRY(count_pairs(nb));
    TRY(reserve_pairs(nb, nb->span_first[nb->n_spans], to, p->dimension));
    TRY(reserve_source(nb, to->count));
    thread_team_run(nb->team, nb->n_pieces, scatter_piece, &build);
    thread_team_run(nb->team, nb->n_spans, finish_span, &build);
    return STATUS_OK;
}

static enum status find_pairs(struct verlet_list *nb, const struct particles *p, struct contact_list *to,
                              const struct contact_list *from)
{
    struct verlet_piece *all = &nb->piece[0];
    all->found.count = 0;
    TRY(search_block_reserve(&all->block, &nb->cells, p->count));
    TRY(nb->search.pairs(&nb->cells, nb->skin, 0, 1, &all->block, &all->found));
    TRY(reserve_pairs(nb, all->found.count, to, p->dimension));
    sort_pairs(nb, p->count, to);
    if (to->count)
        nb->search.add(to->reach, p->radius, to->i, to->j, to->count);
    TRY(reserve_source(nb, to->count));
    find_known(nb, to, from, 0, to->count);
    return STATUS_OK;
}

static void swap_lists(struct contact_list *a, struct contact_list *b)
{
    struct contact_list swap = *a;
    *a = *b;
    *b = swap;
}

/* One of the two lists is made at a time, and the working memory is needed for that alone. */
static void hand_over_work(struct contact_list *from, struct contact_list *to)
{
    free(to->scratch);
    to->scratch = from->scratch;
    to->scratch_size = from->scratch_size;
    from->scratch = NULL;
    from->scratch_size = 0;
}

static enum status build_pairs(struct verlet_list *nb, const struct particles *p, struct contact_list *pairs)
{
    struct contact_list *fresh = &nb->spare_pairs;
    if (pairs->scratch)
        hand_over_work(pairs, fresh);
    TRY(cell_list_sort(&nb->cells, p, nb->skin, nb->team));
    TRY(nb->team ? find_pairs_together(nb, p, fresh, pairs) : find_pairs(nb, p, fresh, pairs));
    fresh->search_max = pairs->search_max;
    TRY(history_transfer_close(fresh, p, NULL, pairs, nb->source, &nb->search));
    swap_lists(pairs, fresh);
    return STATUS_OK;
}

enum { NEAR_RANGES = 64 };

static int near_first(const struct particles *p, int k)
{
    return (int)((int64_t)p->count * k / NEAR_RANGES);
}

struct near_work {
    const struct particles *particles;
    const struct wall *wall;
    double skin;
    int32_t *near;
    int found[NEAR_RANGES]; /* of each range */
};

/* Of the k-th range, from its first place on. No branch in the loop: what to keep cannot be predicted. */
static void find_near_range(void *context, int k)
{
    struct near_work *work = context;
    const struct particles *p = work->particles;
    const struct wall *wall = work->wall;
    const double *x = p->x[wall->axis], *radius = p->radius;
    const int first = near_first(p, k), end = near_first(p, k + 1);
    int count = first;
    for (int i = first; i < end; i++) {
        work->near[count] = i;
        count += wall->inward * (x[i] - wall->x) - radius[i] < work->skin;
    }
    work->found[k] = count - first;
}

/* Particles closer to the wall than the skin, rising, into `near`, which has room for all; returns how many. */
static int find_near(struct verlet_list *nb, const struct particles *p, const struct wall *wall, int32_t *near)
{
    struct near_work work = {.particles = p, .wall = wall, .skin = nb->skin, .near = near};
    int count = 0;
    thread_team_run(nb->team, NEAR_RANGES, find_near_range, &work);
    for (int k = 0; k < NEAR_RANGES; k++) {
        memmove(near + count, near + near_first(p, k), (size_t)work.found[k] * sizeof *near);
        count += work.found[k];
    }
    return count;
}

static enum status build_wall(struct verlet_list *nb, const struct particles *p, struct wall *wall)
{
    struct contact_list *fresh = &nb->spare_wall;
    int32_t *near = nb->cells.by_cell; /* the grid is not needed any more */
    int count = find_near(nb, p, wall, near);
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
    TRY(reserve_source(nb, count));
    find_known(nb, fresh, &wall->contacts, 0, count);
    TRY(history_transfer_close(fresh, p, wall, &wall->contacts, nb->source, &nb->search));
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
