#include "common/message_seal.h"

#include <errno.h>
#include <sodium.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

_Static_assert(SEAL_SIZE == crypto_shorthash_siphashx24_BYTES, "the seal is the library's");
_Static_assert(SEAL_KEY_SIZE == crypto_shorthash_siphashx24_KEYBYTES, "so is the key");

/* Only the owner may read it. */
static enum status key_read(const char *path, char *text, size_t size)
{
    struct stat about;
    FILE *file = fopen(path, "r");
    if (!file)
        return status_fail(STATUS_IO, "the run's key %s: %s", path, strerror(errno));
    const bool known = fstat(fileno(file), &about) == 0;
    const size_t n = fread(text, 1, size - 1, file);
    text[n] = '\0';
    (void)fclose(file);
    if (!known || (about.st_mode & (S_IRWXG | S_IRWXO)))
        return status_fail(STATUS_IO, "the run's key %s can be read by others", path);
    return STATUS_OK;
}

enum status message_seal_create(struct message_seal **seal, const char *path)
{
    char text[2 * SEAL_KEY_SIZE + 2];
    size_t n = 0;
    *seal = NULL;
    if (sodium_init() < 0)
        return status_fail(STATUS_IO, "libsodium does not start");
    TRY(key_read(path, text, sizeof text));
    struct message_seal *created = calloc(1, sizeof *created);
    if (!created)
        return status_fail(STATUS_NO_MEMORY, "no memory for a key");
    if (sodium_hex2bin(created->key, SEAL_KEY_SIZE, text, strlen(text), "\n", &n, NULL) != 0 || n != SEAL_KEY_SIZE) {
        free(created);
        return status_fail(STATUS_FORMAT, "%s holds no key of %d hexadecimal digits", path, 2 * SEAL_KEY_SIZE);
    }
    *seal = created;
    return STATUS_OK;
}

/* What the seal is made of: the message, the channel's name with its zero. Then the seal, over the name. */
enum status message_seal_add(const struct message_seal *seal, const char *channel, const void *data, size_t size,
                             unsigned char *bytes)
{
    unsigned char whole[SEAL_MESSAGE_MAX + SEAL_CHANNEL_MAX];
    const size_t name = strlen(channel) + 1;
    if (size > SEAL_MESSAGE_MAX || name > SEAL_CHANNEL_MAX)
        return status_fail(STATUS_LIMIT, "a message of %zu bytes on %s is too long for a seal", size, channel);
    memcpy(whole, data, size);
    memcpy(whole + size, channel, name);
    memcpy(bytes, data, size);
    /* 0 is all that it returns */
    (void)crypto_shorthash_siphashx24(bytes + size, whole, size + name, seal->key);
    return STATUS_OK;
}

bool message_seal_check(struct message_seal *seal, const char *channel, const void *data, size_t size)
{
    unsigned char wanted[SEAL_MESSAGE_MAX + SEAL_SIZE];
    const unsigned char *bytes = data;
    const size_t message = size - SEAL_SIZE;
    if (size >= SEAL_SIZE && message <= SEAL_MESSAGE_MAX &&
        message_seal_add(seal, channel, data, message, wanted) == STATUS_OK &&
        sodium_memcmp(wanted + message, bytes + message, SEAL_SIZE) == 0)
        return true;
    seal->refused++;
    return false;
}
