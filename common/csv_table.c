#include "common/csv_table.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/record_hash.h"

struct reader {
    const char *path;
    const struct csv_format *format;
    FILE *in;
    char text[CSV_LINE_MAX + 2]; /* a line, then without its end and spaces around */
    int64_t line;
    int n_fields, column_of[CSV_COLUMNS_MAX]; /* of each field of the file */
    int64_t room;
};

static char *trimmed(char *text)
{
    char *end = text + strlen(text);
    while (end > text && isspace((unsigned char)end[-1]))
        end--;
    *end = '\0';
    while (isspace((unsigned char)*text))
        text++;
    return text;
}

/* The next line that says something; NULL at the end of the file. */
static enum status line_read(struct reader *r, struct csv_table *table, char **line)
{
    for (;;) {
        *line = NULL;
        if (!fgets(r->text, sizeof r->text, r->in))
            return ferror(r->in) ? status_fail(STATUS_IO, "%s: cannot be read: %s", r->path, strerror(errno))
                                 : STATUS_OK;
        r->line++;
        const size_t length = strlen(r->text);
        table->hash = (uint64_t)record_hash_add((int64_t)table->hash, r->text, length);
        if (length > CSV_LINE_MAX)
            return status_fail(STATUS_CONFIG, "%s:%" PRId64 ": longer than %d characters", r->path, r->line,
                               CSV_LINE_MAX);
        if (length == 0 || (r->text[length - 1] != '\n' && !feof(r->in)))
            return status_fail(STATUS_CONFIG, "%s:%" PRId64 ": not a text file", r->path, r->line);
        *line = trimmed(r->text);
        if (**line && **line != '#')
            return STATUS_OK;
    }
}

/* Cuts the next field off. */
static char *field_next(char **rest)
{
    char *field = *rest, *comma = strchr(field, ',');
    *rest = comma ? comma + 1 : NULL;
    if (comma)
        *comma = '\0';
    return trimmed(field);
}

static const char *names_text(const struct csv_format *format, char *text, size_t size)
{
    size_t length = 0;
    text[0] = '\0';
    for (int k = 0; k < format->n_names && length < size; k++)
        length += (size_t)snprintf(text + length, size - length, "%s%s", k ? ", " : "", format->names[k]);
    return text;
}

static int name_find(const struct csv_format *format, const char *name)
{
    for (int k = 0; k < format->n_names; k++)
        if (strcmp(format->names[k], name) == 0)
            return k;
    return -1;
}

static enum status header_read(struct reader *r, struct csv_table *table)
{
    char allowed[256], *rest;
    names_text(r->format, allowed, sizeof allowed);
    TRY(line_read(r, table, &rest));
    if (!rest)
        return status_fail(STATUS_CONFIG, "%s: empty; the first line names the columns: %s", r->path, allowed);
    while (rest) {
        const char *name = field_next(&rest);
        const int column = name_find(r->format, name);
        if (column < 0)
            return status_fail(STATUS_CONFIG, "%s:%" PRId64 ": \"%.40s\" is no column; allowed: %s", r->path, r->line,
                               name, allowed);
        if (table->has[column])
            return status_fail(STATUS_CONFIG, "%s:%" PRId64 ": two columns \"%s\"", r->path, r->line, name);
        table->has[column] = true;
        r->column_of[r->n_fields++] = column;
    }
    for (int k = 0; k < r->format->n_names; k++)
        if ((r->format->required >> k & 1) && !table->has[k])
            return status_fail(STATUS_CONFIG, "%s:%" PRId64 ": there is no column \"%s\"", r->path, r->line,
                               r->format->names[k]);
    return STATUS_OK;
}

static enum status row_reserve(struct reader *r, struct csv_table *table)
{
    if (table->rows >= r->format->rows_max)
        return status_fail(STATUS_CONFIG, "%s:%" PRId64 ": more than %" PRId64 " rows", r->path, r->line,
                           r->format->rows_max);
    if (table->rows < r->room)
        return STATUS_OK;
    r->room = r->room ? 2 * r->room : 64;
    double *value = realloc(table->value, (size_t)r->room * (size_t)table->n_columns * sizeof *value);
    table->value = value ? value : table->value;
    int32_t *line = realloc(table->line, (size_t)r->room * sizeof *line);
    table->line = line ? line : table->line;
    return value && line ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "out of memory");
}

static enum status row_read(struct reader *r, struct csv_table *table, char *rest)
{
    TRY(row_reserve(r, table));
    double *row = table->value + table->rows * table->n_columns;
    int n = 0;
    memset(row, 0, (size_t)table->n_columns * sizeof *row);
    for (; rest && n < r->n_fields; n++) {
        char *end;
        const char *text = field_next(&rest), *name = r->format->names[r->column_of[n]];
        const double value = strtod(text, &end);
        if (end == text || *end)
            return status_fail(STATUS_CONFIG, "%s:%" PRId64 ": %s: \"%.40s\" is no number", r->path, r->line, name,
                               text);
        if (!isfinite(value))
            return status_fail(STATUS_CONFIG, "%s:%" PRId64 ": %s: %s; allowed: finite numbers", r->path, r->line, name,
                               text);
        row[r->column_of[n]] = value;
    }
    if (rest || n < r->n_fields)
        return status_fail(STATUS_CONFIG, "%s:%" PRId64 ": %s fields than the %d columns", r->path, r->line,
                           rest ? "more" : "fewer", r->n_fields);
    table->line[table->rows++] = (int32_t)r->line;
    return STATUS_OK;
}

static enum status table_fill(struct reader *r, struct csv_table *table)
{
    char *line;
    TRY(header_read(r, table));
    for (;;) {
        TRY(line_read(r, table, &line));
        if (!line)
            break;
        TRY(row_read(r, table, line));
    }
    if (table->rows == 0)
        return status_fail(STATUS_CONFIG, "%s: no rows below the names of the columns", r->path);
    return STATUS_OK;
}

enum status csv_table_read(struct csv_table *table, const char *path, const struct csv_format *format)
{
    struct reader reader = {.path = path, .format = format};
    *table = (struct csv_table){.n_columns = format->n_names, .hash = (uint64_t)RECORD_HASH_OF_NONE};
    reader.in = fopen(path, "r");
    if (!reader.in)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    enum status status = table_fill(&reader, table);
    fclose(reader.in);
    if (status != STATUS_OK)
        csv_table_free(table);
    return status;
}

void csv_table_free(struct csv_table *table)
{
    free(table->value);
    free(table->line);
    table->value = NULL;
    table->line = NULL;
    table->rows = 0;
}
