#include "recorder/early_records.h"

#include <stdlib.h>
#include <string.h>

void early_records_keep(struct early_records *early, int kind, int64_t seq, const void *data, size_t size)
{
    for (int k = 0; k < early->count; k++) {
        if (early->record[k]->kind == kind && early->record[k]->seq == seq)
            return;
    }
    if (early->count == EARLY_MAX || early->bytes + size > EARLY_BYTES_MAX)
        return;
    struct early_record *record = malloc(sizeof *record + size);
    if (!record)
        return;
    *record = (struct early_record){.kind = kind, .seq = seq, .size = size};
    memcpy(record->data, data, size);
    early->record[early->count++] = record;
    early->bytes += size;
}

struct early_record *early_records_take(struct early_records *early, int k)
{
    struct early_record *record = early->record[k];
    early->count--;
    memmove(&early->record[k], &early->record[k + 1], (size_t)(early->count - k) * sizeof *early->record);
    early->bytes -= record->size;
    return record;
}

void early_records_free(struct early_records *early)
{
    while (early->count > 0)
        free(early_records_take(early, early->count - 1));
}
