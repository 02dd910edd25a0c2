#include "recorder/backlog.h"

#include <stdlib.h>
#include <string.h>

static const size_t BYTES_MAX = (size_t)64 << 20;

struct item_header {
    int kind;
    size_t size;
};

enum status backlog_add(struct backlog *backlog, int kind, const void *data, size_t size)
{
    const struct item_header header = {kind, size};
    size_t need = backlog->used + sizeof header + size;
    if (need > BYTES_MAX)
        return STATUS_OK;
    if (need > backlog->capacity) {
        unsigned char *grown = realloc(backlog->bytes, 2 * need);
        if (!grown)
            return status_fail(STATUS_NO_MEMORY, "no memory for messages before RUN_INFO");
        backlog->bytes = grown;
        backlog->capacity = 2 * need;
    }
    memcpy(backlog->bytes + backlog->used, &header, sizeof header);
    memcpy(backlog->bytes + backlog->used + sizeof header, data, size);
    backlog->used = need;
    return STATUS_OK;
}

bool backlog_next(const struct backlog *backlog, size_t *at, struct backlog_item *item)
{
    struct item_header header;
    if (*at >= backlog->used)
        return false;
    memcpy(&header, backlog->bytes + *at, sizeof header);
    *item = (struct backlog_item){header.kind, header.size, backlog->bytes + *at + sizeof header};
    *at += sizeof header + header.size;
    return true;
}

void backlog_free(struct backlog *backlog)
{
    free(backlog->bytes);
    *backlog = (struct backlog){0};
}
