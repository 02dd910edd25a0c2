#include "recorder/verify.h"

#include <hdf5.h>
#include <inttypes.h>
#include <limits.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/message.h"
#include "common/record_hash.h"

/* What is known of one run. */
struct inspection {
    FILE *out;
    int64_t total[MESSAGE_LOGGED_KINDS]; /* of the log */
    int64_t hash[RECORD_CHANNELS];
    int64_t last_step[MESSAGE_LOGGED_KINDS];
    int64_t run_id;
    bool has_run, ended, end_is_good;
    int missing, damaged; /* findings of either kind */
    int64_t end_samples;  /* that END counts; -1: no END */
};

static void PRINTF_LIKE(3, 4) found(struct inspection *at, int *kind, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("  ", at->out);
    vfprintf(at->out, format, arguments);
    fputc('\n', at->out);
    va_end(arguments);
    ++*kind;
}

/* ---- the log ---- */

static void compare(struct inspection *at, const char *who, const int64_t *total, const int64_t *hash)
{
    for (int c = 0; c < RECORD_END; c++) {
        if (total[c] != at->total[c])
            found(at, &at->missing, "%s counts %" PRId64 " records on %s, the log has %" PRId64, who, total[c],
                  record_channel_name[c], at->total[c]);
        else if (hash[c] != at->hash[c])
            found(at, &at->damaged, "%s: the records on %s are not those that were sent", who, record_channel_name[c]);
    }
}

static void look_at_end(struct inspection *at, const shakedown_end_t *end)
{
    at->ended = true;
    at->end_is_good = end->status == STATUS_OK;
    at->end_samples = end->total[RECORD_SAMPLE];
    compare(at, "END", end->total, end->hash);
    if (at->total[MESSAGE_WALL_STATE] > 0 &&
        (end->wall_states != at->total[MESSAGE_WALL_STATE] || end->wall_commands != at->total[MESSAGE_WALL_COMMAND]))
        found(at, &at->missing,
              "END counts %" PRId64 " wall states and %" PRId64 " commands, the log has %" PRId64 " and %" PRId64,
              end->wall_states, end->wall_commands, at->total[MESSAGE_WALL_STATE], at->total[MESSAGE_WALL_COMMAND]);
    fprintf(at->out, "  END: status %d, state_hash %016" PRIx64 "%s%s\n", end->status, (uint64_t)end->state_hash,
            end->reason[0] ? ", " : "", end->reason);
}

static void look_at_header(struct inspection *at, int kind, const union message *message)
{
    const char *channel = message_channel(kind);
    if (message->header.seq != at->total[kind])
        found(at, &at->missing, "%s: number %" PRId64 " where %" PRId64 " was due", channel, message->header.seq,
              at->total[kind]);
    if (at->total[kind] > 0 && message->header.step < at->last_step[kind])
        found(at, &at->damaged, "%s: step %" PRId64 " after step %" PRId64, channel, message->header.step,
              at->last_step[kind]);
    at->last_step[kind] = message->header.step;
}

static void look_at_event(struct inspection *at, const struct event *event)
{
    const int kind = message_kind(event->channel);
    union message message;
    if (kind < 0 || kind >= MESSAGE_LOGGED_KINDS)
        return;
    if (message_decode(kind, event->data, event->size, &message) != STATUS_OK) {
        found(at, &at->damaged, "%s", status_message());
        return;
    }
    if (!at->has_run && kind == RECORD_RUN_INFO) {
        at->has_run = true;
        at->run_id = message.header.run_id;
    }
    if (at->has_run && message.header.run_id == at->run_id) {
        look_at_header(at, kind, &message);
        if (kind == RECORD_CHECKPOINT)
            compare(at, "CHECKPOINT", message.checkpoint.total, message.checkpoint.hash);
        if (kind == RECORD_END)
            look_at_end(at, &message.end);
        at->total[kind] = message.header.seq + 1;
        if (kind < RECORD_CHANNELS)
            at->hash[kind] = record_hash_add(at->hash[kind], event->data, event->size);
    }
    message_free(kind, &message);
}

