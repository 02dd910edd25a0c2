#include "launcher/run_folder.h"

#include <errno.h>
#include <glib.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

char *run_folder_file(const struct run_folder *folder, const char *name)
{
    return g_build_filename(folder->path, name, NULL);
}

bool run_folder_has(const struct run_folder *folder, const char *name)
{
    char *path = run_folder_file(folder, name);
    bool has = g_file_test(path, G_FILE_TEST_IS_REGULAR);
    g_free(path);
    return has;
}

/* The text of a file without the last line end; NULL if there is none. */
static enum status file_read(const struct run_folder *folder, const char *name, char **text)
{
    GError *error = NULL;
    *text = NULL;
    if (!run_folder_has(folder, name))
        return STATUS_OK;
    char *path = run_folder_file(folder, name);
    enum status status = STATUS_OK;
    if (!g_file_get_contents(path, text, NULL, &error)) {
        status = status_fail(STATUS_IO, "%s", error->message);
        g_error_free(error);
    } else if (g_str_has_suffix(*text, "\n")) {
        (*text)[strlen(*text) - 1] = '\0';
    }
    g_free(path);
    return status;
}

static enum status overrides_read(struct run_folder *folder)
{
    char *text;
    TRY(file_read(folder, "overrides", &text));
    folder->overrides = g_strsplit(text ? text : "", "\n", -1);
    g_free(text);
    return STATUS_OK;
}

static enum status run_id_read(struct run_folder *folder)
{
    char *end;
    TRY(file_read(folder, "run-id", &folder->run_id));
    if (!folder->run_id)
        return status_fail(STATUS_IO, "no run-id in %s", folder->path);
    errno = 0;
    (void)strtoll(folder->run_id, &end, 10);
    if (errno != 0 || end == folder->run_id || *end)
        return status_fail(STATUS_FORMAT, "%s/run-id: \"%s\" is no number", folder->path, folder->run_id);
    return STATUS_OK;
}

/* Split into words as a shell would, but nothing is run, expanded or looked up. */
static enum status controller_read(struct run_folder *folder)
{
    GError *error = NULL;
    char *text;
    TRY(file_read(folder, "controller", &text));
    if (!text)
        return STATUS_OK;
    enum status status = STATUS_OK;
    if (!g_shell_parse_argv(text, NULL, &folder->controller, &error)) {
        status = status_fail(STATUS_USAGE, "--controller %s: %s", text, error->message);
        g_error_free(error);
    }
    g_free(text);
    return status;
}

enum status run_folder_read(struct run_folder *folder, const char *path)
{
    char *absolute = realpath(path, NULL);
    *folder = (struct run_folder){0};
    if (!absolute)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    folder->path = g_strdup(absolute);
    free(absolute);
    folder->scene = run_folder_file(folder, "scene.cfg");
    TRY(run_id_read(folder));
    TRY(overrides_read(folder));
    TRY(file_read(folder, "lcm-url", &folder->url));
    return controller_read(folder);
}

void run_folder_free(struct run_folder *folder)
{
    g_free(folder->path);
    g_free(folder->scene);
    g_free(folder->run_id);
    g_free(folder->url);
    g_strfreev(folder->overrides);
    g_strfreev(folder->controller);
    *folder = (struct run_folder){0};
}
