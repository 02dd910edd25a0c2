#include "common/record_stream.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "common/coupling.h"
#include "common/message.h"
#include "shakedown_record_ack_t.h"

/* At most this much unacknowledged on the wire: below the default receive buffer of a socket. */
enum { WINDOW_BYTES = 128 * 1024, WAITING_BYTES_MAX = 64 * 1024 * 1024 };
enum { HANDLED_PER_SERVICE_MAX = 1024, WAIT_STEP_MS = 5 };
/* Silence counts as a recorder that is gone only after as many repeats: a sender that seldom looks at its stream must
 * not blame the recorder for its own absence. */
enum { REPEATS_BEFORE_TIMEOUT = 3 };
static const double RESEND_AFTER_S = 0.1;

struct record {
    struct record *next;
    enum record_channel channel;
    int64_t seq;
    bool sent;      /* at least once */
    bool in_flight; /* in the current round */
    size_t size;
    unsigned char data[];
};

/* A wall message that may have to be sent again; size 0: none. */
struct wall_copy {
    size_t size;
    unsigned char data[WALL_MESSAGE_MAX];
};

struct record_stream {
    struct bus *bus;
    void *subscription;
    int64_t run_id;
    double timeout_s;
    struct record *first;   /* oldest unacknowledged; NULL: none */
    struct record **end;    /* where the next one is linked */
    struct record *to_send; /* first that is not in flight; NULL: all are */
    size_t in_flight_bytes, waiting_bytes;
    int64_t waiting, repeated;
    int64_t total[RECORD_CHANNELS];         /* published */
    int64_t acked[RECORD_CHANNELS];         /* the recorder's next_seq */
    struct wall_copy wall[WALLS_WINDOW][2]; /* by seq, modulo the window: state, command */
    int64_t walls_end;                      /* exchanges below are complete */
    int64_t acked_walls;                    /* and these are with the recorder */
    double walls_at_s; /* last acknowledgement of such, or first exchange after none was waiting, or last repeat */
    bool complete, failed;
    double progress_at_s; /* last acknowledgement of something new, or first record after none was waiting */
    double round_at_s;    /* the same, or the last time that everything was sent again */
    int repeats_without_progress;
};

static void progress_note(struct record_stream *stream)
{
    stream->progress_at_s = stream->round_at_s = clock_now_s();
    stream->repeats_without_progress = 0;
}

/* END is kept until the recorder confirms the whole run, so that a lost last acknowledgement is asked for again. */
static bool is_acknowledged(const struct record_stream *stream, const struct record *record)
{
    return record->channel == RECORD_END ? stream->complete : record->seq < stream->acked[record->channel];
}

static void acknowledged_release(struct record_stream *stream)
{
    struct record **link = &stream->first;
    while (*link && (*link)->sent) {
        struct record *record = *link;
        if (!is_acknowledged(stream, record)) {
            link = &record->next;
            continue;
        }
        *link = record->next;
        if (stream->to_send == record)
            stream->to_send = record->next;
        if (stream->end == &record->next)
            stream->end = link;
        stream->in_flight_bytes -= record->in_flight ? record->size : 0;
        stream->waiting_bytes -= record->size;
        stream->waiting--;
        free(record);
    }
}

/* Takes an acknowledgement over; one that claims what was never published is not ours to believe. */
static void ack_take(struct record_stream *stream, const shakedown_record_ack_t *ack)
{
    bool progress = false;
    for (int c = 0; c < RECORD_CHANNELS; c++)
        if (ack->next_seq[c] > stream->total[c])
            return;
    for (int c = 0; c < RECORD_CHANNELS; c++) {
        if (ack->next_seq[c] <= stream->acked[c])
            continue;
        stream->acked[c] = ack->next_seq[c];
        progress = true;
    }
    /* one more: a recorder may have heard a command that is still on its way to here */
    if (ack->next_wall_seq > stream->acked_walls && ack->next_wall_seq <= stream->walls_end + 1) {
        stream->acked_walls = ack->next_wall_seq;
        stream->walls_at_s = clock_now_s();
    }
    bool complete = ack->complete && stream->total[RECORD_END] > 0;
    progress |= complete && !stream->complete;
    stream->complete |= complete;
    stream->failed |= ack->failed != 0;
    if (!progress)
        return;
    progress_note(stream);
    acknowledged_release(stream);
}