static enum status look_at_log(struct inspection *at, const char *path)
{
    struct event_reader reader;
    struct event event;
    bool have = true;
    fprintf(at->out, "%s\n", path);
    TRY(event_reader_open(&reader, path));
    enum status status = event_reader_next(&reader, &event, &have);
    while (status == STATUS_OK && have) {
        look_at_event(at, &event);
        status = event_reader_next(&reader, &event, &have);
    }
    fprintf(at->out, "  %" PRId64 " messages%s\n", reader.events,
            reader.checked ? ", each with its checksum" : " without checksums");
    if (reader.skipped_bytes > 0)
        found(at, reader.cut ? &at->missing : &at->damaged, "%" PRId64 " bytes that are no whole message%s",
              reader.skipped_bytes, reader.cut ? " (the end is cut)" : "");
    event_reader_close(&reader);
    if (!at->has_run)
        found(at, &at->missing, "no RUN_INFO");
    if (!at->ended)
        found(at, &at->missing, "no END: the run did not end, or goes on");
    return status;
}

/* ---- run.h5 ---- */

/* Reads all of a dataset, in slices of its first axis. */
static bool dataset_is_readable(hid_t id)
{
    enum { SLICE_BYTES = 16 << 20 };
    hsize_t dims[H5S_MAX_RANK] = {1}, start[H5S_MAX_RANK] = {0}, count[H5S_MAX_RANK];
    hid_t space = H5Dget_space(id), type = H5Dget_type(id);
    int rank = space < 0 ? -1 : H5Sget_simple_extent_dims(space, dims, NULL);
    size_t row = type < 0 ? 0 : H5Tget_size(type);
    bool ok = rank >= 0 && row > 0;
    for (int k = 1; ok && k < rank; k++)
        row *= dims[k] > 0 ? dims[k] : 1;
    hsize_t rows = ok && row < SLICE_BYTES ? SLICE_BYTES / row : 1;
    void *buffer = ok ? malloc((size_t)rows * row) : NULL;
    ok = ok && buffer;
    memcpy(count, dims, sizeof count);
    while (ok && rank > 0 && start[0] < dims[0]) {
        count[0] = dims[0] - start[0] < rows ? dims[0] - start[0] : rows;
        hid_t memory = H5Screate_simple(rank, count, NULL);
        ok = memory >= 0 && H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) >= 0 &&
             H5Dread(id, type, memory, space, H5P_DEFAULT, buffer) >= 0 && H5Sclose(memory) >= 0;
        start[0] += count[0];
    }
    if (ok && rank == 0)
        ok = H5Dread(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, buffer) >= 0;
    free(buffer);
    return (type < 0 || H5Tclose(type) >= 0) && (space < 0 || H5Sclose(space) >= 0) && ok;
}

static herr_t look_at_object(hid_t file, const char *name, const H5O_info_t *info, void *user)
{
    struct inspection *at = user;
    if (info->type != H5O_TYPE_DATASET || strncmp(name, "xdmf/", 5) == 0) /* these show what is read elsewhere */
        return 0;
    hid_t id = H5Dopen2(file, name, H5P_DEFAULT);
    if (id < 0 || !dataset_is_readable(id))
        found(at, &at->damaged, "/%s cannot be read", name);
    return id < 0 || H5Dclose(id) >= 0 ? 0 : -1;
}

/* An attribute of the root; -1: not there. */
static int64_t root_number(hid_t file, const char *name)
{
    int64_t value = -1;
    hid_t id = H5Aexists(file, name) > 0 ? H5Aopen(file, name, H5P_DEFAULT) : H5I_INVALID_HID;
    if (id < 0)
        return -1;
    if (H5Aread(id, H5T_NATIVE_INT64, &value) < 0)
        value = -1;
    return H5Aclose(id) >= 0 ? value : -1;
}

