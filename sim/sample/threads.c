#include "sim/sample/threads.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "sim/base/aligned_array.h"

/* Pieces of the pairs: powers of two, so that each is two of the next number. Of a single span, pieces on both sides
 * would add to its sums at the same time. */
enum { PIECES_LEAST = 4, PIECES_MAX = PARTICLES_PADDINGS, SPANS_LEAST = 2 };
enum { NO_PIECE = -1, SEVERAL = -2 }; /* threads_part.piece: nobody has added yet; several at the same time do */

/* Spans that the sums of a part wait for, in the mean: if they are more, it has left the nearer caches before it is
 * complete, and going on with it at once gains nothing (docs/performance.md). */
static const double WAIT_MAX = 2;

static enum status no_memory(void)
{
    return status_fail(STATUS_NO_MEMORY, "no memory for the pieces of the threads");
}

enum status threads_init(struct threads *threads, const struct particles *p, int64_t wanted)
{
    *threads = (struct threads){.n = 1, .n_parts = 1, .n_cuts = 1};
    if (p->count < PARTICLES_LARGE_SAMPLE)
        return STATUS_OK;
    threads->n_parts = (p->count + SPAN_WIDTH - 1) / SPAN_WIDTH;
    const int n = wanted > TEAM_MAX ? TEAM_MAX : wanted > 0 ? (int)wanted : team_cpus();
    threads->n = n < threads->n_parts ? n : threads->n_parts;
    threads->choice = thread_choice_of(threads->n);
    TRY(team_create(&threads->team, threads->n));
    threads->piece = calloc(PIECES_MAX, sizeof *threads->piece);
    threads->part = calloc((size_t)threads->n_parts, sizeof *threads->part);
    return threads->piece && threads->part ? STATUS_OK : no_memory();
}

void threads_free(struct threads *threads)
{
    team_free(threads->team);
    free(threads->piece);
    free(threads->part);
    memset(threads, 0, sizeof *threads);
}

/* The rows that the k-th piece adds to, but for its padding particle, which is made its own: cores that share a line
 * of memory wait for each other. */
