#include "launcher/scene_copy.h"

#include <glib.h>
#include <libconfig.h>
#include <stdbool.h>
#include <string.h>

static const char key[] = "sample.checkpoint";

/* The path in a scene's text; NULL if there is none, to be freed. */
static char *checkpoint_of(const char *text)
{
    config_t config;
    const char *value = NULL;
    char *path = NULL;
    config_init(&config);
    if (config_read_string(&config, text) == CONFIG_TRUE && config_lookup_string(&config, key, &value) == CONFIG_TRUE)
        path = g_strdup(value);
    config_destroy(&config);
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

static bool reads_as(const char *text, const char *path)
{
    char *read = checkpoint_of(text);
    bool same = read && strcmp(read, path) == 0;
    g_free(read);
    return same;
}

/* Tries each place where the path stands in the text, until the key reads as wanted. */
static enum status text_resolve(char **text, const char *scene, const char *path)
{
    char *absolute = absolute_of(scene, path), *from = quoted(path), *to = quoted(absolute), *result = NULL;
    for (const char *at = strstr(*text, from); at && !result; at = strstr(at + 1, from)) {
        char *changed = replaced(*text, at, from, to);
        if (reads_as(changed, absolute))
            result = changed;
        else
            g_free(changed);
    }
    enum status status = STATUS_OK;
    if (!result)
        status = status_fail(STATUS_CONFIG, "%s: %s: the path %s is not spelled in one piece; give it as %s", scene,
                             key, from, to);
    if (result) {
        g_free(*text);
        *text = result;
    }
    g_free(absolute);
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

static enum status scene_write(const char *scene, const char *folder)
{
    GError *error = NULL;
    char *text = NULL;
    if (!g_file_get_contents(scene, &text, NULL, &error)) {
        enum status status = status_fail(STATUS_IO, "%s", error->message);
        g_error_free(error);
        return status;
    }
    char *path = checkpoint_of(text);
    enum status status = STATUS_OK;
    if (path && path[0] && path[0] != '/')
        status = text_resolve(&text, scene, path);
    if (status == STATUS_OK)
        status = file_write(folder, "scene.cfg", text);
    g_free(path);
    g_free(text);
    return status;
}

/* "sample.checkpoint=path", with or without quotes, with the path made absolute; other words as they are. */
static char *word_resolve(const char *scene, const char *word)
{
    const size_t n = strlen(key);
    if (strncmp(word, key, n) != 0 || word[n] != '=')
        return g_strdup(word);
    char *path = g_strstrip(g_strdup(word + n + 1));
    const size_t length = strlen(path);
    if (length >= 2 && path[0] == '"' && path[length - 1] == '"') {
        path[length - 1] = '\0';
        memmove(path, path + 1, length - 1);
    }
    char *absolute = absolute_of(scene, path), *value = quoted(absolute);
    char *resolved = path[0] == '/' || !path[0] ? g_strdup(word) : g_strdup_printf("%s=%s", key, value);
    g_free(path);
    g_free(absolute);
    g_free(value);
    return resolved;
}

enum status scene_copy(const char *scene, const char *folder, char *const *words)
{
    for (char *const *word = words; *word; word++)
        if (strchr(*word, '\n'))
            return status_fail(STATUS_USAGE, "a word of the command line holds a line end: %s", *word);
    TRY(scene_write(scene, folder));
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
