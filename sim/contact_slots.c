/* The kernels' order of the contacts (contacts.h): who gets which slot, and the history's way there and back. */
#include <stdlib.h>
#include <string.h>

#include "sim/contacts.h"
#include "sim/memory.h"

/* Pairs are dealt out to their members so that the SET_WIDTH particles of a block have about as many each, for slots
 * that stay empty cost as much as full ones. */
struct deal {
    const struct contact_list *pairs;
    int n_particles, n_blocks;
    int32_t *of_j;    /* [count] 1: the pair is j's, 0: it is i's */
    int32_t *n_own;   /* [n_particles] pairs that a particle has */
    int32_t *planned; /* [n_blocks] sets */
    int32_t *first;   /* [n_particles + 1] range in `pair`: the pairs that a particle is in */
    int32_t *pair;    /* [2 count] */
    int32_t *seen;    /* [n_particles] by which search */
    int32_t *through; /* [n_particles] the pair that led there */
    int32_t *queue;   /* [SEARCH_MAX] */
    int32_t *set;     /* [n_blocks + 1] first set */
};
enum { SEARCH_MAX = 128 };

static enum status deal_init(struct deal *deal, struct contact_list *pairs, int n_particles)
{
    const size_t m = (size_t)pairs->count, n = (size_t)n_particles;
    const size_t blocks = (n + SET_WIDTH - 1) / SET_WIDTH, size = 3 * m + 4 * n + 2 * blocks + SEARCH_MAX + 2;
    if (size > pairs->scratch_size) {
        TRY(array_resize(&pairs->scratch, sizeof(int32_t), size + size / 8, 0));
        pairs->scratch_size = size + size / 8;
    }
    int32_t *at = pairs->scratch;
    *deal = (struct deal){.pairs = pairs, .n_particles = n_particles, .n_blocks = (int)blocks};
    deal->of_j = at;
    deal->pair = at += m;
    deal->n_own = at += 2 * m;
    deal->seen = at += n;
    deal->through = at += n;
    deal->first = at += n;
    deal->planned = at += n + 1;
    deal->set = at += blocks;
    deal->queue = at + blocks + 1;
    return STATUS_OK;
}

static int excess(const struct deal *deal, int particle)
{
    return deal->n_own[particle] - deal->planned[particle / SET_WIDTH];
}

/* Which pairs each particle is in, and from that how many sets each block should have: half its pairs' ends, and the
 * rounding is passed on, so that blocks of 2 and of 3 sets take turns if 2.5 are needed. */
static void plan(struct deal *deal)
{
    const struct contact_list *pairs = deal->pairs;
    int32_t *first = deal->first;
    memset(first, 0, (size_t)(deal->n_particles + 1) * sizeof *first);
    for (int k = 0; k < pairs->count; k++) {
        first[pairs->i[k]]++;
        first[pairs->j[k]]++;
    }
    for (int i = 1; i <= deal->n_particles; i++)
        first[i] += first[i - 1];
    for (int k = pairs->count - 1; k >= 0; k--) { /* from the back, so that first[i] ends where i's pairs start */
        deal->pair[--first[pairs->i[k]]] = k;
        deal->pair[--first[pairs->j[k]]] = k;
    }
    const double spare = 1.01;
    double wanted = 0.5;
    for (int b = 0; b < deal->n_blocks; b++) {
        int end = (b + 1) * SET_WIDTH < deal->n_particles ? (b + 1) * SET_WIDTH : deal->n_particles;
        wanted += spare * (first[end] - first[b * SET_WIDTH]) / (2.0 * SET_WIDTH);
        deal->planned[b] = (int32_t)wanted;
        wanted -= deal->planned[b];
    }
}

static void deal_greedily(struct deal *deal)
{
    const struct contact_list *pairs = deal->pairs;
    memset(deal->n_own, 0, (size_t)deal->n_particles * sizeof *deal->n_own);
    for (int k = 0; k < pairs->count; k++) {
        int i = pairs->i[k], j = pairs->j[k];
        deal->of_j[k] = excess(deal, j) < excess(deal, i);
        deal->n_own[deal->of_j[k] ? j : i]++;
    }
}

/* Passes one pair on from `from` along a chain of particles that each pass one on, to one that has room; the nearest
 * first. False if none is found. */
