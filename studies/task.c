#include "studies/task.h"

#include <errno.h>
#include <glob.h>
#include <hdf5.h>
#include <inttypes.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/signals.h"
#include "studies/files.h"
#include "studies/process.h"

enum { LOG_END = 600 }; /* characters of a failed program's log that are shown */

/* What a run leaves in its folder; patterns. */
static const char *const products[] = {"done",     "analysis.json", "curves.csv",  "cycles.csv", "run.h5",
                                       "run.xdmf", "run.lcm*",      "checkpoint*", "log",        "failure",
                                       "*.new",    "*.tmp",         NULL};

enum status task_open(struct task *task, const char *out, const char *name)
{
    char path[2400], *text = NULL;
    memset(task, 0, sizeof *task);
    if (snprintf(task->out, sizeof task->out, "%s", out) >= (int)sizeof task->out ||
        snprintf(task->folder, sizeof task->folder, "%s/runs/%s", out, name) >= (int)sizeof task->folder)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", out);
    TRY(files_join(path, sizeof path, task->folder, "settings"));
    if (!files_exist(path))
        return STATUS_OK;
    TRY(files_read(path, &text));
    int found = sscanf(text, "settings %16[0-9a-f] preparation %16[0-9a-f]", task->hash, task->preparation);
    free(text);
    return found >= 1 ? STATUS_OK : status_fail(STATUS_FORMAT, "%s: not a study's", path);
}

static enum status products_remove(const char *folder, const char *const *patterns)
{
    for (int k = 0; patterns[k]; k++) {
        char pattern[2400];
        glob_t found;
        TRY(files_join(pattern, sizeof pattern, folder, patterns[k]));
        if (glob(pattern, GLOB_NOSORT, NULL, &found) != 0)
            continue;
        enum status status = STATUS_OK;
        for (size_t j = 0; status == STATUS_OK && j < found.gl_pathc; j++)
            status = files_remove(found.gl_pathv[j]);
        globfree(&found);
        TRY(status);
    }
    return STATUS_OK;
}

static enum status set_locked(struct task *task, const char *scene, const char *hash, const char *preparation)
{
    char path[2400], text[128];
    TRY(products_remove(task->folder, products));
    TRY(files_join(path, sizeof path, task->folder, "scene.cfg"));
    TRY(files_write(path, scene));
    snprintf(text, sizeof text, preparation[0] ? "settings %s\npreparation %s\n" : "settings %s\n", hash, preparation);
    TRY(files_join(path, sizeof path, task->folder, "settings"));
    TRY(files_write(path, text));
    snprintf(task->hash, sizeof task->hash, "%s", hash);
    snprintf(task->preparation, sizeof task->preparation, "%s", preparation);
    return STATUS_OK;
}

static enum status folder_lock(const char *folder, int *lock)
{
    char path[2400];
    TRY(files_join(path, sizeof path, folder, "lock"));
    return files_lock(path, lock);
}

enum status task_set(struct task *task, const char *scene, const char *hash, const char *preparation)
{
    int lock;
    TRY(files_make_folder(task->folder));
    TRY(folder_lock(task->folder, &lock));
    enum status status = set_locked(task, scene, hash, preparation);
    (void)close(lock);
    return status;
}

/* The attribute by which the recorder says that nothing is missing. */
static bool record_is_complete(const char *folder)
{
    char path[2400];
    int complete = 0;
    if (files_join(path, sizeof path, folder, "run.h5") != STATUS_OK || !files_exist(path))
        return false;
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file < 0)
        return false;
    hid_t attribute = H5Aopen(file, "complete", H5P_DEFAULT);
    if (attribute >= 0) {
        if (H5Aread(attribute, H5T_NATIVE_INT, &complete) < 0)
            complete = 0;
        (void)H5Aclose(attribute);
    }
    (void)H5Fclose(file);
    return complete == 1;
}

static bool analysis_is_complete(const char *folder)
{
    char path[2400];
    if (files_join(path, sizeof path, folder, "analysis.json") != STATUS_OK)
        return false;
    json_t *root = json_load_file(path, 0, NULL);
    bool complete = root && json_is_true(json_object_get(root, "complete"));
    json_decref(root);
    return complete;
}

