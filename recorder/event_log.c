#include "recorder/event_log.h"

#include <errno.h>
#include <fcntl.h>
#include <lcm/eventlog.h>
#include <lcm/lcm.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { HEADER_SIZE = 24, MAGIC_SIZE = 4, CHANNEL_LENGTH_AT = 16, DATA_LENGTH_AT = 20 };
static const uint32_t MAGIC = 0xEDA1DA01u;

struct event_writer {
    lcm_eventlog_t *log;
};

enum status event_reader_open(struct event_reader *reader, const char *path)
{
    *reader = (struct event_reader){.file = fopen(path, "rb")};
    if (!reader->file)
        return status_fail(STATUS_IO, "cannot open %s: %s", path, strerror(errno));
    reader->buffer = malloc(EVENT_DATA_MAX);
    return reader->buffer ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "no memory to read %s", path);
}

void event_reader_close(struct event_reader *reader)
{
    if (reader->file && fclose(reader->file) != 0) {
        /* opened for reading: nothing can be lost */
    }
    free(reader->buffer);
    *reader = (struct event_reader){0};
}

/* Goes on to just after the next magic number. */
static bool find_magic(struct event_reader *reader)
{
    uint32_t last = 0;
    int64_t bytes = 0;
    for (int c = fgetc(reader->file); c != EOF; c = fgetc(reader->file)) {
        bytes++;
        last = last << 8 | (uint32_t)c;
        if (bytes >= MAGIC_SIZE && last == MAGIC) {
            reader->skipped_bytes += bytes - MAGIC_SIZE;
            return true;
        }
    }
    reader->skipped_bytes += bytes;
    reader->cut |= bytes > 0;
    return false;
}

static uint32_t big_endian(const unsigned char *bytes)
{
    return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

enum event_result { EVENT_WHOLE, EVENT_DAMAGED, EVENT_CUT };

/* Reads what follows a magic number. */
static enum event_result read_event(struct event_reader *reader, struct event *event)
{
    unsigned char header[HEADER_SIZE];
    if (fread(header, 1, sizeof header, reader->file) != sizeof header)
        return EVENT_CUT;
    uint32_t channel_length = big_endian(header + CHANNEL_LENGTH_AT);
    uint32_t size = big_endian(header + DATA_LENGTH_AT);
    if (channel_length == 0 || channel_length >= EVENT_CHANNEL_MAX || size > EVENT_DATA_MAX)
        return EVENT_DAMAGED;
    memset(event->channel, 0, sizeof event->channel);
    if (fread(event->channel, 1, channel_length, reader->file) != channel_length ||
        fread(reader->buffer, 1, size, reader->file) != size)
        return EVENT_CUT;
    event->data = reader->buffer;
    event->size = size;
    return EVENT_WHOLE;
}

enum status event_reader_next(struct event_reader *reader, struct event *event, bool *found)
{
    *found = false;
    while (find_magic(reader)) {
        off_t start = ftello(reader->file);
        enum event_result result = read_event(reader, event);
        if (ferror(reader->file) || start < 0)
            return status_fail(STATUS_IO, "cannot read the log: %s", strerror(errno));
        *found = result == EVENT_WHOLE;
        if (*found)
            return STATUS_OK;
        /* A damaged length may hide whole events after it: look on right behind the magic number. */
        reader->cut |= result == EVENT_CUT;
        reader->skipped_bytes += MAGIC_SIZE;
        clearerr(reader->file);
        if (fseeko(reader->file, start, SEEK_SET) != 0)
            return status_fail(STATUS_IO, "cannot read the log: %s", strerror(errno));
    }
    return STATUS_OK;
}

enum status event_writer_create(struct event_writer **result, const char *path)
{
    struct event_writer *writer = *result = calloc(1, sizeof *writer);
    if (!writer)
        return status_fail(STATUS_NO_MEMORY, "no memory for the event log");
    int file = open(path, O_CREAT | O_EXCL | O_WRONLY, 0666); /* liblcm would overwrite */
    if (file < 0 || close(file) != 0)
        return status_fail(STATUS_IO, "cannot create %s: %s", path, strerror(errno));
    writer->log = lcm_eventlog_create(path, "w");
    return writer->log ? STATUS_OK : status_fail(STATUS_IO, "cannot create %s: %s", path, strerror(errno));
}

static enum status write_failed(void)
{
    return status_fail(STATUS_IO, "cannot write run.lcm: %s", strerror(errno));
}

/* Finds where the event that `is_last` ends. */
static enum status find_end(const char *path, bool (*is_last)(const struct event *event, const void *user),
                            const void *user, off_t *end)
{
    struct event_reader reader;
    struct event event;
    bool found = true, last = false;
    enum status status = event_reader_open(&reader, path);
    while (status == STATUS_OK && found && !last) {
        status = event_reader_next(&reader, &event, &found);
        last = status == STATUS_OK && found && is_last(&event, user);
    }
    *end = last ? ftello(reader.file) : -1;
    event_reader_close(&reader);
    if (status == STATUS_OK && *end < 0)
        status = status_fail(STATUS_IO, "%s does not reach to the checkpoint", path);
    return status;
}

enum status event_writer_resume(struct event_writer **result, const char *path,
                                bool (*is_last)(const struct event *event, const void *user), const void *user)
{
    off_t end;
    struct event_writer *writer = *result = calloc(1, sizeof *writer);
    if (!writer)
        return status_fail(STATUS_NO_MEMORY, "no memory for the event log");
    TRY(find_end(path, is_last, user, &end));
    if (truncate(path, end) == 0)
        writer->log = lcm_eventlog_create(path, "a");
    return writer->log ? STATUS_OK : status_fail(STATUS_IO, "cannot go on with %s: %s", path, strerror(errno));
}

enum status event_writer_add(struct event_writer *writer, const char *channel, const void *data, size_t size)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    lcm_eventlog_event_t event = {.timestamp = (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000,
                                  .channellen = (int32_t)strlen(channel),
                                  .datalen = (int32_t)size,
                                  .channel = (char *)(uintptr_t)channel,
                                  .data = (void *)(uintptr_t)data};
    /* liblcm does not see all short writes */
    bool ok = lcm_eventlog_write_event(writer->log, &event) == 0 && !ferror(writer->log->f);
    return ok ? STATUS_OK : write_failed();
}

enum status event_writer_flush(struct event_writer *writer)
{
    return fflush(writer->log->f) == 0 && !ferror(writer->log->f) ? STATUS_OK : write_failed();
}

enum status event_writer_sync(struct event_writer *writer)
{
    TRY(event_writer_flush(writer));
    return fsync(fileno(writer->log->f)) == 0 ? STATUS_OK : write_failed();
}

enum status event_writer_close(struct event_writer *writer)
{
    enum status status = STATUS_OK;
    if (!writer)
        return status;
    if (writer->log) {
        status = event_writer_flush(writer);
        lcm_eventlog_destroy(writer->log);
    }
    free(writer);
    return status;
}
