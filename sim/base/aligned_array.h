/* Aligned arrays for the kernels. */
#ifndef SHAKEDOWN_SIM_BASE_ALIGNED_ARRAY_H
#define SHAKEDOWN_SIM_BASE_ALIGNED_ARRAY_H

#include <stddef.h>

#include "common/status.h"

/* Arrays start at a cache line and are padded to whole vectors, so that kernels may read past the end. */
enum { ARRAY_ALIGNMENT = 64, ARRAY_PADDING = 16 };

/* *array becomes `count` (plus padding) zeroed members of `size` bytes, 64-byte aligned; the old array is freed and
 * its first `keep` members are carried over. STATUS_NO_MEMORY leaves *array as it was. Release with free(). */
enum status array_resize(void *array, size_t size, size_t count, size_t keep) MUST_USE;

/* What `count` members of a large array hold is not needed any more: they are zeroed, or left, and large arrays take no
 * memory until they are written again. NULL: nothing. */
void array_forget(void *array, size_t size, size_t count);

#endif