static void on_ack(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct record_stream *stream = user;
    struct message_header header;
    shakedown_record_ack_t ack = {0}, empty = {0};
    int32_t count = 0;
    (void)channel;
    size_t empty_bytes = (size_t)shakedown_record_ack_t_encoded_size(&empty);
    if (!message_header_read(buffer->data, buffer->data_size, &header) || header.run_id != stream->run_id ||
        !message_count_read(buffer->data, buffer->data_size, empty_bytes, sizeof *ack.next_seq,
                            sizeof ack.complete + sizeof ack.failed, &count) ||
        count != RECORD_CHANNELS)
        return;
    if (shakedown_record_ack_t_decode(buffer->data, 0, (int)buffer->data_size, &ack) >= 0)
        ack_take(stream, &ack);
    shakedown_record_ack_t_decode_cleanup(&ack);
}

enum status record_stream_create(struct record_stream **stream, struct bus *bus, int64_t run_id, double timeout_s)
{
    struct record_stream *created = calloc(1, sizeof *created);
    *stream = NULL;
    if (!created)
        return status_fail(STATUS_NO_MEMORY, "no memory for the record stream");
    created->bus = bus;
    created->run_id = run_id;
    created->timeout_s = timeout_s;
    created->end = &created->first;
    enum status status = bus_subscribe_for_a_while(bus, CHANNEL_RECORD_ACK, on_ack, created, &created->subscription);
    if (status != STATUS_OK) {
        record_stream_free(created);
        return status;
    }
    *stream = created;
    return STATUS_OK;
}

void record_stream_free(struct record_stream *stream)
{
    if (!stream)
        return;
    bus_unsubscribe(stream->bus, stream->subscription);
    for (struct record *record = stream->first; record;) {
        struct record *next = record->next;
        free(record);
        record = next;
    }
    free(stream);
}

void record_stream_resume(struct record_stream *stream, const int64_t total[RECORD_CHANNELS], int64_t exchanges)
{
    memcpy(stream->total, total, sizeof stream->total);
    memcpy(stream->acked, total, sizeof stream->acked);
    stream->walls_end = stream->acked_walls = exchanges;
}

int64_t record_stream_next_seq(const struct record_stream *stream, enum record_channel channel)
{
    return stream->total[channel];
}

int64_t record_stream_total(const struct record_stream *stream, enum record_channel channel)
{
    return stream->total[channel];
}

int64_t record_stream_repeated(const struct record_stream *stream)
{
    return stream->repeated;
}

int64_t record_stream_waiting(const struct record_stream *stream)
{
    return stream->waiting;
}

/* After 100 ms without progress the round starts again at the oldest record. */
static void late_rewind(struct record_stream *stream)
{
    double now_s = clock_now_s();
    if (stream->in_flight_bytes == 0 || now_s - stream->round_at_s < RESEND_AFTER_S)
        return;
    for (struct record *record = stream->first; record != stream->to_send; record = record->next)
        record->in_flight = false;
    stream->to_send = stream->first;
    stream->in_flight_bytes = 0;
    stream->round_at_s = now_s;
    stream->repeats_without_progress++;
}

static enum status window_send(struct record_stream *stream)
{
    while (stream->to_send) {
        struct record *record = stream->to_send;
        bool fits = stream->in_flight_bytes + record->size <= WINDOW_BYTES;
        bool skip = record->sent && is_acknowledged(stream, record);
        if (!fits)
            return STATUS_OK;
        if (!skip) {
            TRY(bus_publish(stream->bus, record_channel_name[record->channel], record->data, record->size));
            stream->repeated += record->sent;
            record->sent = record->in_flight = true;
            stream->in_flight_bytes += record->size;
        }
        stream->to_send = record->next;
    }
    return STATUS_OK;
}

/* After 100 ms without progress all exchanges that are not acknowledged go out again. */
static enum status walls_send_again(struct record_stream *stream)
{
    static const char *const channel[2] = {CHANNEL_WALL_STATE, CHANNEL_WALL_COMMAND};
    if (stream->acked_walls >= stream->walls_end || clock_now_s() - stream->walls_at_s < RESEND_AFTER_S)
        return STATUS_OK;
    for (int64_t seq = stream->acked_walls; seq < stream->walls_end; seq++) {
        for (int k = 0; k < 2; k++) {
            const struct wall_copy *copy = &stream->wall[seq % WALLS_WINDOW][k];
            TRY(bus_publish(stream->bus, channel[k], copy->data, copy->size));
            stream->repeated++;
        }
    }
    stream->walls_at_s = clock_now_s();
    return STATUS_OK;
}

static enum status ack_timeout(const struct record_stream *stream)
{
    return status_fail(STATUS_TIMEOUT,
                       "the recorder of run %" PRId64 " acknowledged nothing new for %g s; %" PRId64
                       " records wait for it (is it running, on the same LCM URL?)",
                       stream->run_id, clock_now_s() - stream->progress_at_s, stream->waiting);
}

