#include "sim/threads.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "sim/memory.h"

/* Samples from here on are cut (docs/performance.md); a part should be worth a few times the waking of a thread. */
enum { PARTICLES_PER_PART = 2500, PARTS_MAX = 32 };

/* Pieces of the pairs: powers of two, so that each is two of the next number. */
enum { PIECES_LEAST = 4, PIECES_MAX = PARTICLES_PADDINGS };

/* Whole vectors and whole cache lines of every array. */
enum { ROWS_ALIGNMENT = 16 };

static enum status no_memory(void)
{
    return status_fail(STATUS_NO_MEMORY, "no memory for the pieces of the threads");
}

enum status threads_init(struct threads *threads, const struct particles *p, int64_t wanted)
{
    *threads = (struct threads){.n = 1, .n_parts = 1, .n_cuts = 1};
    if (p->count < PARTICLES_LARGE_SAMPLE)
        return STATUS_OK;
    threads->n_parts = p->count / PARTICLES_PER_PART < PARTS_MAX ? p->count / PARTICLES_PER_PART : PARTS_MAX;
    int n = wanted > 0 ? (int)wanted : omp_get_num_procs();
    threads->n = n < threads->n_parts ? n : threads->n_parts;
#ifdef __SANITIZE_THREAD__
    threads->n = 1; /* the sanitizer does not see the barriers of OpenMP's library */
#endif
    threads->piece = calloc(PIECES_MAX, sizeof *threads->piece);
    threads->power = calloc((size_t)threads->n_parts, sizeof *threads->power);
    return threads->piece && threads->power ? STATUS_OK : no_memory();
}

void threads_free(struct threads *threads)
{
    free(threads->piece);
    free(threads->power);
    memset(threads, 0, sizeof *threads);
}

/* The k-th of n parts of 0 ... total, at a multiple of ROWS_ALIGNMENT but for the last. */
static int part_start(int k, int n, int total)
{
    return k == n ? total : (int)((int64_t)total * k / n / ROWS_ALIGNMENT * ROWS_ALIGNMENT);
}

/* The rows that the k-th piece adds to, but for its padding particle, which is made its own: cores that share a line
 * of memory wait for each other. */
static void take_piece(struct threads_piece *piece, int k, const struct particles *p, struct contact_list *pairs)
{
    const uint32_t stride = RECORD_STRIDE(p->dimension, p->n_rotations > 0, p->single);
    const uint32_t padding = stride * (uint32_t)particles_padding(p),
                   own = stride * (uint32_t)particles_own_padding(p, k);
    uint32_t lo = UINT32_MAX, hi = 0;
    uint32_t *row = pairs->slots.row;
    const struct contact_span *first = &pairs->slots.span[piece->first_span],
                              *last = &pairs->slots.span[piece->last_span - 1];
    for (int s = first->next * SET_WIDTH; s < last->end * SET_WIDTH; s++) {
        const bool empty = row[s] == padding;
        lo = row[s] < lo ? row[s] : lo;
        hi = !empty && row[s] > hi ? row[s] : hi;
        row[s] = empty ? own : row[s];
    }
    piece->lo = (int)(lo / stride) < first->first ? (int)(lo / stride) : first->first;
    piece->hi = (int)(hi / stride) >= last->last ? (int)(hi / stride) : last->last - 1;
}

/* Whether pieces that are at work at the same time have nothing in common; and how often the rows would be read, which
 * is more than once where pieces meet [rows]. */
static bool are_apart(const struct threads *threads, int n, int64_t *rows)
{
    bool apart = true;
    *rows = 0;
    for (int k = 0; k < n; k++) {
        const struct threads_piece *piece = &threads->piece[k];
        *rows += piece->hi - piece->lo + 1;
        for (int m = k + 2; m < n; m += 2)
            apart = apart && piece->hi < threads->piece[m].lo;
    }
    return apart;
}

/* Two pieces become one. */
static void join_pieces(struct threads *threads, int n)
{
    for (int k = 0; k < n / 2; k++) {
        const struct threads_piece a = threads->piece[2 * k], b = threads->piece[2 * k + 1];
        threads->piece[k] = (struct threads_piece){.first_span = a.first_span,
                                                   .last_span = b.last_span,
                                                   .lo = a.lo < b.lo ? a.lo : b.lo,
                                                   .hi = a.hi > b.hi ? a.hi : b.hi};
    }
}