static bool pass_on(struct deal *deal, int from, int search)
{
    const struct contact_list *pairs = deal->pairs;
    const int most = pairs->search_max > 0 && pairs->search_max < SEARCH_MAX ? pairs->search_max : SEARCH_MAX;
    int n = 0;
    deal->queue[n++] = from;
    deal->seen[from] = search;
    for (int q = 0; q < n; q++) {
        int at = deal->queue[q];
        for (int m = deal->first[at]; m < deal->first[at + 1]; m++) {
            int k = deal->pair[m], i = pairs->i[k], j = pairs->j[k];
            int next = at == i ? j : i;
            if ((deal->of_j[k] ? j : i) != at || deal->seen[next] == search)
                continue;
            deal->seen[next] = search;
            deal->through[next] = k;
            if (excess(deal, next) < 0) {
                deal->n_own[next]++;
                deal->n_own[from]--;
                while (next != from) {
                    k = deal->through[next];
                    next = next == pairs->i[k] ? pairs->j[k] : pairs->i[k];
                    deal->of_j[k] ^= 1;
                }
                return true;
            }
            if (n < most)
                deal->queue[n++] = next;
        }
    }
    return false;
}

static void even_out(struct deal *deal)
{
    int search = 0;
    memset(deal->seen, 0, (size_t)deal->n_particles * sizeof *deal->seen);
    for (int i = 0; i < deal->n_particles; i++)
        while (excess(deal, i) > 0)
            if (!pass_on(deal, i, ++search))
                deal->planned[i / SET_WIDTH]++;
}

/* Gives each pair its slot; the sets of a block follow each other. */
static void number_slots(struct deal *deal, struct contact_list *list)
{
    memset(deal->planned, 0, (size_t)deal->n_blocks * sizeof *deal->planned);
    for (int i = 0; i < deal->n_particles; i++)
        if (deal->n_own[i] > deal->planned[i / SET_WIDTH])
            deal->planned[i / SET_WIDTH] = deal->n_own[i];
    deal->set[0] = 0;
    for (int b = 0; b < deal->n_blocks; b++)
        deal->set[b + 1] = deal->set[b] + deal->planned[b];
    memset(deal->n_own, 0, (size_t)deal->n_particles * sizeof *deal->n_own);
    for (int k = 0; k < list->count; k++) {
        int owner = deal->of_j[k] ? list->j[k] : list->i[k];
        int set = deal->set[owner / SET_WIDTH] + deal->n_own[owner]++;
        list->slot[k] = 2 * (uint32_t)(set * SET_WIDTH + owner % SET_WIDTH) + (uint32_t)deal->of_j[k];
    }
    list->n_sets = deal->set[deal->n_blocks];
}

static enum status slots_reserve(struct contact_list *list)
{
    struct contact_slots *slots = &list->slots;
    const size_t real = list->single ? sizeof(float) : sizeof(double);
    const int read_ahead = 3; /* by the pair kernels */
    if (list->n_sets + read_ahead <= slots->capacity)
        return STATUS_OK;
    size_t sets = (size_t)list->n_sets + (size_t)list->n_sets / 8 + (size_t)read_ahead;
    size_t size = sets * SET_WIDTH;
    TRY(array_resize(&slots->first, sizeof *slots->first, sets, 0));
    TRY(array_resize(&slots->row, sizeof *slots->row, size, 0));
    TRY(array_resize(&slots->reach2, sizeof *slots->reach2, size, 0));
    TRY(array_resize(&slots->reach, real, size, 0));
    if (list->hysteretic)
        TRY(array_resize(&slots->history, real, size, 0));
    for (int c = 0; c < list->n_springs; c++) {
        TRY(array_resize(&slots->spring[c], real, size, 0));
        TRY(array_resize(&slots->rest[c], real, size, 0));
    }
    if (list->n_springs)
        TRY(array_resize(&slots->sliding, real, size, 0));
    slots->capacity = (int)sets;
    return STATUS_OK;
}

static void put(const struct contact_list *list, void *array, size_t slot, double value)
{
    if (list->single)
        ((float *)array)[slot] = (float)value;
    else
        ((double *)array)[slot] = value;
}

static double get(const struct contact_list *list, const void *array, size_t slot)
{
    return list->single ? ((const float *)array)[slot] : ((const double *)array)[slot];
}

/* The spring of i against j, for j's slot the other way round: a vector in 3D, a number along a tangent that turns with
 * the pair in 2D. */
static double sign_of(const struct contact_list *list, int k)
{
    return list->n_springs == 3 && list->slot[k] % 2 ? -1 : 1;
}

