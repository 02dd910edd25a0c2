#include "launcher/scene_copy.h"

#include <errno.h>
#include <glib.h>
#include <libconfig.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/config_literals.h"

/* Files that a scene names. */
static const struct {
    const char *key;
    const char *kept; /* its name in the run's folder; NULL: it stays where it is */
} files[] = {{"sample.checkpoint", NULL}, {"sample.file", "grains.csv"}, {"sample.size_table", "sizes.csv"}};
enum { FILES = sizeof files / sizeof files[0] };

/* What a key says in a scene's text; NULL if there is none, to be freed. */
static char *path_of(const char *text, const char *key)
{
    config_t config;
    const char *value = NULL;
    char *path = NULL, *checked;
    if (config_literals(text, "scene", &checked) != STATUS_OK) /* sim says what is wrong, an include too */
        return NULL;
    config_init(&config);
    if (config_read_string(&config, checked) == CONFIG_TRUE &&
        config_lookup_string(&config, key, &value) == CONFIG_TRUE)
        path = g_strdup(value);
    config_destroy(&config);
    free(checked);
    return path;
}

/* As libconfig writes texts. */
static char *quoted(const char *value)
{
    GString *text = g_string_new("\"");
    for (; *value; value++) {
        if (*value == '"' || *value == '\\')
            g_string_append_c(text, '\\');
        g_string_append_c(text, *value);
    }
    g_string_append_c(text, '"');
    return g_string_free(text, FALSE);
}

static char *absolute_of(const char *scene, const char *path)
{
    char *folder = g_path_get_dirname(scene);
    char *here = g_canonicalize_filename(folder, NULL);
    char *absolute = g_canonicalize_filename(path, here);
    g_free(folder);
    g_free(here);
    return absolute;
}