bool task_is_done(const struct task *task)
{
    char path[2400], *text = NULL;
    if (!task->hash[0] || files_join(path, sizeof path, task->folder, "done") != STATUS_OK || !files_exist(path) ||
        files_read(path, &text) != STATUS_OK)
        return false;
    bool same = strncmp(text, task->hash, strlen(task->hash)) == 0;
    free(text);
    return same && record_is_complete(task->folder) && analysis_is_complete(task->folder);
}

/* STATUS_INTERRUPTED, or STATUS_INCOMPLETE with the end of the log. */
static enum status failed(const char *folder, const char *what)
{
    char path[2400], *text = NULL;
    if (stop_requested())
        return status_fail(STATUS_INTERRUPTED, "%s: interrupted", folder);
    TRY(files_join(path, sizeof path, folder, "log"));
    if (!files_exist(path) || files_read(path, &text) != STATUS_OK)
        return status_fail(STATUS_INCOMPLETE, "%s: %s", folder, what);
    size_t length = strlen(text);
    enum status status = status_fail(STATUS_INCOMPLETE, "%s: %s; the end of its log:\n%s", folder, what,
                                     text + (length > LOG_END ? length - LOG_END : 0));
    free(text);
    return status;
}

/* One program in the folder, its exit code told but not judged. */
static enum status program(const char *folder, const char *bin, const char *name, const char *const *arguments,
                           int *code)
{
    enum { MOST = 20 };
    char path[2400], log[2400];
    const char *argv[MOST + 2] = {path};
    int n = 1;
    if (snprintf(path, sizeof path, "%s/%s/%s", bin, name, name) >= (int)sizeof path)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", bin);
    for (int k = 0; arguments[k] && n < MOST; k++)
        argv[n++] = arguments[k];
    TRY(files_join(log, sizeof log, folder, "log"));
    return process_run(argv, folder, log, code);
}

/* Whether the simulator came to its end: sound or doubtful, which the record says. */
static bool is_end(int code)
{
    return code == 0 || code == status_exit_code(STATUS_DOUBTFUL);
}

static enum status prepare(const char *folder, const char *bin, int *code)
{
    static const char *const fresh[] = {"scene.cfg", "--in-process", "--progress", "--checkpoint",
                                        "part.h5",   "--run-id",     "1",          NULL};
    static const char *const resumed[] = {
        "scene.cfg", "--in-process", "--progress", "--checkpoint", "part.h5", "--run-id", "1",
        "--resume",  "part.h5",      NULL};
    char path[2400];
    TRY(files_join(path, sizeof path, folder, "part.h5"));
    if (files_exist(path)) {
        TRY(program(folder, bin, "sim", resumed, code));
        if (is_end(*code) || stop_requested())
            return STATUS_OK;
        TRY(files_remove(path)); /* of another version: from the start */
    }
    return program(folder, bin, "sim", fresh, code);
}

/* The last checkpoint gets its name only when the simulator has come to the end. */
static enum status preparation_make(const char *folder, const char *bin)
{
    char part[2400], whole[2400];
    int code;
    TRY(files_join(part, sizeof part, folder, "part.h5"));
    TRY(files_join(whole, sizeof whole, folder, TASK_PREPARED));
    TRY(prepare(folder, bin, &code));
    if (!is_end(code) || stop_requested() || !files_exist(part))
        return failed(folder, "the preparation failed");
    static const char *const used_up[] = {"part-*", "checkpoint-*", NULL};
    TRY(products_remove(folder, used_up));
    if (rename(part, whole) != 0)
        return status_fail(STATUS_IO, "%s: %s", whole, strerror(errno));
    return STATUS_OK;
}

/* Makes the preparation that the run starts from, unless it is there; whoever comes second waits. */
static enum status preparation_ensure(const struct task *task, const char *bin)
{
    char folder[2200], path[2400];
    int lock;
    if (!task->preparation[0])
        return STATUS_OK;
    snprintf(folder, sizeof folder, "%s/prepared/%s", task->out, task->preparation);
    TRY(files_join(path, sizeof path, folder, TASK_PREPARED));
    TRY(folder_lock(folder, &lock));
    enum status status = files_exist(path) ? STATUS_OK : preparation_make(folder, bin);
    (void)close(lock);
    return status;
}

