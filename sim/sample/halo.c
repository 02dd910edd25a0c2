#include "sim/sample/halo.h"

#include <stdlib.h>
#include <string.h>

#include "sim/base/aligned_array.h"

/* Blocks are one span as long as that makes no more than BLOCKS of them; then they are twice as large, and so on. */
enum { BLOCKS = 256 };

/* Of a slot while blocks look for their copies: it holds the number of a copy instead of a row. */
static const uint32_t IS_COPY = 0x80000000u;

static enum status no_memory(void)
{
    return status_fail(STATUS_NO_MEMORY, "no memory for the blocks of the threads");
}

/* Room for twice as many copies as a block has particles, a power of two; a compact one needs half of that in 3D with
 * a single span. */
static enum status init_blocks(struct halo *halo, int n_spans)
{
    const int per = halo->spans_per_block;
    for (int b = 0; b < halo->blocks_max; b++) {
        struct halo_block *block = &halo->block[b];
        block->first_span = b * per;
        block->last_span = (b + 1) * per < n_spans ? (b + 1) * per : n_spans;
        block->capacity = 2 * per * SPAN_WIDTH;
        TRY(array_resize(&block->of, sizeof *block->of, (size_t)block->capacity, 0));
    }
    return STATUS_OK;
}

enum status halo_init(struct halo *halo, int n_spans)
{
    *halo = (struct halo){.n_blocks = 1, .n_parts = n_spans, .spans_per_block = 1};
    while (n_spans > BLOCKS * halo->spans_per_block)
        halo->spans_per_block *= 2;
    halo->blocks_max = (n_spans + halo->spans_per_block - 1) / halo->spans_per_block;
    halo->block = calloc((size_t)halo->blocks_max, sizeof *halo->block);
    halo->part = calloc((size_t)n_spans, sizeof *halo->part);
    return halo->block && halo->part ? init_blocks(halo, n_spans) : no_memory();
}

void halo_free(struct halo *halo)
{
    for (int b = 0; halo->block && b < halo->blocks_max; b++) {
        free(halo->block[b].of);
        free(halo->block[b].part);
    }
    free(halo->block);
    free(halo->part);
    free(halo->of);
    free(halo->copy);
    memset(halo, 0, sizeof *halo);
}

static enum status grow(int32_t **array, int *capacity, int count)
{
    if (count <= *capacity)
        return STATUS_OK;
    *capacity = 0;
    TRY(array_resize(array, sizeof **array, (size_t)count + (size_t)count / 4, 0));
    *capacity = count + count / 4;
    return STATUS_OK;
}

struct cut {
    struct halo *halo;
    struct particles *particles;
    struct contact_list *pairs;
    uint32_t stride, padding;
    bool undo; /* slots get the particles themselves */
};

/* Which number a partner has among the copies of a block: a hash table of `size` places, a power of two. */
struct numbers {
    int32_t *of, *number;
    uint32_t size;
};

static int32_t *number_of(const struct numbers *numbers, int32_t particle)
{
    uint32_t at = (uint32_t)particle * 2654435761u & (numbers->size - 1);
    while (numbers->of[at] >= 0 && numbers->of[at] != particle)
        at = (at + 1) & (numbers->size - 1);
    numbers->of[at] = particle;
    return &numbers->number[at];
}

/* The slots of one span get the numbers of copies, in the order in which they need them. */
static void number_partners(const struct cut *cut, struct halo_block *block, const struct contact_span *span,
                            const struct numbers *numbers)
{
    const int32_t first = block->first_span * SPAN_WIDTH, end = block->last_span * SPAN_WIDTH;
    uint32_t *row = cut->pairs->slots.partner;
    for (int s = span->whole * SET_WIDTH; s < span->end * SET_WIDTH; s++) {
        const int32_t particle = (int32_t)(row[s] / cut->stride);
        if (row[s] == cut->padding || (particle >= first && particle < end))
            continue;
        if (block->n == block->capacity) {
            block->full = true;
            return;
        }
        int32_t *number = number_of(numbers, particle);
        if (*number < 0) {
            *number = block->n;
            block->of[block->n++] = particle;
        }
        row[s] = IS_COPY | (uint32_t)*number;
    }
}

static void find_copies(void *context, int b)
{
    const struct cut *cut = context;
    struct halo_block *block = &cut->halo->block[b];
    const uint32_t size = 2 * (uint32_t)block->capacity;
    int32_t *memory = malloc(2 * (size_t)size * sizeof *memory);
    const struct numbers numbers = {memory, memory ? memory + size : NULL, size};
    block->n = 0;
    block->full = !memory;
    if (memory)
        memset(memory, -1, 2 * (size_t)size * sizeof *memory);
    for (int s = block->first_span; s < block->last_span && !block->full; s++)
        number_partners(cut, block, &cut->pairs->slots.span[s], &numbers);
    free(memory);
}

/* Numbers become rows, and empty slots get the block's own padding: cores that share a line of memory wait for each
 * other. */
