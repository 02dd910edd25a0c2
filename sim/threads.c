#include "sim/threads.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "sim/memory.h"

/* Samples from here on are cut (docs/performance.md); a piece should be worth a few times the waking of a thread. */
enum { SMALLEST_SAMPLE = 10000, PARTICLES_PER_PIECE = 2500, PIECES_MAX = 32 };

/* Whole vectors and whole cache lines of every array. */
enum { ROWS_ALIGNMENT = 16 };

/* Of a row of sums, and of one value. */
static size_t row_bytes(const struct particles *p)
{
    return (size_t)ROW_BYTES(p->dimension, p->n_rotations > 0, p->single);
}

static size_t value_bytes(const struct particles *p)
{
    return p->single ? sizeof(float) : sizeof(double);
}

static enum status no_memory(void)
{
    return status_fail(STATUS_NO_MEMORY, "no memory for the sums of the threads");
}

/* Zeroed pages that cost nothing until they are touched. */
static enum status piece_init(struct threads_piece *piece, const struct particles *p)
{
    piece->memory = calloc(particles_force_size(p) + ARRAY_ALIGNMENT, 1);
    if (!piece->memory)
        return no_memory();
    size_t past = (uintptr_t)piece->memory % ARRAY_ALIGNMENT;
    piece->force = (char *)piece->memory + (past ? ARRAY_ALIGNMENT - past : 0);
    return STATUS_OK;
}

enum status threads_init(struct threads *threads, const struct particles *p, int64_t wanted)
{
    *threads = (struct threads){.n = 1, .n_pieces = 1};
    if (p->count < SMALLEST_SAMPLE)
        return STATUS_OK;
    threads->n_pieces = p->count / PARTICLES_PER_PIECE < PIECES_MAX ? p->count / PARTICLES_PER_PIECE : PIECES_MAX;
    int n = wanted > 0 ? (int)wanted : omp_get_num_procs();
    threads->n = n < threads->n_pieces ? n : threads->n_pieces;
#ifdef __SANITIZE_THREAD__
    threads->n = 1; /* the sanitizer does not see the barriers of OpenMP's library */
#endif
    threads->piece = calloc((size_t)threads->n_pieces, sizeof *threads->piece);
    threads->power = calloc((size_t)threads->n_pieces, sizeof *threads->power);
    if (!threads->piece || !threads->power)
        return no_memory();
    for (int k = 0; k < threads->n_pieces; k++)
        TRY(piece_init(&threads->piece[k], p));
    return STATUS_OK;
}

void threads_free(struct threads *threads)
{
    for (int k = 0; threads->piece && k < threads->n_pieces; k++)
        free(threads->piece[k].memory);
    free(threads->piece);
    free(threads->power);
    memset(threads, 0, sizeof *threads);
}

/* The k-th of n parts of 0 ... total, at a multiple of ROWS_ALIGNMENT but for the last. */
static int part_start(int k, int n, int total)
{
    return k == n ? total : (int)((int64_t)total * k / n / ROWS_ALIGNMENT * ROWS_ALIGNMENT);
}

/* Particles that the sets first ... last - 1 add to: [*lo, *hi]; the padding particle does not count. */
static void touched(const struct particles *p, const struct contact_list *pairs, int first, int last, int *lo, int *hi)
{
    const uint32_t stride = RECORD_STRIDE(p->dimension, p->n_rotations > 0, p->single);
    const int padding = particles_padding(p);
    *lo = p->count;
    *hi = 0;
    for (int set = first; set < last; set++) {
        int i = (int)pairs->slots.first[set];
        *lo = i < *lo ? i : *lo;
        *hi = i + SET_WIDTH - 1 > *hi ? i + SET_WIDTH - 1 : *hi;
        for (int k = set * SET_WIDTH; k < (set + 1) * SET_WIDTH; k++) {
            int j = (int)(pairs->slots.row[k] / stride);
            *lo = j < *lo ? j : *lo;
            *hi = j > *hi && j != padding ? j : *hi;
        }
    }
}

