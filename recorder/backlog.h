/* Raw messages kept until it is known whether they are wanted. */
#ifndef SHAKEDOWN_RECORDER_BACKLOG_H
#define SHAKEDOWN_RECORDER_BACKLOG_H

#include <stdbool.h>
#include <stddef.h>

#include "common/status.h"

struct backlog {
    unsigned char *bytes; /* items one after the other */
    size_t used, capacity;
};

struct backlog_item {
    int kind;
    size_t size;
    const unsigned char *data; /* [size] */
};

/* Keeps a copy. Beyond 64 MB messages are dropped: the run's totals will tell. `backlog` starts as zero. */
enum status backlog_add(struct backlog *backlog, int kind, const void *data, size_t size) MUST_USE;

/* The item at *at (0: the first), which moves on; false after the last. */
bool backlog_next(const struct backlog *backlog, size_t *at, struct backlog_item *item);
void backlog_free(struct backlog *backlog);

#endif