/* As many pieces as are apart and add no more than half to the rows read; but at least a few. */
void threads_cut(struct threads *threads, const struct particles *p, struct contact_list *pairs)
{
    int n = PIECES_MAX;
    int64_t rows;
    threads->n_cuts = 1;
    while (n > pairs->slots.n_spans)
        n /= 2;
    if (threads->n_parts == 1 || n < PIECES_LEAST)
        return;
    for (int k = 0; k < n; k++) {
        struct threads_piece *piece = &threads->piece[k];
        piece->first_span = (int)((int64_t)pairs->slots.n_spans * k / n);
        piece->last_span = (int)((int64_t)pairs->slots.n_spans * (k + 1) / n);
        take_piece(piece, k, p, pairs);
    }
    for (; n > PIECES_LEAST && !(are_apart(threads, n, &rows) && rows < 3 * (int64_t)p->count / 2); n /= 2)
        join_pieces(threads, n);
    threads->n_cuts = are_apart(threads, n, &rows) ? n : 1;
}

void threads_pair(struct threads *threads, const struct kernels *kernels, struct particles *p,
                  struct contact_list *pairs, const struct contact_law_constants *law, struct contact_losses *losses)
{
    const int n = threads->n_cuts;
    if (n == 1) {
        kernels->pair(p, pairs, 0, pairs->slots.n_spans, law, p->force, losses);
        return;
    }
#pragma omp parallel num_threads(threads->n)
    for (int turn = 0; turn < 2; turn++) {
#pragma omp for schedule(dynamic, 1)
        for (int k = turn; k < n; k += 2) {
            struct threads_piece *piece = &threads->piece[k];
            piece->losses = (struct contact_losses){0};
            kernels->pair(p, pairs, piece->first_span, piece->last_span, law, p->force, &piece->losses);
        }
    }
    for (int k = 0; k < n; k++)
        contact_losses_add(losses, &threads->piece[k].losses);
}

/* The same particles, of which drift and kick treat the k-th part. */
static struct particles part_of(const struct threads *threads, const struct particles *p, int k)
{
    struct particles part = *p;
    part.from = part_start(k, threads->n_parts, p->count);
    part.count = part_start(k + 1, threads->n_parts, p->count);
    return part;
}

bool threads_drift(const struct threads *threads, const struct kernels *kernels, struct particles *p, double dt_s,
                   double before_s, double reach_m)
{
    const int n = threads->n_parts;
    if (n == 1)
        return kernels->drift(p, dt_s, before_s, reach_m);
    bool far = false;
#pragma omp parallel for schedule(static) num_threads(threads->n) reduction(|| : far)
    for (int k = 0; k < n; k++) {
        struct particles part = part_of(threads, p, k);
        far = kernels->drift(&part, dt_s, before_s, reach_m) || far;
    }
    return far;
}

static double sum_power(const struct threads *threads)
{
    double sum = 0;
    for (int k = 0; k < threads->n_parts; k++)
        sum += threads->power[k];
    return sum;
}

double threads_kick(const struct threads *threads, const struct kernels *kernels, struct particles *p,
                    const struct kick_constants *constants)
{
    const int n = threads->n_parts;
    if (n == 1)
        return kernels->kick(p, constants);
#pragma omp parallel for schedule(static) num_threads(threads->n)
    for (int k = 0; k < n; k++) {
        struct particles part = part_of(threads, p, k);
        threads->power[k] = kernels->kick(&part, constants);
    }
    return sum_power(threads);
}

bool threads_advance(const struct threads *threads, const struct kernels *kernels, struct particles *p,
                     const struct kick_constants *constants, double dt_s, double reach_m, double *background_w)
{
    const int n = threads->n_parts;
    if (n == 1)
        return kernels->advance(p, constants, dt_s, reach_m, background_w);
    bool far = false;
#pragma omp parallel for schedule(static) num_threads(threads->n) reduction(|| : far)
    for (int k = 0; k < n; k++) {
        struct particles part = part_of(threads, p, k);
        far = kernels->advance(&part, constants, dt_s, reach_m, &threads->power[k]) || far;
    }
    *background_w = sum_power(threads);
    return far;
}
