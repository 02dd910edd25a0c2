#include "sim/base/aligned_array.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { LARGE_ARRAY = 1 << 20, PAGE = 4096, OFFSETS = 6 };

/* What the start of an array is a multiple of. Large arrays stand in pages of their own, all at the same place of them,
 * where kernels that run through many would meet in the same lines of the nearest cache; an alignment between that of
 * a line and that of a page shifts them. Neighbouring members of a struct get different ones. */
static size_t alignment_of(const void *array, size_t bytes)
{
    const size_t member = (uintptr_t)array / sizeof(void *);
    return bytes < LARGE_ARRAY ? (size_t)ARRAY_ALIGNMENT : (size_t)ARRAY_ALIGNMENT << member % OFFSETS;
}

/* Zeroes an array. Pages of a large one are given back, so that each is taken anew, zeroed, by the
 * thread that needs it first, and never if nobody does; huge ones, for particles are read in many places at a time: a
 * wish that may fail. */
static void clear(void *array, size_t bytes)
{
    const uintptr_t start = (uintptr_t)array, end = start + bytes;
    const uintptr_t first = (start + PAGE - 1) / PAGE * PAGE, last = end / PAGE * PAGE;
    if (bytes < LARGE_ARRAY || madvise((void *)first, last - first, MADV_DONTNEED) != 0) {
        memset(array, 0, bytes);
        return;
    }
    (void)madvise((void *)first, last - first, MADV_HUGEPAGE);
    memset(array, 0, first - start);
    memset((void *)last, 0, end - last);
}

enum status array_resize(void *array, size_t size, size_t count, size_t keep)
{
    void *old;
    memcpy(&old, array, sizeof old);
    size_t bytes = (count + ARRAY_PADDING) * size;
    const size_t alignment = alignment_of(array, bytes);
    bytes = (bytes + alignment - 1) / alignment * alignment;
    void *fresh = aligned_alloc(alignment, bytes);
    if (!fresh)
        return status_fail(STATUS_NO_MEMORY, "out of memory (%zu bytes)", bytes);
    clear(fresh, bytes);
    if (old && keep)
        memcpy(fresh, old, keep * size);
    free(old);
    memcpy(array, &fresh, sizeof fresh);
    return STATUS_OK;
}

void array_forget(void *array, size_t size, size_t count)
{
    if (array && size * count >= LARGE_ARRAY)
        clear(array, size * count);
}
