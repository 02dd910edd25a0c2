#include "sim/sample/threads.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "sim/base/aligned_array.h"

static enum status no_memory(void)
{
    return status_fail(STATUS_NO_MEMORY, "no memory for the parts of the threads");
}

enum status threads_init(struct threads *threads, const struct particles *p, int64_t wanted)
{
    *threads = (struct threads){.n = 1, .n_parts = 1};
    if (p->count < PARTICLES_LARGE_SAMPLE)
        return STATUS_OK;
    threads->n_parts = (p->count + SPAN_WIDTH - 1) / SPAN_WIDTH;
    const int n = wanted > TEAM_MAX ? TEAM_MAX : wanted > 0 ? (int)wanted : thread_team_cpus();
    threads->n = n < threads->n_parts ? n : threads->n_parts;
    threads->choice = thread_choice_of(threads->n);
    TRY(thread_team_create(&threads->team, threads->n));
    TRY(halo_init(&threads->halo, threads->n_parts));
    threads->losses = calloc((size_t)threads->halo.blocks_max, sizeof *threads->losses);
    threads->part = calloc((size_t)threads->n_parts, sizeof *threads->part);
    return threads->losses && threads->part ? STATUS_OK : no_memory();
}

void threads_free(struct threads *threads)
{
    thread_team_free(threads->team);
    halo_free(&threads->halo);
    free(threads->losses);
    free(threads->part);
    free(threads->piece);
    memset(threads, 0, sizeof *threads);
}

static int pieces_of(const struct wall *wall)
{
    return (wall->contacts.n_sets + THREADS_PIECE_SETS - 1) / THREADS_PIECE_SETS;
}

/* Whether two sorted lists have no particle in common. */
static bool are_apart(const struct contact_list *a, const struct contact_list *b)
{
    for (int k = 0, m = 0; k < a->count && m < b->count;) {
        if (a->i[k] == b->i[m])
            return false;
        if (a->i[k] < b->i[m])
            k++;
        else
            m++;
    }
    return true;
}

enum status threads_cut(struct threads *threads, struct particles *p, struct contact_list *pairs,
                        const struct wall *walls, int n_walls)
{
    int pieces = 0;
    if (threads->n_parts <= 1)
        return STATUS_OK;
    for (int w = 0; w < n_walls; w++)
        pieces += pieces_of(&walls[w]);
    if (pieces > threads->piece_capacity) {
        threads->piece_capacity = 0;
        TRY(array_resize(&threads->piece, sizeof *threads->piece, 2 * (size_t)pieces, 0));
        threads->piece_capacity = 2 * pieces;
    }
    for (int w = 0; w + 1 < n_walls; w += 2)
        threads->apart[w / 2] = are_apart(&walls[w].contacts, &walls[w + 1].contacts);
    return halo_cut(&threads->halo, threads->team, p, pairs);
}

/* The same particles, of which drift and kick treat part q. */
static struct particles part_of(const struct particles *p, int q)
{
    struct particles part = *p;
    part.from = q * SPAN_WIDTH;
    part.count = (q + 1) * SPAN_WIDTH < p->count ? (q + 1) * SPAN_WIDTH : p->count;
    return part;
}

static double now_s(void)
{
    struct timespec t;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
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
    int members;                       /* threads at work */
};

static void advance_part(void *context, int q)
{
    const struct work *work = context;
    struct threads_part *part = &work->threads->part[q];
    const struct threads_sweep *sweep = work->sweep;
    struct particles particles = part_of(work->particles, q);
    part->far = work->kernels->advance(&particles, sweep->kick, sweep->dt_s, sweep->reach_m, &part->power);
}

static void complete_part(void *context, int q)
{
    const struct work *work = context;
    halo_add(&work->threads->halo, work->particles, q);
    if (work->sweep)
        advance_part(context, q);
}