static void take_piece(struct threads_piece *piece, int k, const struct particles *p, struct contact_list *pairs)
{
    const uint32_t stride = RECORD_STRIDE(p->dimension, p->n_rotations > 0, p->single);
    const uint32_t padding = stride * (uint32_t)particles_padding(p),
                   own = stride * (uint32_t)particles_spare_padding(p, k);
    uint32_t lo = UINT32_MAX, hi = 0;
    uint32_t *row = pairs->slots.partner;
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
static void cut_pairs(struct threads *threads, const struct particles *p, struct contact_list *pairs)
{
    int n = PIECES_MAX;
    int64_t rows;
    threads->n_cuts = 1;
    threads->piece[0] = (struct threads_piece){.last_span = pairs->slots.n_spans, .hi = p->count - 1};
    while (n * SPANS_LEAST > pairs->slots.n_spans)
        n /= 2;
    if (n < PIECES_LEAST)
        return;
    for (int k = 0; k < n; k++) {
        struct threads_piece *piece = &threads->piece[k];
        piece->first_span = (int)((int64_t)pairs->slots.n_spans * k / n);
        piece->last_span = (int)((int64_t)pairs->slots.n_spans * (k + 1) / n);
        take_piece(piece, k, p, pairs);
    }
    for (; n > PIECES_LEAST && !(are_apart(threads, n, &rows) && rows < 3 * (int64_t)p->count / 2); n /= 2)
        join_pieces(threads, n);
    if (are_apart(threads, n, &rows))
        threads->n_cuts = n;
    else
        threads->piece[0] = (struct threads_piece){.last_span = pairs->slots.n_spans, .hi = p->count - 1};
}

/* Span s of piece k adds to the sums of a part; after all spans before it in the list. Odd pieces come after even ones,
 * and those of a kind at the same time. */
static void add_to(struct threads_part *part, int k, int s)
{
    if (part->piece != k && part->piece != NO_PIECE) {
        if (k % 2 < part->piece % 2)
            return;
        if (part->piece == SEVERAL || k % 2 == part->piece % 2) {
            part->piece = SEVERAL;
            return;
        }
    }
    part->piece = k;
    part->complete = s;
}

static void add_piece(struct threads *threads, int k, const struct particles *p, const struct contact_list *pairs)
{
    const uint32_t per_part = SPAN_WIDTH * RECORD_STRIDE(p->dimension, p->n_rotations > 0, p->single);
    const struct threads_piece *piece = &threads->piece[k];
    for (int s = piece->first_span; s < piece->last_span; s++) {
        const struct contact_span *span = &pairs->slots.span[s];
        add_to(&threads->part[s], k, s);
        for (int at = span->whole * SET_WIDTH; at < span->end * SET_WIDTH; at++) {
            const uint32_t part = pairs->slots.partner[at] / per_part;
            if (part < (uint32_t)threads->n_parts) /* padding may be behind all */
                add_to(&threads->part[part], k, s);
        }
    }
}

/* When the sums of each part are complete; the parts of a piece one after the other. */
static void find_complete(struct threads *threads, const struct particles *p, const struct contact_list *pairs)
{
    int64_t waits = 0;
    int last[PIECES_MAX] = {0};
    for (int q = 0; q < threads->n_parts; q++)
        threads->part[q] = (struct threads_part){.piece = NO_PIECE};
    for (int k = 0; k < threads->n_cuts; k++)
        add_piece(threads, k, p, pairs);
    for (int q = 0; q < threads->n_parts; q++) {
        struct threads_part *part = &threads->part[q];
        if (part->piece < 0)
            continue;
        last[part->piece] = last[part->piece] > part->complete ? last[part->piece] : part->complete;
        part->complete = last[part->piece];
        waits += part->complete > q ? part->complete - q : 0;
    }
    threads->sweeps = (double)waits <= WAIT_MAX * threads->n_parts;
}

void threads_cut(struct threads *threads, const struct particles *p, struct contact_list *pairs)
{
    if (threads->n_parts == 1)
        return;
    cut_pairs(threads, p, pairs);
    find_complete(threads, p, pairs);
}

/* The same particles, of which drift and kick treat part q. */
static struct particles part_of(const struct particles *p, int q)
{
    struct particles part = *p;
    part.from = q * SPAN_WIDTH;
    part.count = (q + 1) * SPAN_WIDTH < p->count ? (q + 1) * SPAN_WIDTH : p->count;
    return part;
}

/* What the threads are at work on. */
struct work {
    struct threads *threads;
    const struct kernels *kernels;
    struct particles *particles;
    struct contact_list *pairs;
    const struct contact_law_constants *law;
    double dt_s;
    const struct threads_sweep *sweep; /* NULL: pairs alone */
    int turn;                          /* pieces 2 k + turn */
};

static void advance_part(const struct work *work, int q)
{
    struct threads_part *part = &work->threads->part[q];
    const struct threads_sweep *sweep = work->sweep;
    struct particles particles = part_of(work->particles, q);
    part->far = work->kernels->advance(&particles, sweep->kick, sweep->dt_s, sweep->reach_m, &part->power);
}

/* The pairs of piece k, span by span; with a sweep also the parts that are complete with it. */
static void go_through_piece(const struct work *work, int k)
{
    struct threads_piece *piece = &work->threads->piece[k];
    const struct threads_part *part = work->threads->part;
    const int end = piece->hi / SPAN_WIDTH + 1;
    int q = piece->lo / SPAN_WIDTH;
    piece->losses = (struct contact_losses){0};
    for (int s = piece->first_span; s < piece->last_span; s++) {
        work->kernels->pair(work->particles, work->pairs, s, s + 1, work->law, work->dt_s, work->particles->force,
                            &piece->losses);
        for (; work->sweep && q < end && (part[q].piece != k || part[q].complete <= s); q++)
            if (part[q].piece == k)
                advance_part(work, q);
    }
}

static void go_through_turn(void *context, int k)
{
    const struct work *work = context;
    go_through_piece(work, 2 * k + work->turn);
}

/* All pieces, the even ones first. */
static void go_through_pieces(struct work *work, struct contact_losses *losses)
{
    struct threads *threads = work->threads;
    const int n = threads->n_cuts;
    for (work->turn = 0; work->turn < 2; work->turn++)
        team_run(threads->team, (n + 1 - work->turn) / 2, go_through_turn, work);
    for (int k = 0; k < n; k++)
        contact_losses_add(losses, &threads->piece[k].losses);
}

void threads_pair(struct threads *threads, const struct kernels *kernels, struct particles *p,
                  struct contact_list *pairs, const struct contact_law_constants *law, double dt_s,
                  struct contact_losses *losses)
{
    struct work work = {threads, kernels, p, pairs, law, dt_s, NULL, 0};
    if (threads->n_parts == 1)
        kernels->pair(p, pairs, 0, pairs->slots.n_spans, law, dt_s, p->force, losses);
    else
        go_through_pieces(&work, losses);
}

struct drift_work {
    struct threads *threads;
    const struct kernels *kernels;
    struct particles *particles;
    double dt_s, before_s, reach_m;
};

static void drift_part(void *context, int q)
{
    const struct drift_work *work = context;
    struct particles part = part_of(work->particles, q);
    work->threads->part[q].far = work->kernels->drift(&part, work->dt_s, work->before_s, work->reach_m);
}

static bool any_far(const struct threads *threads)
{
    bool far = false;
    for (int q = 0; q < threads->n_parts; q++)
        far = far || threads->part[q].far;
    return far;
}

bool threads_drift(struct threads *threads, const struct kernels *kernels, struct particles *p, double dt_s,
                   double before_s, double reach_m)
{
    struct drift_work work = {threads, kernels, p, dt_s, before_s, reach_m};
    if (threads->n_parts == 1)
        return kernels->drift(p, dt_s, before_s, reach_m);
    team_run(threads->team, threads->n_parts, drift_part, &work);
    return any_far(threads);
}

static double sum_power(const struct threads *threads)
{
    double sum = 0;
    for (int q = 0; q < threads->n_parts; q++)
        sum += threads->part[q].power;
    return sum;
}

struct kick_work {
    struct threads *threads;
    const struct kernels *kernels;
    struct particles *particles;
    const struct kick_constants *constants;
};

static void kick_part(void *context, int q)
{
    const struct kick_work *work = context;
    struct particles part = part_of(work->particles, q);
    work->threads->part[q].power = work->kernels->kick(&part, work->constants);
}

double threads_kick(struct threads *threads, const struct kernels *kernels, struct particles *p,
                    const struct kick_constants *constants)
{
    struct kick_work work = {threads, kernels, p, constants};
    if (threads->n_parts == 1)
        return kernels->kick(p, constants);
    team_run(threads->team, threads->n_parts, kick_part, &work);
    return sum_power(threads);
}

/* Parts that no piece has gone on with: all, without a sweep. */
static void advance_if_left(void *context, int q)
{
    const struct work *work = context;
    const struct threads *threads = work->threads;
    if (!threads->sweeps || threads->part[q].piece < 0)
        advance_part(work, q);
}

static double now_s(void)
{
    struct timespec t;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

bool threads_sweep(struct threads *threads, const struct kernels *kernels, struct particles *p,
                   struct contact_list *pairs, const struct threads_sweep *sweep, struct contact_losses *losses,
                   double *background_w)
{
    struct work work = {threads, kernels, p, pairs, sweep->law, sweep->dt_s, threads->sweeps ? sweep : NULL, 0},
                rest = {threads, kernels, p, pairs, sweep->law, sweep->dt_s, sweep, 0};
    if (threads->n_parts == 1) {
        kernels->pair(p, pairs, 0, pairs->slots.n_spans, sweep->law, sweep->dt_s, p->force, losses);
        return kernels->advance(p, sweep->kick, sweep->dt_s, sweep->reach_m, background_w);
    }
    const double start = now_s();
    go_through_pieces(&work, losses);
    team_run(threads->team, threads->n_parts, advance_if_left, &rest);
    *background_w = sum_power(threads);
    thread_choice_step(&threads->choice, now_s() - start);
    team_use(threads->team, threads->choice.use);
    return any_far(threads);
}
