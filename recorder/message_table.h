/* Messages as rows, kept in memory and written in blocks, one HDF5 dataset per field. */
#ifndef SHAKEDOWN_RECORDER_MESSAGE_TABLE_H
#define SHAKEDOWN_RECORDER_MESSAGE_TABLE_H

#include "recorder/h5.h"
#include "recorder/message_columns.h"

struct message_table;

enum { TABLE_PATH_MAX = 128 };

struct message_table_options {
    const struct field *fields;
    int dimension; /* of the run: gives the widths */
    hsize_t block; /* rows of a chunk, and of a write */
    int deflate;   /* 0: not compressed */
    /* Writes the path of the column of a field. */
    void (*path)(const char *field_name, char path[TABLE_PATH_MAX]);
};

/* Creates the datasets, without rows. */
enum status message_table_create(struct message_table **table, hid_t file,
                                 const struct message_table_options *options) MUST_USE;

/* Takes one message (the generated struct, with arrays as wide as the fields say); writes a block when it is full. */
enum status message_table_append(struct message_table *table, const void *message) MUST_USE;

/* Takes row `row` of another table of the same fields. */
enum status message_table_row_copy(struct message_table *table, const struct message_table *from, int64_t row) MUST_USE;

/* Writes what waits. A compressed table writes whole blocks only, unless `last`: a block that is compressed again may
 * not fit where it was. */
enum status message_table_flush(struct message_table *table, bool last) MUST_USE;

/* Rows taken, written or waiting. */
int64_t message_table_rows(const struct message_table *table);

/* Closes the datasets; what waits is not written. NULL is nothing. */
enum status message_table_close(struct message_table *table) MUST_USE;

/* Releases the memory, no datasets. NULL is nothing. */
void message_table_free(struct message_table *table);

#endif
