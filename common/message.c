#include "common/message.h"

#include <string.h>

enum { INT64_BYTES = 8, INT32_BYTES = 4, HEADER_BYTES = 5 * INT64_BYTES };

static uint64_t big_endian(const unsigned char *bytes, int count)
{
    uint64_t value = 0;
    for (int k = 0; k < count; k++)
        value = value << 8 | bytes[k];
    return value;
}

bool message_header_read(const void *data, size_t size, struct message_header *header)
{
    const unsigned char *bytes = data;
    if (size < HEADER_BYTES)
        return false;
    header->fingerprint = (int64_t)big_endian(bytes, INT64_BYTES);
    header->run_id = (int64_t)big_endian(bytes + INT64_BYTES, INT64_BYTES);
    header->seq = (int64_t)big_endian(bytes + 2 * INT64_BYTES, INT64_BYTES);
    header->step = (int64_t)big_endian(bytes + 3 * INT64_BYTES, INT64_BYTES);
    uint64_t time_bits = big_endian(bytes + 4 * INT64_BYTES, INT64_BYTES);
    memcpy(&header->time_s, &time_bits, sizeof header->time_s);
    return true;
}

bool message_count_read(const void *data, size_t size, size_t empty_bytes, size_t item_bytes, size_t trailing_bytes,
                        int32_t *count)
{
    if (size < empty_bytes || empty_bytes < HEADER_BYTES + INT32_BYTES + trailing_bytes)
        return false;
    const unsigned char *at = (const unsigned char *)data + (empty_bytes - trailing_bytes - INT32_BYTES);
    *count = (int32_t)(uint32_t)big_endian(at, INT32_BYTES);
    return *count >= 0 && size - empty_bytes == item_bytes * (size_t)*count;
}
