/* The seal of a run's messages: 16 bytes behind each message of a run that others on the machine can hear, which only
 * who has the run's key can make (SipHash-2-4 with 128 bits, of libsodium, over message and channel). LCM's decoders do
 * not look at what stands behind a message. */
#ifndef SHAKEDOWN_COMMON_MESSAGE_SEAL_H
#define SHAKEDOWN_COMMON_MESSAGE_SEAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

enum { SEAL_SIZE = 16, SEAL_KEY_SIZE = 16, SEAL_MESSAGE_MAX = 60000, SEAL_CHANNEL_MAX = 64 };

struct message_seal {
    unsigned char key[SEAL_KEY_SIZE];
    int64_t refused; /* messages without it */
};

/* *seal: with the key that the file `path` holds (32 hexadecimal digits); to be freed. STATUS_IO if it cannot be read
 * or if others may read it, STATUS_FORMAT if it holds no key. */
enum status message_seal_create(struct message_seal **seal, const char *path) MUST_USE;

/* bytes [size + SEAL_SIZE] becomes `data` [size, at most SEAL_MESSAGE_MAX] with its seal. */
enum status message_seal_add(const struct message_seal *seal, const char *channel, const void *data, size_t size,
                             unsigned char *bytes) MUST_USE;

/* Whether the last SEAL_SIZE of `data` [size] are the seal of what is before them; counts those that are not. */
bool message_seal_check(struct message_seal *seal, const char *channel, const void *data, size_t size);

#endif