static void empty_slots(struct contact_list *list, uint32_t padding_row, double nothing)
{
    const size_t size = (size_t)list->n_sets * SET_WIDTH, real = list->single ? sizeof(float) : sizeof(double);
    struct contact_slots *slots = &list->slots;
    for (size_t s = 0; s < size; s++) {
        slots->row[s] = padding_row;
        slots->reach2[s] = nothing;
    }
    if (list->hysteretic)
        memset(slots->history, 0, real * size);
    if (list->n_springs)
        memset(slots->sliding, 0, real * size);
    for (int c = 0; c < list->n_springs; c++) {
        memset(slots->spring[c], 0, real * size);
        memset(slots->rest[c], 0, real * size);
    }
    memset(slots->reach, 0, real * size);
}

static void fill_slots(struct contact_list *list, bool wall, uint32_t stride)
{
    struct contact_slots *slots = &list->slots;
    for (int k = 0; k < list->count; k++) {
        const size_t s = list->slot[k] / 2;
        const int j = wall || list->slot[k] % 2 ? list->i[k] : list->j[k];
        slots->row[s] = stride * (uint32_t)j;
        slots->reach2[s] = wall ? list->reach[k] : list->reach[k] * list->reach[k];
        put(list, slots->reach, s, list->reach[k]);
        if (list->hysteretic)
            put(list, slots->history, s, list->history[k]);
        if (list->n_springs)
            put(list, slots->sliding, s, list->sliding[k]);
        for (int c = 0; c < list->n_springs; c++) {
            put(list, slots->spring[c], s, sign_of(list, k) * list->spring[c][k]);
            put(list, slots->rest[c], s, sign_of(list, k) * list->rest[c][k]);
        }
    }
}

static enum status assign(struct contact_list *list, bool wall, int n_particles)
{
    struct deal deal;
    if (wall) {
        list->n_sets = (list->count + SET_WIDTH - 1) / SET_WIDTH;
        for (int k = 0; k < list->count; k++)
            list->slot[k] = 2 * (uint32_t)k;
        return slots_reserve(list);
    }
    TRY(deal_init(&deal, list, n_particles));
    plan(&deal);
    deal_greedily(&deal);
    even_out(&deal);
    number_slots(&deal, list);
    TRY(slots_reserve(list));
    for (int b = 0; b < deal.n_blocks; b++)
        for (int set = deal.set[b]; set < deal.set[b + 1]; set++)
            list->slots.first[set] = (uint32_t)(SET_WIDTH * b);
    return STATUS_OK;
}

enum status contact_list_close(struct contact_list *list, const struct particles *particles)
{
    const uint32_t stride = RECORD_STRIDE(particles->dimension, particles->n_rotations > 0, particles->single);
    const bool wall = list->count > 0 && list->j[0] >= particles->count;
    if (list->count > INT32_MAX / (4 * SET_WIDTH))
        return status_fail(STATUS_LIMIT, "%d candidates for contact are too many", list->count);
    list->n_sets = 0;
    list->closed = true;
    if (list->count == 0)
        return STATUS_OK;
    TRY(assign(list, wall, particles->count));
    /* nothing: no reach, and for walls less than none, for they know no distance to the padding particle */
    empty_slots(list, stride * (uint32_t)particles_padding(particles), wall ? -1e30 : 0);
    fill_slots(list, wall, stride);
    return STATUS_OK;
}

double contact_list_history(const struct contact_list *list, int k)
{
    return list->closed ? get(list, list->slots.history, list->slot[k] / 2) : list->history[k];
}

double contact_list_spring(const struct contact_list *list, int c, int k)
{
    if (!list->closed)
        return list->spring[c][k] + list->rest[c][k];
    const size_t s = list->slot[k] / 2;
    return sign_of(list, k) * (get(list, list->slots.spring[c], s) + get(list, list->slots.rest[c], s));
}

bool contact_list_slides(const struct contact_list *list, int k)
{
    return (list->closed ? get(list, list->slots.sliding, list->slot[k] / 2) : list->sliding[k]) > 0;
}

void contact_list_read(struct contact_list *list)
{
    const struct contact_slots *slots = &list->slots;
    for (int k = 0; list->closed && k < list->count; k++) {
        const size_t s = list->slot[k] / 2;
        if (list->hysteretic)
            list->history[k] = get(list, slots->history, s);
        if (list->n_springs)
            list->sliding[k] = get(list, slots->sliding, s);
        for (int c = 0; c < list->n_springs; c++) {
            list->spring[c][k] = sign_of(list, k) * get(list, slots->spring[c], s);
            list->rest[c][k] = sign_of(list, k) * get(list, slots->rest[c], s);
        }
    }
}
