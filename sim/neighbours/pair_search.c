#include "sim/neighbours/pair_search.h"

#include <stdlib.h>
#include <string.h>

#include "sim/base/aligned_array.h"

#define DECLARE_SEARCH(name) extern const struct search search_##name;
INSTRUCTION_SETS(DECLARE_SEARCH)
#undef DECLARE_SEARCH

struct search search_select(enum instruction_set isa)
{
    static const struct search *const of_isa[ISA_COUNT] = {
#define SEARCH(name) &search_##name,
        INSTRUCTION_SETS(SEARCH)
#undef SEARCH
    };
    return *of_isa[isa];
}

enum status search_block_reserve(struct search_block *block, const struct cell_list *cells, int count)
{
    enum { AROUND = 27, VECTOR = 16 }; /* cells; each row of them is rounded up to a vector */
    const int64_t most = (int64_t)AROUND * (cells->most + VECTOR);
    const int room = cells->n_levels == 1 && most < count ? (int)most : count;
    if (room <= block->capacity)
        return STATUS_OK;
    block->capacity = 0;
    for (int c = 0; c < cells->dimension; c++)
        TRY(array_resize(&block->x[c], sizeof(float), (size_t)room, 0));
    TRY(array_resize(&block->reach, sizeof(float), (size_t)room, 0));
    TRY(array_resize(&block->id, sizeof(int32_t), (size_t)room, 0));
    block->capacity = room;
    return STATUS_OK;
}

void search_block_free(struct search_block *block)
{
    for (int c = 0; c < 3; c++)
        free(block->x[c]);
    free(block->reach);
    free(block->id);
    memset(block, 0, sizeof *block);
}

enum status pair_buffer_reserve(struct pair_buffer *pairs, int more)
{
    if (more <= pairs->capacity - pairs->count)
        return STATUS_OK;
    size_t capacity = (size_t)pairs->count + (size_t)pairs->count / 2 + (size_t)more + 256;
    if (capacity > INT32_MAX / 2)
        return status_fail(STATUS_LIMIT, "more than %d pairs are near each other", INT32_MAX / 2);
    TRY(array_resize(&pairs->lo, sizeof(int32_t), capacity, (size_t)pairs->count));
    TRY(array_resize(&pairs->hi, sizeof(int32_t), capacity, (size_t)pairs->count));
    pairs->capacity = (int)capacity;
    return STATUS_OK;
}

void pair_buffer_free(struct pair_buffer *pairs)
{
    free(pairs->lo);
    free(pairs->hi);
    memset(pairs, 0, sizeof *pairs);
}
