#include "recorder/run_store.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "recorder/file_placement.h"
#include "recorder/folder_lock.h"
#include "recorder/xdmf.h"

struct run_store {
    char directory[PATH_MAX];
    char path[PATH_MAX], part_path[PATH_MAX], log_path[PATH_MAX], xdmf_path[PATH_MAX];
    int lock;
    bool has_log, keep_log, replace;
    store_remake remake;
    struct run_facts facts;
    struct run_writer *writer; /* NULL: not begun, or given up as the disk was full */
    bool begun;
    struct event_writer *log;
    struct xdmf xdmf;
    struct run_counts counts;
};

static enum status make_path(char path[PATH_MAX], const char *directory, const char *name)
{
    int length = snprintf(path, PATH_MAX, "%s/%s", directory, name);
    return length < PATH_MAX ? STATUS_OK : status_fail(STATUS_IO, "the path %s is too long", directory);
}

/* Makes `directory` and those above it. */
static enum status directory_make(const char *directory)
{
    char path[PATH_MAX];
    TRY(make_path(path, directory, ""));
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        if (mkdir(path, 0777) != 0 && errno != EEXIST)
            return status_fail(STATUS_IO, "cannot make the directory %s: %s", path, strerror(errno));
        *slash = '/';
    }
    if (access(directory, W_OK | X_OK) != 0)
        return status_fail(STATUS_IO, "cannot write into %s: %s", directory, strerror(errno));
    return STATUS_OK;
}

static enum status refuse_existing(const char *path)
{
    if (access(path, F_OK) == 0)
        return status_fail(STATUS_IO, "%s exists; a run is never overwritten: take another directory or remove it",
                           path);
    return STATUS_OK;
}

enum status run_store_create(struct run_store **result, const struct run_store_options *options)
{
    struct run_store *store = *result = calloc(1, sizeof *store);
    if (!store)
        return status_fail(STATUS_NO_MEMORY, "no memory for the recording");
    store->lock = -1;
    store->has_log = options->log;
    store->replace = options->replace;
    store->remake = options->remake;
    TRY(make_path(store->directory, options->directory, ""));
    TRY(make_path(store->path, options->directory, "run.h5"));
    TRY(make_path(store->part_path, options->directory, "run.h5.part"));
    TRY(make_path(store->log_path, options->directory, "run.lcm"));
    TRY(make_path(store->xdmf_path, options->directory, "run.xdmf"));
    TRY(directory_make(options->directory));
    TRY(folder_lock(options->directory, &store->lock));
    if (options->replace)
        return STATUS_OK;
    TRY(refuse_existing(store->path));
    return options->log ? refuse_existing(store->log_path) : STATUS_OK;
}

enum status run_store_begin(struct run_store *store, const shakedown_run_info_t *info, bool walls, bool keep_log)
{
    store->facts = run_facts_of(info);
    store->keep_log = keep_log;
    if (unlink(store->part_path) != 0 && errno != ENOENT)
        return status_fail(STATUS_IO, "cannot remove %s: %s", store->part_path, strerror(errno));
    if (store->has_log && !store->replace)
        TRY(event_writer_open(&store->log, store->log_path, EVENT_START_NEW));
    TRY(run_writer_create(&store->writer, store->part_path, info, walls));
    store->begun = true;
    return STATUS_OK;
}

enum status run_store_continue(struct run_store *store, int64_t size)
{
    TRY(event_writer_open(&store->log, store->log_path, EVENT_START_APPEND));
    return event_writer_cut(store->log, size);
}

static void writer_give_up(struct run_store *store)
{
    run_writer_abandon(store->writer);
    store->writer = NULL;
    if (unlink(store->part_path) != 0)
        fprintf(stderr, "recorder: warning: cannot remove %s: %s\n", store->part_path, strerror(errno));
}

/* A store with a log does not need run.h5 before the end. */
static enum status writer_check(struct run_store *store, enum status status)
{
    if (status != STATUS_IO || !store->has_log)
        return status;
    fprintf(stderr, "recorder: warning: %s; the log goes on, run.h5 is made from it at the end\n", status_message());
    writer_give_up(store);
    return STATUS_OK;
}

enum status run_store_particles(struct run_store *store, const struct particle_set *set)
{
    return store->writer ? writer_check(store, run_writer_particles(store->writer, set)) : STATUS_OK;
}

enum status run_store_sample(struct run_store *store, const shakedown_sample_t *sample)
{
    return store->writer ? writer_check(store, run_writer_sample(store->writer, sample)) : STATUS_OK;
}

enum status run_store_note(struct run_store *store, const shakedown_note_t *note)
{
    return store->writer ? writer_check(store, run_writer_note(store->writer, note)) : STATUS_OK;
}

