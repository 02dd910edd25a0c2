/* Reading the fixed parts of an encoded LCM message before it is decoded. The generated decoders trust the counts in a
 * message: a hostile count overflows their arithmetic and reads past the end. What comes from the network is therefore
 * checked here first. */
#ifndef SHAKEDOWN_COMMON_MESSAGE_H
#define SHAKEDOWN_COMMON_MESSAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The first fields of every message of lcmtypes/, with the type's fingerprint before them. */
struct message_header {
    int64_t fingerprint;
    int64_t run_id;
    int64_t seq;
    int64_t step;
    double time_s;
};

/* Reads the header of an encoded message; false if it is too short. */
bool message_header_read(const void *data, size_t size, struct message_header *header);

/* For a type with one count: its arrays follow the count and take item_bytes per item, trailing_bytes follow them.
 * empty_bytes is the encoded size with count 0. Reads the count; false if the size does not follow from it. */
bool message_count_read(const void *data, size_t size, size_t empty_bytes, size_t item_bytes, size_t trailing_bytes,
                        int32_t *count);

#endif
