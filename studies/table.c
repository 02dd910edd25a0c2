#include "studies/table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "studies/files.h"

static enum status no_memory(void)
{
    return status_fail(STATUS_NO_MEMORY, "out of memory");
}

static int count_char(const char *text, size_t length, char c)
{
    int n = 0;
    for (size_t k = 0; k < length; k++)
        n += text[k] == c;
    return n;
}

static enum status names_read(struct table *table, const char *line, size_t length)
{
    table->columns = count_char(line, length, ',') + 1;
    table->name = calloc((size_t)table->columns, sizeof *table->name);
    table->column = calloc((size_t)table->columns, sizeof *table->column);
    if (!table->name || !table->column)
        return no_memory();
    for (int c = 0; c < table->columns; c++) {
        size_t part = strcspn(line, ",\r\n");
        table->name[c] = strndup(line, part);
        if (!table->name[c])
            return no_memory();
        line += part + 1;
    }
    return STATUS_OK;
}

static enum status row_read(struct table *table, const char *line, const char *path)
{
    for (int c = 0; c < table->columns; c++) {
        size_t part = strcspn(line, ",\n");
        char *end;
        double value = strtod(line, &end);
        table->column[c][table->rows] = end > line && (size_t)(end - line) <= part ? value : NAN;
        line += part;
        if ((*line == ',') != (c + 1 < table->columns))
            return status_fail(STATUS_FORMAT, "%s: line %d has not %d columns", path, table->rows + 2, table->columns);
        line += *line == ',';
    }
    table->rows++;
    return STATUS_OK;
}

static enum status parse(struct table *table, const char *text, const char *path)
{
    size_t rows = (size_t)count_char(text, strlen(text), '\n') + 1, head = strcspn(text, "\n");
    TRY(names_read(table, text, head));
    for (int c = 0; c < table->columns; c++) {
        table->column[c] = malloc(rows * sizeof **table->column);
        if (!table->column[c])
            return no_memory();
    }
    for (const char *line = text + head + (text[head] == '\n'); *line;) {
        size_t length = strcspn(line, "\n");
        if (length > 0)
            TRY(row_read(table, line, path));
        line += length + (line[length] == '\n');
    }
    return STATUS_OK;
}

enum status table_read(struct table *table, const char *path)
{
    char *text;
    *table = (struct table){0};
    TRY(files_read(path, &text));
    enum status status = parse(table, text, path);
    free(text);
    if (status != STATUS_OK)
        table_free(table);
    return status;
}

void table_free(struct table *table)
{
    for (int c = 0; c < table->columns; c++) {
        if (table->name)
            free(table->name[c]);
        if (table->column)
            free(table->column[c]);
    }
    free(table->name);
    free(table->column);
    *table = (struct table){0};
}

enum status table_column(const struct table *table, const char *name, const double **column)
{
    for (int c = 0; c < table->columns; c++)
        if (strcmp(table->name[c], name) == 0) {
            *column = table->column[c];
            return STATUS_OK;
        }
    return status_fail(STATUS_FORMAT, "there is no column \"%s\"", name);
}
