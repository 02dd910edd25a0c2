/* Tables of numbers in text files: a line of names, then rows, separated by commas. Empty lines and those that begin
 * with # are left out. Every complaint names file and line. */
#ifndef SHAKEDOWN_COMMON_CSV_TABLE_H
#define SHAKEDOWN_COMMON_CSV_TABLE_H

#include <stdbool.h>
#include <stdint.h>

#include "common/status.h"

enum { CSV_COLUMNS_MAX = 16, CSV_LINE_MAX = 1024 };

/* What a table may hold. */
struct csv_format {
    const char *const *names; /* [n_names], in any order in the file */
    int n_names;
    unsigned required; /* bit k: names[k] must be there */
    int64_t rows_max;
};

struct csv_table {
    int n_columns; /* those of the format */
    bool has[CSV_COLUMNS_MAX];
    int64_t rows;
    double *value; /* [rows][n_columns]; 0 in columns that the file does not have */
    int32_t *line; /* [rows] where each stands */
    uint64_t hash; /* FNV-1a over the bytes of the file */
};

/* Reads `path`; free with csv_table_free. All numbers are finite. Errors: STATUS_IO (no such file), STATUS_NO_MEMORY,
 * STATUS_CONFIG ("file:line: what is wrong; what is allowed"): names, numbers of columns, no number, no row, too many.
 */
enum status csv_table_read(struct csv_table *table, const char *path, const struct csv_format *format) MUST_USE;
void csv_table_free(struct csv_table *table);

static inline double csv_value(const struct csv_table *table, int64_t row, int column)
{
    return table->value[row * table->n_columns + column];
}

#endif