static void complete_late_part(void *context, int q)
{
    const struct work *work = context;
    if (work->threads->part[q].late)
        complete_part(context, q);
}

/* The member whose share block b is in (team.c). */
static int member_of(const struct work *work, int b)
{
    return (int)(((int64_t)work->members * (b + 1) - 1) / work->threads->halo.n_blocks);
}

/* The sums of part q are complete if this was the last of the blocks that add to them: then nobody looks at its
 * particles any more, as these blocks are those that have copies of them. Those of another member's blocks are left
 * to it, as its caches have them. */
static void finish_part(void *context, int b, int q)
{
    const struct work *work = context;
    const struct halo *halo = &work->threads->halo;
    struct halo_part *part = &work->threads->halo.part[q];
    if (atomic_fetch_sub(&part->left, 1) > 1)
        return;
    atomic_store_explicit(&part->left, part->blocks, memory_order_relaxed);
    const bool late = member_of(work, b) != member_of(work, q / halo->spans_per_block);
    work->threads->part[q].late = late;
    if (!late)
        complete_part(context, q);
}

/* The pairs of block b, and the parts that are complete with it: those are still in the caches. */
static void go_through_block(void *context, int b)
{
    const struct work *work = context;
    const struct halo_block *block = &work->threads->halo.block[b];
    const double start = work->threads->block_s ? now_s() : 0;
    work->threads->losses[b] = (struct contact_losses){0};
    halo_fetch(&work->threads->halo, work->particles, b);
    work->kernels->pair(work->particles, work->pairs, block->first_span, block->last_span, work->law, work->dt_s,
                        work->particles->force, &work->threads->losses[b]);
    for (int k = 0; k < block->n_parts; k++)
        finish_part(context, b, block->part[k]);
    if (work->threads->block_s)
        work->threads->block_s[b] = now_s() - start;
}

static void go_through_all(struct work *work, struct contact_losses *losses)
{
    const struct halo *halo = &work->threads->halo;
    if (halo->n_blocks == 1) {
        work->kernels->pair(work->particles, work->pairs, 0, work->pairs->slots.n_spans, work->law, work->dt_s,
                            work->particles->force, losses);
        if (work->sweep)
            thread_team_run(work->threads->team, work->threads->n_parts, advance_part, work);
        return;
    }
    work->members = thread_team_in_use(work->threads->team);
    thread_team_run(work->threads->team, halo->n_blocks, go_through_block, work);
    if (work->members > 1)
        thread_team_run(work->threads->team, work->threads->n_parts, complete_late_part, work);
    for (int b = 0; b < halo->n_blocks; b++)
        contact_losses_add(losses, &work->threads->losses[b]);
}

void threads_pair(struct threads *threads, const struct kernels *kernels, struct particles *p,
                  struct contact_list *pairs, const struct contact_law_constants *law, double dt_s,
                  struct contact_losses *losses)
{
    struct work work = {threads, kernels, p, pairs, law, dt_s, NULL, 1};
    if (threads->n_parts == 1)
        kernels->pair(p, pairs, 0, pairs->slots.n_spans, law, dt_s, p->force, losses);
    else
        go_through_all(&work, losses);
}

/* One wall, or two that have no particle in common. */
struct wall_work {
    const struct kernels *kernels;
    struct particles *particles;
    const struct wall *walls;
    int n_walls;
    const struct contact_law_constants *law;
    double dt_s;
    struct threads_piece *piece;
};

static void *skip(void *array, size_t count, bool mixed)
{
    return array ? (char *)array + count * (mixed ? sizeof(float) : sizeof(double)) : NULL;
}

