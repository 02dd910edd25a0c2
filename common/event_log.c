#include "common/event_log.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include <zlib.h>

/* After the magic number: number, time, lengths. */
enum { MAGIC_SIZE = 4, NUMBER_SIZE = 8, HEADER_SIZE = 24 };
enum { TIME_AT = 8, CHANNEL_LENGTH_AT = 16, DATA_LENGTH_AT = 20 };
enum { BLOCK_BYTES = 64 * 1024, WAITING_MAX = 16 * 1024 * 1024 };
static const uint32_t MAGIC = 0xEDA1DA01u;

static void put_big_endian(unsigned char *bytes, uint64_t value, int count)
{
    for (int k = 0; k < count; k++)
        bytes[k] = (unsigned char)(value >> (8 * (count - 1 - k)));
}

static uint64_t big_endian(const unsigned char *bytes, int count)
{
    uint64_t value = 0;
    for (int k = 0; k < count; k++)
        value = value << 8 | bytes[k];
    return value;
}

/* Of a header behind its checksum, channel and data; never 0, which says that there is none. */
static uint32_t checksum(const unsigned char header[HEADER_SIZE], const void *channel, size_t channel_length,
                         const void *data, size_t size)
{
    uLong sum = crc32(0, header + NUMBER_SIZE / 2, HEADER_SIZE - NUMBER_SIZE / 2);
    sum = crc32(sum, channel, (uInt)channel_length);
    sum = crc32(sum, data, (uInt)size);
    return sum == 0 ? 1 : (uint32_t)sum;
}

/* ---- reading ---- */

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

int64_t event_reader_place(const struct event_reader *reader)
{
    return (int64_t)ftello(reader->file);
}

