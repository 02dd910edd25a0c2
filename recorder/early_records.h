/* Records that came before one that is missing, kept until it is their turn. */
#ifndef SHAKEDOWN_RECORDER_EARLY_RECORDS_H
#define SHAKEDOWN_RECORDER_EARLY_RECORDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* More than a sender has on its way (common/record_sender.c: 128 kB). */
enum { EARLY_MAX = 256, EARLY_BYTES_MAX = 1 << 20 };

struct early_record {
    int kind;
    int64_t seq;
    size_t size;
    unsigned char data[];
};

struct early_records {
    struct early_record *record[EARLY_MAX]; /* [count], in the order in which they came */
    int count;
    size_t bytes;
};

/* Keeps a copy, unless it is there already; without room or memory the sender has to send it again. `early` starts as
 * zero. */
void early_records_keep(struct early_records *early, int kind, int64_t seq, const void *data, size_t size);

/* Takes number `k` out; the caller frees it. */
struct early_record *early_records_take(struct early_records *early, int k);
void early_records_free(struct early_records *early);

#endif
