#include "sim/memory.h"

#include <stdlib.h>
#include <string.h>

enum status array_resize(void *array, size_t size, size_t count, size_t keep)
{
    void *old;
    memcpy(&old, array, sizeof old);
    size_t bytes = (count + ARRAY_PADDING) * size;
    bytes = (bytes + ARRAY_ALIGNMENT - 1) / ARRAY_ALIGNMENT * ARRAY_ALIGNMENT;
    void *fresh = aligned_alloc(ARRAY_ALIGNMENT, bytes);
    if (!fresh)
        return status_fail(STATUS_NO_MEMORY, "out of memory (%zu bytes)", bytes);
    memset(fresh, 0, bytes);
    if (old && keep)
        memcpy(fresh, old, keep * size);
    free(old);
    memcpy(array, &fresh, sizeof fresh);
    return STATUS_OK;
}