enum status run_store_particle_frame(struct run_store *store, const struct particle_frame *frame)
{
    TRY(xdmf_frame_add(&store->xdmf, frame->place.time_s));
    return store->writer ? writer_check(store, run_writer_particle_frame(store->writer, frame)) : STATUS_OK;
}

enum status run_store_contact_frame(struct run_store *store, const struct contact_frame *frame)
{
    return store->writer ? writer_check(store, run_writer_contact_frame(store->writer, frame)) : STATUS_OK;
}

enum status run_store_wall_state(struct run_store *store, const shakedown_wall_state_t *state)
{
    return store->writer ? writer_check(store, run_writer_wall_state(store->writer, state)) : STATUS_OK;
}

enum status run_store_wall_command(struct run_store *store, const shakedown_wall_command_t *command)
{
    return store->writer ? writer_check(store, run_writer_wall_command(store->writer, command)) : STATUS_OK;
}

enum status run_store_log(struct run_store *store, int kind, const void *data, size_t size)
{
    return store->log ? event_writer_add(store->log, message_channel(kind), data, size) : STATUS_OK;
}

enum status run_store_secure(struct run_store *store, bool sync)
{
    if (!store->log)
        return STATUS_OK;
    return sync ? event_writer_sync(store->log) : event_writer_flush(store->log);
}

bool run_store_log_is_full(const struct run_store *store)
{
    return store->log && event_writer_is_full(store->log);
}

static enum status publish(struct run_store *store)
{
    TRY(file_copy_into_place(store->part_path, store->path));
    return xdmf_write(&store->xdmf, &store->facts, store->xdmf_path);
}

void run_store_publish(struct run_store *store)
{
    if (!store->writer || writer_check(store, run_writer_flush(store->writer)) != STATUS_OK || !store->writer)
        return;
    if (publish(store) != STATUS_OK)
        fprintf(stderr, "recorder: warning: run.h5 stays as it is for now: %s\n", status_message());
}

/* run.h5.part is whole: into its place. */
static enum status part_finish(struct run_store *store, const shakedown_end_t *end, bool complete)
{
    enum status status = end ? run_writer_end(store->writer, end) : STATUS_OK;
    store->counts = run_writer_counts(store->writer);
    if (status == STATUS_OK)
        status = xdmf_write(&store->xdmf, &store->facts, store->xdmf_path);
    if (status != STATUS_OK) {
        writer_give_up(store);
        return status;
    }
    status = run_writer_close(store->writer, complete);
    store->writer = NULL;
    if (status == STATUS_OK)
        status = file_into_place(store->part_path, store->path);
    if (status != STATUS_OK)
        (void)unlink(store->part_path); /* its room is wanted */
    return status;
}

/* The disk was full before and perhaps is not any more. */
static enum status make_from_log(struct run_store *store)
{
    folder_unlock(store->lock);
    store->lock = -1;
    if (!store->remake)
        return status_fail(STATUS_IO, "%s is not made; %s is whole", store->path, store->log_path);
    return store->remake(store->log_path, store->directory, &store->counts);
}

static void keep(enum status *first, enum status status)
{
    if (*first == STATUS_OK)
        *first = status;
}

enum status run_store_finish(struct run_store *store, const shakedown_end_t *end, bool complete)
{
    enum status status = STATUS_OK;
    if (!store->begun)
        return STATUS_OK;
    if (store->log)
        keep(&status, event_writer_sync(store->log));
    keep(&status, event_writer_close(store->log));
    store->log = NULL;
    const bool whole = complete && status == STATUS_OK; /* the log first */
    enum status made = store->writer ? part_finish(store, end, whole) : STATUS_IO;
    if (made == STATUS_IO && store->has_log)
        made = make_from_log(store);
    keep(&status, made);
    if (status == STATUS_OK && whole && end->status == STATUS_OK && store->has_log && !store->keep_log)
        (void)unlink(store->log_path); /* all of it is in run.h5, on disk */
    folder_unlock(store->lock);
    store->lock = -1;
    return status;
}

struct run_counts run_store_counts(const struct run_store *store)
{
    return store->counts;
}

const char *run_store_path(const struct run_store *store)
{
    return store->path;
}

const char *run_store_log_path(const struct run_store *store)
{
    return store->log_path;
}

void run_store_free(struct run_store *store)
{
    if (!store)
        return;
    if (store->writer)
        writer_give_up(store);
    if (event_writer_close(store->log) != STATUS_OK)
        fprintf(stderr, "recorder: warning: %s\n", status_message());
    folder_unlock(store->lock);
    xdmf_free(&store->xdmf);
    free(store);
}