static int64_t rows_of(hid_t file, const char *path)
{
    hsize_t dims[H5S_MAX_RANK] = {0};
    hid_t id = H5Dopen2(file, path, H5P_DEFAULT), space = id < 0 ? id : H5Dget_space(id);
    int rank = space < 0 ? -1 : H5Sget_simple_extent_dims(space, dims, NULL);
    if (space >= 0 && H5Sclose(space) < 0)
        return -1;
    if (id >= 0 && H5Dclose(id) < 0)
        return -1;
    return rank > 0 ? (int64_t)dims[0] : -1;
}

static void look_inside(struct inspection *at, hid_t file)
{
    const int64_t complete = root_number(file, "complete"), status = root_number(file, "status");
    const int64_t samples = rows_of(file, "/samples/stage/value");
    if (H5Ovisit(file, H5_INDEX_NAME, H5_ITER_NATIVE, look_at_object, at) < 0)
        found(at, &at->damaged, "its objects cannot all be visited");
    fprintf(at->out, "  complete %" PRId64 ", %" PRId64 " samples, %" PRId64 " frames\n", complete, samples,
            rows_of(file, "/particles/trajectory/position/step"));
    if (complete != 1)
        found(at, &at->missing, "not complete: made before the end of its run, or records are missing");
    if (at->end_samples >= 0 && samples != at->end_samples)
        found(at, &at->missing, "END counts %" PRId64 " samples", at->end_samples);
    at->end_is_good |= complete == 1 && status == 0;
    at->ended |= complete == 1;
}

static void look_at_file(struct inspection *at, const char *path)
{
    fprintf(at->out, "%s\n", path);
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    hid_t file =
        access < 0 || H5Pset_file_locking(access, 0, 1) < 0 ? H5I_INVALID_HID : H5Fopen(path, H5F_ACC_RDONLY, access);
    if (file < 0)
        found(at, &at->damaged, "it cannot be opened");
    else
        look_inside(at, file);
    if ((file >= 0 && H5Fclose(file) < 0) || (access >= 0 && H5Pclose(access) < 0))
        found(at, &at->damaged, "it cannot be closed");
}

/* ---- both ---- */

static enum status verdict(struct inspection *at)
{
    if (at->damaged > 0)
        return status_fail(STATUS_FORMAT, "damaged: %d findings (./shakedown repair makes run.h5 from what is whole)",
                           at->damaged + at->missing);
    if (at->missing > 0)
        return status_fail(STATUS_INCOMPLETE, "incomplete: %d findings", at->missing);
    fprintf(at->out, "complete%s\n", at->end_is_good ? "" : ", of a run that did not end well");
    return STATUS_OK;
}

enum status verify_run(const char *directory, FILE *out)
{
    struct inspection at = {.out = out, .end_samples = -1};
    char log[PATH_MAX], path[PATH_MAX];
    if (snprintf(log, sizeof log, "%s/run.lcm", directory) >= (int)sizeof log ||
        snprintf(path, sizeof path, "%s/run.h5", directory) >= (int)sizeof path)
        return status_fail(STATUS_USAGE, "the path %s is too long", directory);
    const bool has_log = access(log, F_OK) == 0, has_file = access(path, F_OK) == 0;
    if (!has_log && !has_file)
        return status_fail(STATUS_IO, "neither run.lcm nor run.h5 in %s", directory);
    for (int c = 0; c < RECORD_CHANNELS; c++)
        at.hash[c] = RECORD_HASH_OF_NONE;
    if (H5Eset_auto2(H5E_DEFAULT, NULL, NULL) < 0)
        return status_fail(STATUS_IO, "cannot set up HDF5");
    if (has_log)
        TRY(look_at_log(&at, log));
    if (has_file)
        look_at_file(&at, path);
    else
        found(&at, &at.missing, "no run.h5 (./shakedown repair %s makes it)", directory);
    return verdict(&at);
}
