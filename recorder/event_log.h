/* LCM event logs (28 bytes of header, channel, data; lcm/eventlog.h): writing with every return checked, and a reader
 * that takes any bytes, where liblcm's trusts the sizes it reads. */
#ifndef SHAKEDOWN_RECORDER_EVENT_LOG_H
#define SHAKEDOWN_RECORDER_EVENT_LOG_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "common/status.h"

enum { EVENT_CHANNEL_MAX = 64, EVENT_DATA_MAX = 1 << 20 };

struct event {
    char channel[EVENT_CHANNEL_MAX]; /* zero ended */
    size_t size;
    unsigned char *data; /* [size], valid until the next read */
};

struct event_reader {
    FILE *file;
    unsigned char *buffer; /* [EVENT_DATA_MAX] */
    int64_t skipped_bytes; /* that belong to no event */
    bool cut;              /* the file ends within an event */
};

struct event_writer;

enum status event_reader_open(struct event_reader *reader, const char *path) MUST_USE;
void event_reader_close(struct event_reader *reader);

/* The next event that is whole; *found false at the end of the file. Bytes that are no event are skipped and counted.
 */
enum status event_reader_next(struct event_reader *reader, struct event *event, bool *found) MUST_USE;

/* Creates `path`; STATUS_IO if it exists. */
enum status event_writer_create(struct event_writer **writer, const char *path) MUST_USE;
/* Opens `path` to go on after the first event for which `is_last` says so; those behind are dropped. STATUS_IO if there
 * is none. */
enum status event_writer_resume(struct event_writer **writer, const char *path,
                                bool (*is_last)(const struct event *event, const void *user),
                                const void *user) MUST_USE;
enum status event_writer_add(struct event_writer *writer, const char *channel, const void *data, size_t size) MUST_USE;
enum status event_writer_flush(struct event_writer *writer) MUST_USE;
enum status event_writer_sync(struct event_writer *writer) MUST_USE; /* and on disk */

/* Flushes and closes; frees the writer also on failure. NULL is nothing. */
enum status event_writer_close(struct event_writer *writer) MUST_USE;

#endif