/* The same wall with the contacts of its k-th piece alone. */
static struct wall piece_of(const struct wall *wall, int k)
{
    struct wall piece = *wall;
    struct contact_slots *slots = &piece.contacts.slots;
    const int rest = wall->contacts.n_sets - k * THREADS_PIECE_SETS;
    const size_t first = (size_t)k * THREADS_PIECE_SETS * SET_WIDTH;
    const bool mixed = wall->contacts.model.mixed;
    piece.contacts.n_sets = rest < THREADS_PIECE_SETS ? rest : THREADS_PIECE_SETS;
    slots->partner += first;
    slots->gap = skip(slots->gap, first, true);
    slots->reach = skip(slots->reach, first, mixed);
    for (int c = 0; c < PAIR_CONSTANTS; c++)
        slots->pair[c] = skip(slots->pair[c], first, mixed);
    for (int c = 0; c < HISTORY_COLUMNS; c++)
        slots->history[c] = skip(slots->history[c], first, mixed);
    return piece;
}

static void go_along_wall(void *context, int k)
{
    const struct wall_work *work = context;
    struct threads_piece *piece = &work->piece[k];
    const int of_first = pieces_of(&work->walls[0]);
    struct wall wall = k < of_first ? piece_of(&work->walls[0], k) : piece_of(&work->walls[1], k - of_first);
    piece->losses = (struct contact_losses){0};
    work->kernels->wall(work->particles, &wall, work->law, work->dt_s, &piece->losses);
    piece->force = wall.force;
    piece->touching = wall.touching;
}

/* The pieces' sums, in their order. */
static const struct threads_piece *add_pieces(const struct threads_piece *piece, struct wall *wall,
                                              struct contact_losses *losses)
{
    wall->force = 0;
    wall->touching = 0;
    for (int k = pieces_of(wall); k > 0; k--, piece++) {
        wall->force += piece->force;
        wall->touching += piece->touching;
        contact_losses_add(losses, &piece->losses);
    }
    return piece;
}

void threads_walls(struct threads *threads, const struct kernels *kernels, struct particles *p, struct wall *walls,
                   int n_walls, const struct contact_law_constants *law_of_axis, double dt_s,
                   struct contact_losses *losses)
{
    const double start = threads->block_s ? now_s() : 0;
    for (int w = 0; w < n_walls && threads->n_parts == 1; w++)
        kernels->wall(p, &walls[w], &law_of_axis[w / 2], dt_s, losses);
    for (int w = 0, n; w < n_walls && threads->n_parts > 1; w += n) {
        n = w % 2 == 0 && w + 1 < n_walls && threads->apart[w / 2] ? 2 : 1;
        struct wall_work work = {kernels, p, &walls[w], n, &law_of_axis[w / 2], dt_s, threads->piece};
        thread_team_run(threads->team, pieces_of(&walls[w]) + (n > 1 ? pieces_of(&walls[w + 1]) : 0), go_along_wall,
                        &work);
        const struct threads_piece *piece = threads->piece;
        for (int k = 0; k < n; k++)
            piece = add_pieces(piece, &walls[w + k], losses);
    }
    if (threads->block_s)
        threads->walls_s = now_s() - start;
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
    thread_team_run(threads->team, threads->n_parts, drift_part, &work);
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
    thread_team_run(threads->team, threads->n_parts, kick_part, &work);
    return sum_power(threads);
}

bool threads_sweep(struct threads *threads, const struct kernels *kernels, struct particles *p,
                   struct contact_list *pairs, const struct threads_sweep *sweep, struct contact_losses *losses,
                   double *background_w)
{
    struct work work = {threads, kernels, p, pairs, sweep->law, sweep->dt_s, sweep, 1};
    if (threads->n_parts == 1) {
        kernels->pair(p, pairs, 0, pairs->slots.n_spans, sweep->law, sweep->dt_s, p->force, losses);
        return kernels->advance(p, sweep->kick, sweep->dt_s, sweep->reach_m, background_w);
    }
    const double start = now_s();
    go_through_all(&work, losses);
    *background_w = sum_power(threads);
    thread_choice_step(&threads->choice, now_s() - start);
    thread_team_use(threads->team, threads->choice.use);
    return any_far(threads);
}
