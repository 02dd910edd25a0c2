/* Hash over the bytes of all records of a channel, in CHECKPOINT and END: says that the record is what was sent. */
#ifndef SHAKEDOWN_COMMON_RECORD_HASH_H
#define SHAKEDOWN_COMMON_RECORD_HASH_H

#include <stddef.h>
#include <stdint.h>

/* FNV-1a, 64 bit. Of no record: */
#define RECORD_HASH_OF_NONE ((int64_t)UINT64_C(0xcbf29ce484222325))

/* `hash` of the records before, and one more. */
static inline int64_t record_hash_add(int64_t hash, const void *data, size_t size)
{
    const unsigned char *bytes = data;
    uint64_t value = (uint64_t)hash;
    for (size_t k = 0; k < size; k++)
        value = (value ^ bytes[k]) * UINT64_C(0x100000001b3);
    return (int64_t)value;
}

#endif
