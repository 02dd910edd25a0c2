#include "recorder/message_table.h"

#include <stdlib.h>
#include <string.h>

struct column {
    struct field field;
    size_t row_size; /* bytes of one row */
    unsigned char *buffer;
    struct h5_series series;
};

struct message_table {
    struct column *columns;
    size_t n_columns;
    hsize_t block;
    hsize_t written;
    hsize_t waiting;
    bool whole_blocks;
};

static const size_t type_size[] = {[FIELD_I8] = 1, [FIELD_I32] = 4, [FIELD_I64] = 8, [FIELD_F64] = 8};

static hid_t memory_type(enum field_type type)
{
    switch (type) {
    case FIELD_I8:
        return H5T_NATIVE_INT8;
    case FIELD_I32:
        return H5T_NATIVE_INT32;
    case FIELD_I64:
        return H5T_NATIVE_INT64;
    default:
        return H5T_NATIVE_DOUBLE;
    }
}

static hsize_t values_per_row(enum field_width width, int dimension)
{
    hsize_t d = (hsize_t)dimension;
    const hsize_t values[] = {[WIDTH_ONE] = 1, [WIDTH_AXES] = d, [WIDTH_TENSOR] = d * d, [WIDTH_WALLS] = 2 * d};
    return values[width];
}

static enum status column_create(struct column *column, hid_t file, const struct message_table_options *options,
                                 const struct field *field)
{
    char path[TABLE_PATH_MAX];
    hsize_t values = values_per_row(field->width, options->dimension);
    column->field = *field;
    column->row_size = type_size[field->type] * values;
    column->buffer = malloc(column->row_size * options->block);
    if (!column->buffer)
        return status_fail(STATUS_NO_MEMORY, "no memory for the column %s", field->name);
    options->path(field->name, path);
    struct h5_layout layout = {.chunk = {options->block, values}, .deflate = options->deflate};
    int rank = field->width == WIDTH_ONE ? 1 : 2;
    return h5_series_create(file, path, memory_type(field->type), rank, &values, &layout, field->unit, &column->series);
}

enum status message_table_create(struct message_table **result, hid_t file, const struct message_table_options *options)
{
    size_t n = 0;
    while (options->fields[n].name)
        n++;
    struct message_table *table = *result = calloc(1, sizeof *table);
    struct column *columns = calloc(n, sizeof *columns);
    if (!table || !columns) {
        free(columns);
        return status_fail(STATUS_NO_MEMORY, "no memory for a table");
    }
    for (size_t c = 0; c < n; c++)
        columns[c].series.id = H5I_INVALID_HID;
    table->columns = columns;
    table->n_columns = n;
    table->block = options->block;
    table->whole_blocks = options->deflate > 0;
    for (size_t c = 0; c < n; c++)
        TRY(column_create(&columns[c], file, options, &options->fields[c]));
    return STATUS_OK;
}

static enum status write_waiting(struct message_table *table)
{
    for (size_t c = 0; c < table->n_columns; c++)
        TRY(h5_series_append(&table->columns[c].series, table->waiting, table->columns[c].buffer));
    table->written += table->waiting;
    table->waiting = 0;
    return STATUS_OK;
}

static enum status row_taken(struct message_table *table)
{
    table->waiting++;
    bool at_chunk_end = (table->written + table->waiting) % table->block == 0;
    return at_chunk_end ? write_waiting(table) : STATUS_OK;
}

enum status message_table_append(struct message_table *table, const void *message)
{
    for (size_t c = 0; c < table->n_columns; c++) {
        struct column *column = &table->columns[c];
        const void *source = (const unsigned char *)message + column->field.offset;
        if (column->field.width != WIDTH_ONE)
            memcpy(&source, source, sizeof source);
        memcpy(column->buffer + table->waiting * column->row_size, source, column->row_size);
    }
    return row_taken(table);
}

static enum status value_copy(const struct column *from, const struct message_table *table, hsize_t row, void *value)
{
    if (row < table->written)
        return h5_series_row_read(&from->series, row, value);
    memcpy(value, from->buffer + (row - table->written) * from->row_size, from->row_size);
    return STATUS_OK;
}

enum status message_table_row_copy(struct message_table *table, const struct message_table *from, int64_t row)
{
    for (size_t c = 0; c < table->n_columns; c++) {
        struct column *column = &table->columns[c];
        TRY(value_copy(&from->columns[c], from, (hsize_t)row, column->buffer + table->waiting * column->row_size));
    }
    return row_taken(table);
}

enum status message_table_flush(struct message_table *table, bool last)
{
    return last || !table->whole_blocks ? write_waiting(table) : STATUS_OK;
}

int64_t message_table_rows(const struct message_table *table)
{
    return (int64_t)(table->written + table->waiting);
}

enum status message_table_close(struct message_table *table)
{
    enum status status = STATUS_OK;
    for (size_t c = 0; table && c < table->n_columns; c++) {
        enum status closed = h5_series_close(&table->columns[c].series);
        status = status == STATUS_OK ? closed : status;
    }
    return status;
}

void message_table_free(struct message_table *table)
{
    if (!table)
        return;
    for (size_t c = 0; c < table->n_columns; c++)
        free(table->columns[c].buffer);
    free(table->columns);
    free(table);
}