/* Goes on to just after the next magic number. */
static bool find_magic(struct event_reader *reader)
{
    uint32_t last = 0;
    int64_t bytes = 0;
    for (int c = getc(reader->file); c != EOF; c = getc(reader->file)) {
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

enum event_result { EVENT_WHOLE, EVENT_DAMAGED, EVENT_CUT };

/* The first event tells whether the log has checksums. */
static bool checksum_fits(struct event_reader *reader, const unsigned char header[HEADER_SIZE], const char *channel,
                          size_t channel_length, size_t size)
{
    uint32_t expected = (uint32_t)big_endian(header, NUMBER_SIZE / 2);
    if (reader->events == 0)
        reader->checked = expected != 0;
    return !reader->checked || expected == checksum(header, channel, channel_length, reader->buffer, size);
}

/* Reads what follows a magic number. */
static enum event_result read_event(struct event_reader *reader, struct event *event)
{
    unsigned char header[HEADER_SIZE];
    if (fread(header, 1, sizeof header, reader->file) != sizeof header)
        return EVENT_CUT;
    size_t channel_length = (size_t)big_endian(header + CHANNEL_LENGTH_AT, 4);
    size_t size = (size_t)big_endian(header + DATA_LENGTH_AT, 4);
    if (channel_length == 0 || channel_length >= EVENT_CHANNEL_MAX || size > EVENT_DATA_MAX)
        return EVENT_DAMAGED;
    memset(event->channel, 0, sizeof event->channel);
    if (fread(event->channel, 1, channel_length, reader->file) != channel_length ||
        fread(reader->buffer, 1, size, reader->file) != size)
        return EVENT_CUT;
    if (!checksum_fits(reader, header, event->channel, channel_length, size))
        return EVENT_DAMAGED;
    event->time_us = (int64_t)big_endian(header + TIME_AT, 8);
    event->data = reader->buffer;
    event->size = size;
    reader->events++;
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

/* ---- writing ---- */

struct event_writer {
    int file;
    int64_t written;        /* bytes in the file */
    unsigned char *waiting; /* [used] of [capacity] */
    size_t used, capacity;
    bool full;
    char path[];
};

static enum status write_failed(const struct event_writer *writer)
{
    return status_fail(STATUS_IO, "cannot write %s: %s", writer->path, strerror(errno));
}

static enum status file_open(struct event_writer *writer, enum event_start start)
{
    struct stat file;
    int flags = start == EVENT_START_NEW ? O_CREAT : 0;
    writer->file = open(writer->path, O_WRONLY | O_CLOEXEC | flags, 0666);
    if (writer->file < 0 || fstat(writer->file, &file) != 0)
        return status_fail(STATUS_IO, "cannot open the event log %s: %s", writer->path, strerror(errno));
    if (start == EVENT_START_NEW && file.st_size > 0)
        return status_fail(STATUS_IO, "%s holds a run already; a log is never overwritten: take another or remove it",
                           writer->path);
    writer->written = file.st_size;
    /* a pipe or a device has no places */
    return lseek(writer->file, 0, SEEK_END) < 0 && errno != ESPIPE ? write_failed(writer) : STATUS_OK;
}

enum status event_writer_open(struct event_writer **result, const char *path, enum event_start start)
{
    size_t length = strlen(path) + 1;
    struct event_writer *writer = *result = calloc(1, sizeof *writer + length);
    if (!writer)
        return status_fail(STATUS_NO_MEMORY, "no memory for the event log");
    writer->file = -1;
    memcpy(writer->path, path, length);
    return file_open(writer, start);
}

static enum status reserve(struct event_writer *writer, size_t size)
{
    if (writer->used + size <= writer->capacity)
        return STATUS_OK;
    size_t capacity = 2 * (writer->used + size) + BLOCK_BYTES;
    unsigned char *grown = realloc(writer->waiting, capacity);
    if (!grown)
        return status_fail(STATUS_NO_MEMORY, "no memory for the event log");
    writer->waiting = grown;
    writer->capacity = capacity;
    return STATUS_OK;
}

static int64_t now_us(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now); /* cannot fail with this clock */
    return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

enum status event_writer_add(struct event_writer *writer, const char *channel, const void *data, size_t size)
{
    size_t length = strlen(channel), all = MAGIC_SIZE + HEADER_SIZE + length + size;
    TRY(reserve(writer, all));
    unsigned char *at = writer->waiting + writer->used, *header = at + MAGIC_SIZE;
    put_big_endian(at, MAGIC, MAGIC_SIZE);
    put_big_endian(header, (uint32_t)event_writer_size(writer), NUMBER_SIZE);
    put_big_endian(header + TIME_AT, (uint64_t)now_us(), 8);
    put_big_endian(header + CHANNEL_LENGTH_AT, length, 4);
    put_big_endian(header + DATA_LENGTH_AT, size, 4);
    memcpy(header + HEADER_SIZE, channel, length);
    memcpy(header + HEADER_SIZE + length, data, size);
    put_big_endian(header, checksum(header, channel, length, data, size), NUMBER_SIZE / 2);
    writer->used += all;
    if (writer->used < BLOCK_BYTES)
        return STATUS_OK;
    enum status status = event_writer_flush(writer);
    return writer->full && writer->used < WAITING_MAX ? STATUS_OK : status;
}

enum status event_writer_flush(struct event_writer *writer)
{
    size_t done = 0;
    bool ok = true;
    while (ok && done < writer->used) {
        ssize_t wrote = write(writer->file, writer->waiting + done, writer->used - done);
        ok = wrote > 0 || (wrote < 0 && errno == EINTR);
        done += wrote > 0 ? (size_t)wrote : 0;
    }
    int reason = errno;
    writer->full = !ok && (reason == ENOSPC || reason == EDQUOT);
    writer->used -= done;
    writer->written += (int64_t)done;
    if (done > 0)
        memmove(writer->waiting, writer->waiting + done, writer->used);
    errno = reason;
    return ok ? STATUS_OK : write_failed(writer);
}

enum status event_writer_sync(struct event_writer *writer)
{
    TRY(event_writer_flush(writer));
    /* EINVAL: a file that cannot be synchronised, such as a pipe */
    return fsync(writer->file) == 0 || errno == EINVAL ? STATUS_OK : write_failed(writer);
}

bool event_writer_is_full(const struct event_writer *writer)
{
    return writer->full;
}

int64_t event_writer_size(const struct event_writer *writer)
{
    return writer->written + (int64_t)writer->used;
}

enum status event_writer_cut(struct event_writer *writer, int64_t size)
{
    TRY(event_writer_flush(writer));
    if (writer->written < size)
        return status_fail(STATUS_FORMAT, "%s holds %lld bytes of the %lld that are to be gone on from", writer->path,
                           (long long)writer->written, (long long)size);
    if (ftruncate(writer->file, (off_t)size) != 0 || lseek(writer->file, 0, SEEK_END) < 0)
        return status_fail(STATUS_IO, "cannot cut %s: %s", writer->path, strerror(errno));
    writer->written = size;
    return STATUS_OK;
}

enum status event_writer_close(struct event_writer *writer)
{
    enum status status = STATUS_OK;
    if (!writer)
        return status;
    if (writer->file >= 0) {
        status = event_writer_flush(writer);
        if (close(writer->file) != 0 && status == STATUS_OK)
            status = write_failed(writer);
    }
    free(writer->waiting);
    free(writer);
    return status;
}
