#include "common/wire.h"

#include <stdint.h>
#include <string.h>

enum { HASH_SIZE = 8, COUNTS_MAX = 26 };

struct cursor {
    const uint8_t *at;
    size_t left;
    int32_t counts[COUNTS_MAX];
    int n_counts;
};

static bool skip(struct cursor *cursor, size_t size)
{
    if (size > cursor->left)
        return false;
    cursor->at += size;
    cursor->left -= size;
    return true;
}

static bool read_int(struct cursor *cursor, int32_t *value)
{
    const uint8_t *bytes = cursor->at;
    if (!skip(cursor, 4))
        return false;
    *value = (int32_t)((uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3]);
    return true;
}

static bool skip_string(struct cursor *cursor)
{
    int32_t length;
    if (!read_int(cursor, &length) || length < 1)
        return false;
    const uint8_t *text = cursor->at;
    return skip(cursor, (size_t)length) && memchr(text, 0, (size_t)length) == text + length - 1;
}

static size_t code_size(char code)
{
    return code == 'b' ? 1 : code == 'i' ? 4 : 8;
}

static bool skip_array(struct cursor *cursor, char code, char letter)
{
    int slot = letter - 'a';
    if (slot < 0 || slot >= cursor->n_counts || cursor->counts[slot] < 0)
        return false;
    size_t count = (size_t)cursor->counts[slot];
    if (code != 's')
        return skip(cursor, count * code_size(code));
    for (size_t k = 0; k < count; k++) {
        if (!skip_string(cursor))
            return false;
    }
    return true;
}

static bool skip_scalar(struct cursor *cursor, char code)
{
    if (code == 's')
        return skip_string(cursor);
    if (code != 'i')
        return skip(cursor, code_size(code));
    return cursor->n_counts < COUNTS_MAX && read_int(cursor, &cursor->counts[cursor->n_counts++]);
}

bool wire_check(const char *layout, const void *data, size_t size)
{
    struct cursor cursor = {.at = data, .left = size};
    if (!skip(&cursor, HASH_SIZE))
        return false;
    for (const char *code = layout; *code; code++) {
        bool ok;
        if (*code == '*') {
            ok = skip_array(&cursor, code[1], code[2]);
            code += 2;
        } else {
            ok = skip_scalar(&cursor, *code);
        }
        if (!ok)
            return false;
    }
    return cursor.left == 0;
}
