/* LCM event logs (28 bytes of header, channel, data; lcm/eventlog.h), as the record of a run: appended to, each event
 * with a checksum, and a reader that takes any bytes, where liblcm's trusts the sizes it reads.
 * The header's event number carries the checksum: its upper half is the CRC-32 of all behind it and of its lower half,
 * which is the event's place in the file modulo 2^32. LCM's tools do not look at it; logs of theirs have no checksums.
 */
#ifndef SHAKEDOWN_COMMON_EVENT_LOG_H
#define SHAKEDOWN_COMMON_EVENT_LOG_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "common/status.h"

enum { EVENT_CHANNEL_MAX = 64, EVENT_DATA_MAX = 1 << 20 };

struct event {
    char channel[EVENT_CHANNEL_MAX]; /* zero ended */
    int64_t time_us;                 /* since 1970, as the writer's clock said */
    size_t size;
    unsigned char *data; /* [size], valid until the next read */
};

struct event_reader {
    FILE *file;
    unsigned char *buffer; /* [EVENT_DATA_MAX] */
    int64_t events;        /* whole ones so far */
    int64_t skipped_bytes; /* that belong to no event */
    bool checked;          /* the first event had a checksum: so must all */
    bool cut;              /* the file ends within an event */
};

enum status event_reader_open(struct event_reader *reader, const char *path) MUST_USE;
void event_reader_close(struct event_reader *reader);

/* The next event that is whole; *found false at the end of the file. Bytes that are no event are skipped and counted.
 */
enum status event_reader_next(struct event_reader *reader, struct event *event, bool *found) MUST_USE;

/* The place behind the event that was read last, in bytes from the start. */
int64_t event_reader_place(const struct event_reader *reader);

struct event_writer;

enum event_start {
    EVENT_START_NEW,    /* STATUS_IO if the file exists and is not empty */
    EVENT_START_APPEND, /* goes on at its end; STATUS_IO if it does not exist */
};

enum status event_writer_open(struct event_writer **writer, const char *path, enum event_start start) MUST_USE;

/* Keeps an event and writes in blocks. A full disk is no failure as long as 16 MB are not exceeded: what waits is
 * written by the next call that finds room (event_writer_is_full). STATUS_IO for other failures. */
enum status event_writer_add(struct event_writer *writer, const char *channel, const void *data, size_t size) MUST_USE;

/* Writes what waits; after STATUS_IO of a full disk it can be tried again, nothing is lost and nothing is there twice.
 */
enum status event_writer_flush(struct event_writer *writer) MUST_USE;
enum status event_writer_sync(struct event_writer *writer) MUST_USE; /* and on disk */
bool event_writer_is_full(const struct event_writer *writer);        /* the last write found no room */

/* Bytes of all events, written or waiting. */
int64_t event_writer_size(const struct event_writer *writer);

/* Drops all behind `size`; STATUS_FORMAT if there is less. */
enum status event_writer_cut(struct event_writer *writer, int64_t size) MUST_USE;

/* Flushes and closes; frees the writer also on failure. NULL is nothing. */
enum status event_writer_close(struct event_writer *writer) MUST_USE;

#endif