static void set_rows(void *context, int b)
{
    const struct cut *cut = context;
    const struct halo_block *block = &cut->halo->block[b];
    const uint32_t own = cut->undo ? cut->padding : cut->stride * (uint32_t)(block->first_row + block->n);
    uint32_t *row = cut->pairs->slots.partner;
    for (int s = block->first_span; s < block->last_span; s++) {
        const struct contact_span *span = &cut->pairs->slots.span[s];
        for (int at = span->next * SET_WIDTH; at < span->end * SET_WIDTH; at++) {
            const uint32_t copy = row[at] & ~IS_COPY;
            if (row[at] == cut->padding)
                row[at] = own;
            else if (row[at] & IS_COPY)
                row[at] = cut->stride * (cut->undo ? (uint32_t)block->of[copy] : (uint32_t)block->first_row + copy);
        }
    }
    if (!cut->undo)
        particles_start_rows(cut->particles, block->first_row, block->n + 1);
}

/* Rows for the copies of all blocks and their paddings, no two blocks' in one line of memory. Returns the end. */
static int place_copies(struct halo *halo, int first_row)
{
    halo->n_copies = 0;
    for (int b = 0; b < halo->n_blocks; b++) {
        struct halo_block *block = &halo->block[b];
        block->first_row = first_row;
        first_row += (block->n + 1 + 2 * ARRAY_PADDING - 1) / ARRAY_PADDING * ARRAY_PADDING;
        halo->n_copies += block->n;
    }
    return first_row;
}

/* Block b adds to the sums of a part. */
static enum status join(struct halo *halo, int b, int q)
{
    struct halo_part *part = &halo->part[q];
    struct halo_block *block = &halo->block[b];
    if (part->last_block == b)
        return STATUS_OK;
    part->last_block = b;
    part->blocks++;
    if (block->n_parts == block->parts_capacity) {
        int32_t *before = block->part;
        block->part = realloc(before, 2 * ((size_t)block->parts_capacity + 8) * sizeof *block->part);
        if (!block->part) {
            block->part = before;
            return no_memory();
        }
        block->parts_capacity = 2 * (block->parts_capacity + 8);
    }
    block->part[block->n_parts++] = q;
    return STATUS_OK;
}

/* Which blocks add to which parts, and how many copies the particles of each part have [last]. */
static enum status join_all(struct halo *halo)
{
    for (int q = 0; q < halo->n_parts; q++)
        halo->part[q] = (struct halo_part){.last_block = -1};
    for (int b = 0; b < halo->n_blocks; b++) {
        struct halo_block *block = &halo->block[b];
        block->n_parts = 0;
        for (int q = block->first_span; q < block->last_span; q++)
            TRY(join(halo, b, q));
        for (int k = 0; k < block->n; k++) {
            TRY(join(halo, b, block->of[k] / SPAN_WIDTH));
            halo->part[block->of[k] / SPAN_WIDTH].last++;
        }
    }
    return STATUS_OK;
}

/* Copies in the order of the parts, and there of the blocks. */
static enum status sort_copies(struct halo *halo)
{
    int before = 0, capacity = halo->capacity;
    TRY(grow(&halo->of, &capacity, halo->n_copies));
    TRY(grow(&halo->copy, &halo->capacity, halo->n_copies));
    TRY(join_all(halo));
    for (int q = 0; q < halo->n_parts; q++) {
        struct halo_part *part = &halo->part[q];
        const int n = part->last;
        part->first = part->last = before;
        before += n;
        atomic_store_explicit(&part->left, part->blocks, memory_order_relaxed);
    }
    for (int b = 0; b < halo->n_blocks; b++)
        for (int k = 0; k < halo->block[b].n; k++) {
            const int32_t of = halo->block[b].of[k], at = halo->part[of / SPAN_WIDTH].last++;
            halo->of[at] = of;
            halo->copy[at] = halo->block[b].first_row + k;
        }
    return STATUS_OK;
}

static bool any_full(const struct halo *halo)
{
    for (int b = 0; b < halo->n_blocks; b++)
        if (halo->block[b].full)
            return true;
    return false;
}

enum status halo_cut(struct halo *halo, struct thread_team *team, struct particles *p, struct contact_list *pairs)
{
    const uint32_t stride = RECORD_STRIDE(p->dimension, p->n_rotations > 0, p->mixed);
    struct cut cut = {halo, p, pairs, stride, stride * (uint32_t)particles_padding(p), false};
    halo->n_blocks = 1;
    if (pairs->count == 0 || pairs->slots.n_spans != halo->n_parts || halo->blocks_max == 1)
        return STATUS_OK;
    halo->n_blocks = halo->blocks_max;
    thread_team_run(team, halo->n_blocks, find_copies, &cut);
    const int rows = place_copies(halo, p->n_padded);
    cut.undo = any_full(halo) || halo->n_copies > p->count;
    if (!cut.undo) {
        TRY(particles_reserve_rows(p, rows));
        TRY(sort_copies(halo));
    }
    thread_team_run(team, halo->n_blocks, set_rows, &cut);
    halo->n_blocks = cut.undo ? 1 : halo->n_blocks;
    return STATUS_OK;
}

void halo_fetch(const struct halo *halo, struct particles *p, int b)
{
    const struct halo_block *block = &halo->block[b];
    particles_copy_rows(p, block->first_row, block->of, block->n);
}

void halo_add(const struct halo *halo, struct particles *p, int q)
{
    const struct halo_part *part = &halo->part[q];
    particles_add_rows(p, halo->of + part->first, halo->copy + part->first, part->last - part->first);
}
