/* Tables of numbers in CSV files, by columns. */
#ifndef SHAKEDOWN_STUDIES_TABLE_H
#define SHAKEDOWN_STUDIES_TABLE_H

#include "common/status.h"

struct table {
    char **name;     /* [columns] */
    double **column; /* [columns][rows]; NaN where a cell holds no number */
    int columns, rows;
};

/* Reads a file with one line of names. STATUS_IO, STATUS_FORMAT (a line of another length), STATUS_NO_MEMORY. On
 * success release it with table_free. */
enum status table_read(struct table *table, const char *path) MUST_USE;

void table_free(struct table *table);

/* The column of that name. STATUS_FORMAT if there is none. */
enum status table_column(const struct table *table, const char *name, const double **column) MUST_USE;

#endif