enum status record_stream_service(struct record_stream *stream)
{
    bool handled = true;
    if (stream->bus->is_log)
        return STATUS_OK;
    for (int k = 0; handled && k < HANDLED_PER_SERVICE_MAX; k++)
        TRY(bus_handle(stream->bus, 0, &handled));
    if (stream->failed)
        return status_fail(STATUS_IO, "the recorder of run %" PRId64 " cannot write its file (disk full?)",
                           stream->run_id);
    late_rewind(stream);
    if (stream->waiting > 0 && stream->repeats_without_progress >= REPEATS_BEFORE_TIMEOUT &&
        clock_now_s() - stream->progress_at_s > stream->timeout_s)
        return ack_timeout(stream);
    TRY(walls_send_again(stream));
    return window_send(stream);
}

enum status record_stream_wait_for_walls(struct record_stream *stream, int64_t seq)
{
    if (stream->bus->is_log || seq - stream->acked_walls < WALLS_WINDOW)
        return STATUS_OK;
    const double deadline_s = clock_now_s() + stream->timeout_s;
    bool handled;
    do {
        if (clock_now_s() > deadline_s)
            return status_fail(STATUS_TIMEOUT,
                               "the recorder of run %" PRId64 " acknowledged no wall message for %g s; %" PRId64
                               " exchanges wait for it",
                               stream->run_id, stream->timeout_s, seq - stream->acked_walls);
        TRY(bus_handle(stream->bus, WAIT_STEP_MS, &handled));
        TRY(record_stream_service(stream));
    } while (seq - stream->acked_walls >= WALLS_WINDOW);
    return STATUS_OK;
}

void record_stream_keep_wall(struct record_stream *stream, bool command, int64_t seq, const void *data, size_t size)
{
    if (stream->bus->is_log || size > WALL_MESSAGE_MAX)
        return;
    struct wall_copy *copy = &stream->wall[seq % WALLS_WINDOW][command];
    copy->size = size;
    memcpy(copy->data, data, size);
    if (!command)
        return;
    if (stream->acked_walls >= stream->walls_end)
        stream->walls_at_s = clock_now_s();
    stream->walls_end = seq + 1;
}

/* A record whose run or number is not the stream's would never be acknowledged. */
static enum status record_check(const struct record_stream *stream, enum record_channel channel, const void *data,
                                size_t size)
{
    struct message_header header;
    if (size > BUS_MESSAGE_MAX)
        return status_fail(STATUS_LIMIT, "a record of %zu bytes on %s; the limit is %d", size,
                           record_channel_name[channel], BUS_MESSAGE_MAX);
    if (!message_header_read(data, size, &header) || header.run_id != stream->run_id ||
        header.seq != stream->total[channel])
        return status_fail(STATUS_FORMAT, "a record on %s does not carry run_id %" PRId64 " and seq %" PRId64,
                           record_channel_name[channel], stream->run_id, stream->total[channel]);
    return STATUS_OK;
}

static enum status record_append(struct record_stream *stream, enum record_channel channel, const void *data,
                                 size_t size)
{
    struct record *record = malloc(sizeof *record + size);
    if (!record)
        return status_fail(STATUS_NO_MEMORY, "no memory for a record of %zu bytes", size);
    *record = (struct record){.channel = channel, .seq = stream->total[channel], .size = size};
    memcpy(record->data, data, size);
    if (stream->waiting == 0)
        progress_note(stream);
    *stream->end = record;
    stream->end = &record->next;
    if (!stream->to_send)
        stream->to_send = record;
    stream->waiting++;
    stream->waiting_bytes += size;
    return STATUS_OK;
}

/* Services the stream until at most `bytes` wait, at most timeout_s. */
static enum status waiting_reduce(struct record_stream *stream, size_t bytes)
{
    double deadline_s = clock_now_s() + stream->timeout_s;
    bool handled = false;
    TRY(record_stream_service(stream));
    while (stream->waiting_bytes > bytes) {
        if (clock_now_s() > deadline_s)
            return ack_timeout(stream);
        TRY(bus_handle(stream->bus, WAIT_STEP_MS, &handled));
        TRY(record_stream_service(stream));
    }
    return STATUS_OK;
}

enum status record_stream_publish(struct record_stream *stream, enum record_channel channel, const void *data,
                                  size_t size)
{
    TRY(record_check(stream, channel, data, size));
    if (stream->bus->is_log) {
        TRY(bus_publish(stream->bus, record_channel_name[channel], data, size));
        stream->total[channel]++;
        return STATUS_OK;
    }
    TRY(record_append(stream, channel, data, size));
    stream->total[channel]++;
    return waiting_reduce(stream, WAITING_BYTES_MAX);
}

enum status record_stream_flush(struct record_stream *stream)
{
    if (stream->bus->is_log)
        return bus_flush(stream->bus);
    return waiting_reduce(stream, 0);
}