static enum status simulate(const struct task *task, const char *bin)
{
    static const char *const former[] = {"run.lcm*", "checkpoint*", NULL};
    char id[32], path[2400], log[2400];
    int code;
    /* the same run, whoever goes on with it */
    snprintf(id, sizeof id, "%" PRIu64, files_hash(task->hash) >> 2);
    const char *const fresh[] = {
        "scene.cfg", "--in-process",          "--progress", "--checkpoint", "checkpoint.h5", "--run-id", id,
        "--lcm",     "file://run.lcm?mode=w", NULL};
    const char *const resumed[] = {"scene.cfg",
                                   "--in-process",
                                   "--progress",
                                   "--checkpoint",
                                   "checkpoint.h5",
                                   "--run-id",
                                   id,
                                   "--lcm",
                                   "file://run.lcm?mode=a",
                                   "--resume",
                                   "checkpoint.h5",
                                   NULL};
    TRY(files_join(path, sizeof path, task->folder, "checkpoint.h5"));
    TRY(files_join(log, sizeof log, task->folder, "run.lcm"));
    if (files_exist(path) && files_exist(log)) {
        TRY(program(task->folder, bin, "sim", resumed, &code));
        if (is_end(code) || stop_requested())
            return STATUS_OK;
    }
    /* from the start: there is no checkpoint, or it is of another version, or the log does not fit */
    TRY(products_remove(task->folder, former));
    return program(task->folder, bin, "sim", fresh, &code);
}

static enum status record(const struct task *task, const char *bin)
{
    static const char *const arguments[] = {"--from", "run.lcm", "--out", ".", NULL};
    static const char *const former[] = {"run.h5", "run.xdmf", NULL};
    int code;
    TRY(products_remove(task->folder, former));
    return program(task->folder, bin, "recorder", arguments, &code);
}

static enum status analyse(const struct task *task, const char *bin)
{
    static const char *const arguments[] = {"--no-plots", ".", NULL};
    int code;
    return program(task->folder, bin, "analyzer", arguments, &code);
}

/* Everything is in run.h5 now. */
static enum status conclude(const struct task *task)
{
    static const char *const used_up[] = {"run.lcm*", "checkpoint*", NULL};
    char path[2400], text[32];
    TRY(products_remove(task->folder, used_up));
    snprintf(text, sizeof text, "%s\n", task->hash);
    TRY(files_join(path, sizeof path, task->folder, "done"));
    return files_write(path, text);
}

static enum status run_locked(const struct task *task, const char *bin)
{
    if (task_is_done(task))
        return STATUS_OK;
    if (!record_is_complete(task->folder)) {
        TRY(preparation_ensure(task, bin));
        TRY(simulate(task, bin));
        if (stop_requested())
            return failed(task->folder, "");
        TRY(record(task, bin));
    }
    if (!record_is_complete(task->folder))
        return failed(task->folder, "the run is not complete");
    TRY(analyse(task, bin));
    if (!analysis_is_complete(task->folder))
        return failed(task->folder, "there is no analysis of it");
    return conclude(task);
}

/* What cannot be noted is in the log as well. */
static void note_write(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");
    if (file && (fputs(text, file) == EOF || fclose(file) != 0))
        (void)unlink(path);
}

/* Why the run failed, for whoever started it; none if it did not. */
static void failure_note(const struct task *task, enum status status)
{
    char path[2400];
    if (files_join(path, sizeof path, task->folder, "failure") != STATUS_OK)
        return;
    if (status == STATUS_OK || status == STATUS_INTERRUPTED)
        (void)unlink(path);
    else
        note_write(path, status_message());
}

enum status task_run(const struct task *task, const char *bin)
{
    int lock;
    if (!task->hash[0])
        return status_fail(STATUS_USAGE, "%s: not a run of a study", task->folder);
    TRY(folder_lock(task->folder, &lock));
    enum status status = run_locked(task, bin);
    failure_note(task, status);
    (void)close(lock);
    return status;
}

enum status task_failure(const struct task *task, char **text)
{
    char path[2400];
    *text = NULL;
    TRY(files_join(path, sizeof path, task->folder, "failure"));
    if (files_exist(path))
        return files_read(path, text);
    *text = strdup("ended without a word");
    return *text ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "out of memory");
}