void threads_cut(struct threads *threads, const struct particles *p, const struct contact_list *pairs)
{
    const int n = threads->n_pieces;
    for (int k = 0; n > 1 && k < n; k++) {
        struct threads_piece *piece = &threads->piece[k];
        int lo, hi;
        piece->first_set = (int)((int64_t)pairs->n_sets * k / n);
        piece->last_set = (int)((int64_t)pairs->n_sets * (k + 1) / n);
        touched(p, pairs, piece->first_set, piece->last_set, &lo, &hi);
        piece->first_row = lo / ROWS_ALIGNMENT * ROWS_ALIGNMENT;
        hi = (hi / ROWS_ALIGNMENT + 1) * ROWS_ALIGNMENT;
        piece->last_row = hi < particles_padding(p) ? hi : particles_padding(p);
    }
}

/* Adds bytes from ... to - 1 of the piece's sums to the particles', and zeroes them. */
static void take_bytes(const struct threads_piece *piece, struct particles *p, size_t from, size_t to)
{
    particles_force_add(p, piece->force, from, to);
    memset((char *)piece->force + from, 0, to - from);
}

/* Sums of the pieces over particles first ... last - 1, rows and columns, in the order of the pieces. */
static void sum_rows(const struct threads *threads, struct particles *p, int first, int last)
{
    const size_t row = row_bytes(p), value = value_bytes(p), column = value * (size_t)p->n_rows;
    const size_t columns = PARTICLES_OWN_OFFSET(p->n_rows, p->dimension, p->n_rotations > 0, p->single);
    for (int k = 0; k < threads->n_pieces; k++) {
        const struct threads_piece *piece = &threads->piece[k];
        size_t from = (size_t)(first > piece->first_row ? first : piece->first_row);
        size_t to = (size_t)(last < piece->last_row ? last : piece->last_row);
        if (from >= to)
            continue;
        take_bytes(piece, p, from * row, to * row);
        for (int c = 0; c < p->dimension + p->n_rotations; c++)
            take_bytes(piece, p, columns + (size_t)c * column + from * value,
                       columns + (size_t)c * column + to * value);
    }
}

void threads_pair(struct threads *threads, const struct kernels *kernels, struct particles *p,
                  struct contact_list *pairs, const struct contact_law_constants *law, struct contact_losses *losses)
{
    const int n = threads->n_pieces;
    if (n == 1) {
        kernels->pair(p, pairs, 0, pairs->n_sets, law, p->force, losses);
        return;
    }
#pragma omp parallel num_threads(threads->n)
    {
#pragma omp for schedule(dynamic, 1)
        for (int k = 0; k < n; k++) {
            struct threads_piece *piece = &threads->piece[k];
            piece->losses = (struct contact_losses){0};
            kernels->pair(p, pairs, piece->first_set, piece->last_set, law, piece->force, &piece->losses);
        }
#pragma omp for schedule(static)
        for (int k = 0; k < n; k++)
            sum_rows(threads, p, part_start(k, n, p->count),
                     k + 1 == n ? particles_padding(p) : part_start(k + 1, n, p->count));
    }
    for (int k = 0; k < n; k++)
        contact_losses_add(losses, &threads->piece[k].losses);
}

/* The same particles, of which drift and kick treat the k-th part. */
static struct particles part_of(const struct threads *threads, const struct particles *p, int k)
{
    struct particles part = *p;
    part.from = part_start(k, threads->n_pieces, p->count);
    part.count = part_start(k + 1, threads->n_pieces, p->count);
    return part;
}

bool threads_drift(const struct threads *threads, const struct kernels *kernels, struct particles *p, double dt_s,
                   double reach_m)
{
    const int n = threads->n_pieces;
    if (n == 1)
        return kernels->drift(p, dt_s, reach_m);
    bool far = false;
#pragma omp parallel for schedule(static) num_threads(threads->n) reduction(|| : far)
    for (int k = 0; k < n; k++) {
        struct particles part = part_of(threads, p, k);
        far = kernels->drift(&part, dt_s, reach_m) || far;
    }
    return far;
}

static double sum_power(const struct threads *threads)
{
    double sum = 0;
    for (int k = 0; k < threads->n_pieces; k++)
        sum += threads->power[k];
    return sum;
}

double threads_kick(const struct threads *threads, const struct kernels *kernels, struct particles *p,
                    const struct kick_constants *constants)
{
    const int n = threads->n_pieces;
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
    const int n = threads->n_pieces;
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
