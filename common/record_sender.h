/* Sender's side of the record stream (lcmtypes/CHANNELS.md): windowed, what is lost is sent again (selective repeat
 * with a measured round trip) until acknowledged. All waits end by silence of the recorder: STATUS_TIMEOUT after
 * timeout_s without an acknowledgement, or after 3 s (0.5 s) once the run was asked to stop (twice). */
#ifndef SHAKEDOWN_COMMON_RECORD_SENDER_H
#define SHAKEDOWN_COMMON_RECORD_SENDER_H

#include "common/bus.h"

struct record_sender;

/* `bus` must outlive the stream; timeout_s: longest silence. On a log
 * (bus->is_log) records are written at once and nothing is waited for. */
enum status record_sender_create(struct record_sender **stream, struct bus *bus, int64_t run_id,
                                 double timeout_s) MUST_USE;
void record_sender_free(struct record_sender *stream);

/* Goes on after `total` [RECORD_CHANNELS] records with their `hash` and `exchanges` of the walls, all of them
 * acknowledged; before the first record. Total 0 of RUN_INFO: it and PARTICLES are said again, which changes no hash.
 */
void record_sender_resume(struct record_sender *stream, const int64_t total[RECORD_CHANNELS],
                          const int64_t hash[RECORD_CHANNELS], int64_t exchanges);

/* The seq the next record on this channel must carry. */
int64_t record_sender_next_seq(const struct record_sender *stream, enum record_channel channel);

/* Queues a copy of the encoded record and sends it when the window allows. Blocks only while more than 64 MB wait.
 * STATUS_IO if the recorder said that it cannot write. */
enum status record_sender_publish(struct record_sender *stream, enum record_channel channel, const void *data,
                                  size_t size) MUST_USE;

/* Handles acknowledgements that have come, sends what the window allows, sends again what is late. Never blocks. */
enum status record_sender_service(struct record_sender *stream) MUST_USE;

/* For wall messages that are to be recorded: they go to the recorder as they go to whom they are for. Before those
 * number `seq` do, waits until the recorder has all but the last WALLS_WINDOW, so that its socket does not overflow. */
enum status record_sender_wait_for_walls(struct record_sender *stream, int64_t seq) MUST_USE;

/* Keeps a copy of one that goes out or has come (size at most WALL_MESSAGE_MAX), first the state, then the command, to
 * be sent again like a record if the recorder does not acknowledge the exchange. */
void record_sender_keep_wall(struct record_sender *stream, bool command, int64_t seq, const void *data, size_t size);

/* Waits until everything is acknowledged (for END: until `complete`). */
enum status record_sender_flush(struct record_sender *stream) MUST_USE;

int64_t record_sender_total(const struct record_sender *stream, enum record_channel channel); /* records published */
int64_t record_sender_hash(const struct record_sender *stream, enum record_channel channel);  /* of these */
int64_t record_sender_repeated(const struct record_sender *stream);                           /* records sent again */
int64_t record_sender_waiting(const struct record_sender *stream);                            /* not yet acknowledged */

#endif
