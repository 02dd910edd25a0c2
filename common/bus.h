/* The LCM bus as Shakedown uses it: every subscription with a queue that does not drop, checked returns, and one
 * URL rule. Also opens event logs by a file:// URL. */
#ifndef SHAKEDOWN_COMMON_BUS_H
#define SHAKEDOWN_COMMON_BUS_H

#include <lcm/lcm.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/event_log.h"
#include "common/message_seal.h"
#include "common/short_wait.h"
#include "common/status.h"

/* Recorded channels, in the order of record_ack_t.next_seq. */
#define RECORD_CHANNEL_LIST(X)                                                                                         \
    X(RUN_INFO)                                                                                                        \
    X(PARTICLES)                                                                                                       \
    X(SAMPLE)                                                                                                          \
    X(FRAME_PARTICLES)                                                                                                 \
    X(FRAME_CONTACTS)                                                                                                  \
    X(NOTE)                                                                                                            \
    X(CHECKPOINT)                                                                                                      \
    X(END)

enum record_channel {
#define RECORD_CHANNEL_ENUM(name) RECORD_##name,
    RECORD_CHANNEL_LIST(RECORD_CHANNEL_ENUM)
#undef RECORD_CHANNEL_ENUM
        RECORD_CHANNELS
};

/* Channel names; the others are plain literals here so that each is spelled once. */
extern const char *const record_channel_name[RECORD_CHANNELS];
#define CHANNEL_WALL_STATE   "WALL_STATE"
#define CHANNEL_WALL_COMMAND "WALL_COMMAND"
#define CHANNEL_RECORD_ACK   "RECORD_ACK"
#define CHANNEL_STATUS       "STATUS"

enum { BUS_MESSAGE_MAX = 60000 };

struct listener;

struct bus {
    struct udp_receiver *receiver; /* receives instead of LCM; NULL: LCM does */
    lcm_t *lcm;  /* NULL: not open. Publish through bus_publish: a log that is written does not hear of it */
    bool is_log; /* file:// URL: nobody answers */
    struct event_writer *log;    /* a log that is written */
    struct message_seal *seal;   /* messages without it are not ours; NULL: all are taken */
    struct listener *listeners;  /* of a sealed bus */
    struct event_reader *replay; /* a log that is read: its messages come through an LCM of this process alone */
    struct short_wait wait;      /* of BUS_LOOK */
};

/* Opens `url`; NULL or "" means $LCM_DEFAULT_URL, else udpm://239.255.76.67:7667?ttl=0. A udpm URL without
 * recv_buf_size gets recv_buf_size=4194304 appended.
 * A file:// URL reads the log, a message with each bus_handle, writes it with ?mode=w, or goes on with ?mode=a.
 * STATUS_BUS with the likely cause (no multicast route) on failure. */
enum status bus_open(struct bus *bus, const char *url) MUST_USE;

/* The same, but receives in the caller's thread (common/udp_receiver.h) where the URL lets it: quick answers, and no
 * wake-ups by what others are told, for those who take few channels, whose senders wait for them (windows). */
enum status bus_open_direct(struct bus *bus, const char *url) MUST_USE;
void bus_close(struct bus *bus);

/* Writes what a log that is written still buffers, so that a full disk is noticed; does nothing on a network.
 * STATUS_IO if the disk does not take it. */
enum status bus_flush(struct bus *bus) MUST_USE;

/* The same, fsync included; *size becomes the length of the log [bytes], 0 on a network. */
enum status bus_log_sync(struct bus *bus, int64_t *size) MUST_USE;

/* Cuts a log that was opened with ?mode=a to `size` bytes; STATUS_FORMAT if it is shorter. */
enum status bus_log_cut(struct bus *bus, int64_t size) MUST_USE;

/* Raw subscription to the channel of exactly this name, queue capacity raised so that nothing is dropped in normal use.
 */
enum status bus_subscribe(struct bus *bus, const char *channel, lcm_msg_handler_t handler, void *user) MUST_USE;

/* The same, for a subscriber that ends before the bus: *subscription goes to bus_unsubscribe. */
enum status bus_subscribe_for_a_while(struct bus *bus, const char *channel, lcm_msg_handler_t handler, void *user,
                                      void **subscription) MUST_USE;
void bus_unsubscribe(struct bus *bus, void *subscription);

/* Publishes `size` bytes (at most BUS_MESSAGE_MAX, else STATUS_LIMIT). That LCM took them says nothing about arrival.
 */
enum status bus_publish(struct bus *bus, const char *channel, const void *data, size_t size) MUST_USE;

/* Handles one message if one comes within timeout_ms (0: only what is there); *handled says whether.
 * On a log, the end of the file gives STATUS_OK with *handled false. A signal ends the wait early, *handled false.
 * Not to be called from a handler. */
enum status bus_handle(struct bus *bus, int timeout_ms, bool *handled) MUST_USE;

/* How a message is waited for: asleep; looking for it while short waits are expected and nobody else wants the core
 * (common/short_wait.h); or looking without end. */
enum bus_patience { BUS_SLEEP, BUS_LOOK, BUS_BUSY };

/* The same, timed to a fraction of a millisecond. */
enum status bus_wait(struct bus *bus, double timeout_s, enum bus_patience patience, bool *handled) MUST_USE;

/* Monotonic wall-clock time in seconds. */
double clock_now_s(void);

#endif
