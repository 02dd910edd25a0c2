#include "sim/run/config_difference.h"

#include <stdio.h>
#include <string.h>

enum { LINE_MAX_BYTES = 2048, DEPTH_MAX = 8, PATH_BYTES = 256 };

/* Keys that may differ. */
static const char *const free_keys[] = {"checkpoint_interval_s", "threads",     "coupling.timeout_s",
                                        "sample.checkpoint",     "sample.file", NULL};

/* Where a text is being read. */
struct reader {
    const char *at;
    char line[LINE_MAX_BYTES]; /* without spaces around */
    char name[DEPTH_MAX][64];  /* of the groups and lists around the line */
    int depth;
    int member; /* of the list of stages */
};

static void line_read(struct reader *reader)
{
    while (*reader->at == ' ' || *reader->at == '\n')
        reader->at++;
    size_t length = strcspn(reader->at, "\n");
    snprintf(reader->line, sizeof reader->line, "%.*s", (int)length, reader->at);
    reader->at += length;
}

static void enter(struct reader *reader, const char *name, int length)
{
    if (reader->depth < DEPTH_MAX)
        snprintf(reader->name[reader->depth], sizeof reader->name[0], "%.*s", length, name);
    reader->depth++;
}

/* The next "key = value;" with its value; false at the end. Groups and lists on the way are entered and left. */
static bool value_next(struct reader *reader, const char **key, int *key_length, const char **value)
{
    for (line_read(reader); reader->line[0]; line_read(reader)) {
        char *equals = strstr(reader->line, " = "), member[16];
        if (reader->line[0] == '}' || reader->line[0] == ')') {
            reader->depth--;
        } else if (reader->line[0] == '{') {
            snprintf(member, sizeof member, "%d", reader->member++);
            enter(reader, member, (int)strlen(member));
        } else if (equals && (equals[3] == '{' || equals[3] == '(')) {
            enter(reader, reader->line, (int)(equals - reader->line));
        } else if (equals) {
            *key = reader->line;
            *key_length = (int)(equals - reader->line);
            *value = equals + 3;
            return true;
        }
    }
    return false;
}

static void path_make(const struct reader *reader, const char *key, int key_length, char path[PATH_BYTES])
{
    int used = 0;
    for (int d = 0; d < reader->depth && d < DEPTH_MAX && used < PATH_BYTES; d++)
        used += snprintf(path + used, (size_t)(PATH_BYTES - used), "%s.", reader->name[d]);
    if (used < PATH_BYTES)
        snprintf(path + used, (size_t)(PATH_BYTES - used), "%.*s", key_length, key);
}

static bool is_free(const char *path)
{
    for (int k = 0; free_keys[k]; k++)
        if (strcmp(path, free_keys[k]) == 0)
            return true;
    return false;
}

bool config_is_same(const char *before, const char *now, char *difference, size_t size)
{
    struct reader a = {.at = before}, b = {.at = now};
    const char *key[2], *value[2];
    int length[2];
    for (;;) {
        bool more = value_next(&a, &key[0], &length[0], &value[0]);
        bool also = value_next(&b, &key[1], &length[1], &value[1]);
        char path[2][PATH_BYTES] = {"", ""};
        if (more)
            path_make(&a, key[0], length[0], path[0]);
        if (also)
            path_make(&b, key[1], length[1], path[1]);
        if (!more && !also)
            return true;
        if (strcmp(path[0], path[1]) != 0) {
            snprintf(difference, size, "%s has no counterpart", more ? path[0] : path[1]);
            return false;
        }
        if (strcmp(value[0], value[1]) != 0 && !is_free(path[0])) {
            snprintf(difference, size, "%s was %.*s, is now %.*s", path[0], (int)strcspn(value[0], ";"), value[0],
                     (int)strcspn(value[1], ";"), value[1]);
            return false;
        }
    }
}