/* `text` with the first `from` behind `at` replaced. */
static char *replaced(const char *text, const char *at, const char *from, const char *to)
{
    return g_strdup_printf("%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
}

static bool reads_as(const char *text, const char *key, const char *path)
{
    char *read = path_of(text, key);
    bool same = read && strcmp(read, path) == 0;
    g_free(read);
    return same;
}

/* What the copy says instead of `path`; to be freed. */
static char *path_in_copy(int file, const char *scene, const char *path)
{
    return files[file].kept ? g_strdup(files[file].kept) : absolute_of(scene, path);
}

/* Tries each place where the path stands in the text, until the key reads as wanted. */
static enum status text_resolve(char **text, int file, const char *scene, const char *path)
{
    const char *key = files[file].key;
    char *wanted = path_in_copy(file, scene, path), *from = quoted(path), *to = quoted(wanted), *result = NULL;
    for (const char *at = strstr(*text, from); at && !result; at = strstr(at + 1, from)) {
        char *changed = replaced(*text, at, from, to);
        if (reads_as(changed, key, wanted))
            result = changed;
        else
            g_free(changed);
    }
    enum status status = STATUS_OK;
    if (!result)
        status = status_fail(STATUS_CONFIG, "%s: %s: the path %s is not spelled in one piece", scene, key, from);
    if (result) {
        g_free(*text);
        *text = result;
    }
    g_free(wanted);
    g_free(from);
    g_free(to);
    return status;
}

static enum status file_write(const char *folder, const char *name, const char *text)
{
    GError *error = NULL;
    char *path = g_build_filename(folder, name, NULL);
    enum status status = STATUS_OK;
    if (!g_file_set_contents(path, text, -1, &error)) {
        status = status_fail(STATUS_IO, "%s", error->message);
        g_error_free(error);
    }
    g_free(path);
    return status;
}

/* "KEY=path", with or without quotes: the path, to be freed; NULL for other words. */
static char *path_of_word(const char *word, const char *key)
{
    const size_t n = strlen(key);
    if (strncmp(word, key, n) != 0 || word[n] != '=')
        return NULL;
    char *path = g_strstrip(g_strdup(word + n + 1));
    const size_t length = strlen(path);
    if (length >= 2 && path[0] == '"' && path[length - 1] == '"') {
        path[length - 1] = '\0';
        memmove(path, path + 1, length - 1);
    }
    return path;
}

/* A word of the command line with the path that the copy needs; other words as they are. */
static char *word_resolve(const char *scene, const char *word)
{
    for (int k = 0; k < FILES; k++) {
        char *path = path_of_word(word, files[k].key);
        if (!path)
            continue;
        const bool moves = path[0] && (files[k].kept || path[0] != '/');
        char *wanted = path_in_copy(k, scene, path), *value = quoted(wanted);
        char *resolved = moves ? g_strdup_printf("%s=%s", files[k].key, value) : g_strdup(word);
        g_free(path);
        g_free(wanted);
        g_free(value);
        return resolved;
    }
    return g_strdup(word);
}

/* The path that counts: of the last word that gives it, else of the text; NULL: none. */
static char *path_in_force(int file, const char *text, char *const *words)
{
    char *path = path_of(text, files[file].key);
    for (; *words; words++) {
        char *other = path_of_word(*words, files[file].key);
        if (other) {
            g_free(path);
            path = other;
        }
    }
    return path;
}

static enum status stream_copy(FILE *from, FILE *to, const char *name)
{
    char block[1 << 16];
    size_t n;
    while ((n = fread(block, 1, sizeof block, from)) > 0)
        if (fwrite(block, 1, n, to) != n)
            break;
    return ferror(from) || ferror(to) ? status_fail(STATUS_IO, "%s cannot be copied: %s", name, g_strerror(errno))
                                      : STATUS_OK;
}

/* From where the two streams are on. */
static bool streams_agree(FILE *a, FILE *b)
{
    int c, d;
    do {
        c = getc(a);
        d = getc(b);
    } while (c == d && c != EOF);
    return c == d;
}

/* Nothing that is there is overwritten: it may be the file itself, or someone else's. */
static enum status file_copy(const char *from, const char *to)
{
    FILE *in = fopen(from, "rb");
    if (!in)
        return status_fail(STATUS_IO, "%s: %s", from, g_strerror(errno));
    FILE *there = fopen(to, "rb");
    if (there) {
        const bool same = streams_agree(in, there);
        fclose(there);
        fclose(in);
        return same ? STATUS_OK
                    : status_fail(STATUS_IO, "%s is there already, and is not %s; allowed: another folder", to, from);
    }
    FILE *out = fopen(to, "wb");
    enum status status = out ? stream_copy(in, out, from) : status_fail(STATUS_IO, "%s: %s", to, g_strerror(errno));
    if (out && fclose(out) != 0 && status == STATUS_OK)
        status = status_fail(STATUS_IO, "%s: %s", to, g_strerror(errno));
    fclose(in);
    return status;
}

/* The file itself, if the copy has it beside. */
static enum status file_keep(int file, const char *scene, const char *folder, const char *text, char *const *words)
{
    char *path = files[file].kept ? path_in_force(file, text, words) : NULL;
    enum status status = STATUS_OK;
    if (path && path[0]) {
        char *from = absolute_of(scene, path), *to = g_build_filename(folder, files[file].kept, NULL);
        status = file_copy(from, to);
        g_free(from);
        g_free(to);
    }
    g_free(path);
    return status;
}

static enum status file_resolve(char **text, int file, const char *scene, const char *folder, char *const *words)
{
    char *path = path_of(*text, files[file].key);
    enum status status = file_keep(file, scene, folder, *text, words);
    if (status == STATUS_OK && path && path[0] && (files[file].kept || path[0] != '/'))
        status = text_resolve(text, file, scene, path);
    g_free(path);
    return status;
}

static enum status scene_write(const char *scene, const char *folder, char *const *words)
{
    GError *error = NULL;
    char *text = NULL;
    if (!g_file_get_contents(scene, &text, NULL, &error)) {
        enum status status = status_fail(STATUS_IO, "%s", error->message);
        g_error_free(error);
        return status;
    }
    enum status status = STATUS_OK;
    for (int k = 0; k < FILES && status == STATUS_OK; k++)
        status = file_resolve(&text, k, scene, folder, words);
    if (status == STATUS_OK)
        status = file_write(folder, "scene.cfg", text);
    g_free(text);
    return status;
}

enum status scene_copy(const char *scene, const char *folder, char *const *words)
{
    for (char *const *word = words; *word; word++)
        if (strchr(*word, '\n'))
            return status_fail(STATUS_USAGE, "a word of the command line holds a line end: %s", *word);
    TRY(scene_write(scene, folder, words));
    GString *text = g_string_new(NULL);
    for (; *words; words++) {
        char *word = word_resolve(scene, *words);
        g_string_append_printf(text, "%s\n", word);
        g_free(word);
    }
    enum status status = file_write(folder, "overrides", text->str);
    g_string_free(text, TRUE);
    return status;
}
