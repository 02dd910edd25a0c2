#include "common/record_sender.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "common/coupling.h"
#include "common/message.h"
#include "common/record_hash.h"
#include "common/round_trip_time.h"
#include "common/signals.h"

/* At most this much unacknowledged on the wire: below the default receive buffer of a socket. */
enum { WINDOW_BYTES = 128 * 1024, WAITING_BYTES_MAX = 64 * 1024 * 1024 };
enum { HANDLED_PER_SERVICE_MAX = 1024 };
static const double WAIT_STEP_S = 0.001;
/* Silence counts as a recorder that is gone only after as many repeats: a sender that seldom looks at its stream must
 * not blame the recorder for its own absence. */
enum { REPEATS_BEFORE_TIMEOUT = 3 };
/* What is not acknowledged after the measured round trip and four of its deviations (RFC 6298) goes out again; each
 * time in vain the wait doubles. */
static const double RESEND_MIN_S = 0.002, RESEND_FIRST_S = 0.02, RESEND_MAX_S = 0.1, RESEND_BACKOFF_MAX_S = 0.2;
/* What was sent this much before another one that has arrived is lost (RFC 8985). */
static const double REORDER_MIN_S = 0.0005, REORDER_MAX_S = 0.01;
/* A recorder that is heard but takes nothing, in timeouts; and the silence that is borne once the run is to stop. */
static const double PROGRESS_TIMEOUTS = 10.0, STOP_SILENCE_S = 3.0, STOP_AT_ONCE_S = 0.5;

enum { HELD_MAX = 512 }; /* how far beyond next_seq a held record can be */

struct record {
    struct record *next;
    enum record_channel channel;
    int64_t seq;
    int sends;
    bool in_flight; /* on its way, as far as we know */
    bool held;      /* the recorder has it, but not all before it */
    double sent_s;  /* last time */
    size_t size;
    unsigned char data[];
};

/* A wall message that may have to be sent again; size 0: none. */
struct wall_copy {
    size_t size;
    double sent_s;
    bool held;
    unsigned char data[WALL_MESSAGE_MAX];
};

struct record_sender {
    struct bus *bus;
    void *subscription;
    int64_t run_id;
    double timeout_s;
    struct record *first;  /* oldest unacknowledged; NULL: none */
    struct record **end;   /* where the next one is linked */
    struct record *unsent; /* first that was never sent; NULL: none */
    bool lost;             /* some before `unsent` have to go out again */
    size_t in_flight_bytes, waiting_bytes;
    int64_t waiting, repeated;
    int64_t total[RECORD_CHANNELS];         /* published */
    int64_t hash[RECORD_CHANNELS];          /* of these */
    bool repeats_start;                     /* RUN_INFO and PARTICLES are said again and counted already */
    int64_t acked[RECORD_CHANNELS];         /* the recorder's next_seq */
    struct wall_copy wall[WALLS_WINDOW][2]; /* by seq, modulo the window: state, command */
    int64_t walls_end;                      /* exchanges below are complete */
    int64_t acked_walls;                    /* and these are with the recorder */
    bool complete, waits, failed;
    double heard_at_s;    /* last acknowledgement of this run, or first record after none was waiting */
    double progress_at_s; /* the same of something new */
    double round_at_s;    /* last progress, or the last time that late ones went out again */
    int repeats_without_progress;
    struct round_trip round_trip;
};

static void progress_note(struct record_sender *stream)
{
    stream->progress_at_s = stream->round_at_s = clock_now_s();
    stream->repeats_without_progress = 0;
}

/* Something waits for the recorder where nothing did. */
static void wait_note(struct record_sender *stream)
{
    progress_note(stream);
    stream->heard_at_s = stream->progress_at_s;
}

static double at_least(double low, double value)
{
    return value < low ? low : value;
}

static double within(double low, double value, double high)
{
    return value > high ? high : at_least(low, value);
}

static double resend_after_s(const struct record_sender *stream)
{
    double wait_s = round_trip_late_s(&stream->round_trip, RESEND_MIN_S, RESEND_FIRST_S, RESEND_MAX_S);
    for (int k = 0; k < stream->repeats_without_progress && wait_s < RESEND_BACKOFF_MAX_S; k++)
        wait_s *= 2;
    return within(0, wait_s, RESEND_BACKOFF_MAX_S);
}

/* END is kept until the recorder confirms the whole run, so that a lost last acknowledgement is asked for again. */
static bool is_acknowledged(const struct record_sender *stream, const struct record *record)
{
    return record->channel == RECORD_END ? stream->complete : record->seq < stream->acked[record->channel];
}

static void record_land(struct record_sender *stream, struct record *record)
{
    stream->in_flight_bytes -= record->in_flight ? record->size : 0;
    record->in_flight = false;
}

/* What an acknowledgement says of the records that were sent. */
struct news {
    bool held[RECORD_CHANNELS][HELD_MAX]; /* by distance from next_seq */
    double latest_sent_s;                 /* of those that are acknowledged now */
    double round_trip_s;                  /* the shortest of those sent once; 0: none */
};

static void news_take_record(struct news *news, const struct record *record)
{
    const double trip_s = clock_now_s() - record->sent_s;
    if (record->sends == 1 && (news->round_trip_s <= 0 || trip_s < news->round_trip_s))
        news->round_trip_s = trip_s;
    news->latest_sent_s = at_least(news->latest_sent_s, record->sent_s);
}

/* Releases what the recorder has in order, and notes what it holds beyond that. */
static void acknowledged_release(struct record_sender *stream, struct news *news)
{
    struct record **link = &stream->first;
    while (*link && *link != stream->unsent) {
        struct record *record = *link;
        const int64_t ahead = record->seq - stream->acked[record->channel];
        const bool done = is_acknowledged(stream, record);
        const bool held = !done && ahead >= 0 && ahead < HELD_MAX && news->held[record->channel][ahead];
        if ((done && !record->held) || (held && !record->held))
            news_take_record(news, record);
        record->held |= held;
        if (done || held)
            record_land(stream, record);
        if (!done) {
            link = &record->next;
            continue;
        }
        *link = record->next;
        if (stream->end == &record->next)
            stream->end = link;
        stream->waiting_bytes -= record->size;
        stream->waiting--;
        free(record);
    }
}

static double reorder_s(const struct record_sender *stream)
{
    return within(REORDER_MIN_S, 0.25 * stream->round_trip.mean_s, REORDER_MAX_S);
}

/* What was sent well before another one that has arrived. */
static void lost_note(struct record_sender *stream, double latest_sent_s)
{
    for (struct record *record = stream->first; record != stream->unsent; record = record->next) {
        if (!record->in_flight || record->sent_s + reorder_s(stream) >= latest_sent_s)
            continue;
        record_land(stream, record);
        stream->lost = true;
    }
}

static bool acknowledgement_is_possible(const struct record_sender *stream, const shakedown_record_ack_t *ack)
{
    for (int c = 0; c < RECORD_CHANNELS; c++)
        if (ack->next_seq[c] > stream->total[c])
            return false;
    return true;
}

static void walls_take(struct record_sender *stream, const shakedown_record_ack_t *ack)
{
    /* one more: a recorder may have heard a command that is still on its way to here */
    if (ack->next_wall_seq < stream->acked_walls || ack->next_wall_seq > stream->walls_end + 1)
        return;
    if (ack->next_wall_seq > stream->acked_walls)
        progress_note(stream);
    stream->acked_walls = ack->next_wall_seq;
    for (int64_t seq = stream->acked_walls; seq < stream->walls_end; seq++)
        for (int k = 0; k < 2; k++)
            stream->wall[seq % WALLS_WINDOW][k].held |=
                (uint32_t)ack->walls_held >> (2 * (seq - stream->acked_walls) + k) & 1;
}

/* Takes an acknowledgement over; one that claims what was never published is not ours to believe. */
static void ack_take(struct record_sender *stream, const shakedown_record_ack_t *ack)
{
    struct news news = {0};
    bool progress = false;
    if (!acknowledgement_is_possible(stream, ack))
        return;
    stream->heard_at_s = clock_now_s();
    for (int c = 0; c < RECORD_CHANNELS; c++) {
        progress |= ack->next_seq[c] > stream->acked[c];
        if (ack->next_seq[c] > stream->acked[c])
            stream->acked[c] = ack->next_seq[c];
    }
    for (int k = 0; k < ack->n_held; k++) {
        const int64_t ahead = ack->held_seq[k] - stream->acked[ack->held_channel[k]];
        if (ahead >= 0 && ahead < HELD_MAX)
            news.held[ack->held_channel[k]][ahead] = true;
    }
    walls_take(stream, ack);
    bool complete = ack->complete && stream->total[RECORD_END] > 0;
    progress |= complete && !stream->complete;
    stream->complete |= complete;
    stream->failed |= ack->failed != 0;
    stream->waits = ack->waits != 0;
    acknowledged_release(stream, &news);
    if (progress || news.latest_sent_s > 0)
        progress_note(stream);
    if (news.round_trip_s > 0)
        round_trip_note(&stream->round_trip, news.round_trip_s);
    lost_note(stream, news.latest_sent_s);
}

static void on_ack(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct record_sender *stream = user;
    union message message;
    (void)channel;
    if (message_decode(MESSAGE_RECORD_ACK, buffer->data, buffer->data_size, &message) != STATUS_OK)
        return; /* the next one says the same */
    if (message.header.run_id == stream->run_id)
        ack_take(stream, &message.record_ack);
    message_free(MESSAGE_RECORD_ACK, &message);
}

enum status record_sender_create(struct record_sender **stream, struct bus *bus, int64_t run_id, double timeout_s)
{
    struct record_sender *created = calloc(1, sizeof *created);
    *stream = NULL;
    if (!created)
        return status_fail(STATUS_NO_MEMORY, "no memory for the record stream");
    created->bus = bus;
    created->run_id = run_id;
    created->timeout_s = timeout_s;
    created->end = &created->first;
    for (int c = 0; c < RECORD_CHANNELS; c++)
        created->hash[c] = RECORD_HASH_OF_NONE;
    enum status status = bus_subscribe_for_a_while(bus, CHANNEL_RECORD_ACK, on_ack, created, &created->subscription);
    if (status != STATUS_OK) {
        record_sender_free(created);
        return status;
    }
    *stream = created;
    return STATUS_OK;
}

void record_sender_free(struct record_sender *stream)
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

void record_sender_resume(struct record_sender *stream, const int64_t total[RECORD_CHANNELS],
                          const int64_t hash[RECORD_CHANNELS], int64_t exchanges)
{
    stream->repeats_start = total[RECORD_RUN_INFO] == 0;
    memcpy(stream->hash, hash, sizeof stream->hash);
    memcpy(stream->total, total, sizeof stream->total);
    memcpy(stream->acked, total, sizeof stream->acked);
    stream->walls_end = stream->acked_walls = exchanges;
}

int64_t record_sender_next_seq(const struct record_sender *stream, enum record_channel channel)
{
    return stream->total[channel];
}

int64_t record_sender_total(const struct record_sender *stream, enum record_channel channel)
{
    return stream->total[channel];
}

int64_t record_sender_hash(const struct record_sender *stream, enum record_channel channel)
{
    return stream->hash[channel];
}

int64_t record_sender_repeated(const struct record_sender *stream)
{
    return stream->repeated;
}

int64_t record_sender_waiting(const struct record_sender *stream)
{
    return stream->waiting;
}

/* Records that wait for an answer for longer than it takes count as lost; whether there were any. */
static bool late_records_land(struct record_sender *stream, double before_s)
{
    bool late = false;
    for (struct record *record = stream->first; record != stream->unsent; record = record->next) {
        if (!record->in_flight || record->sent_s > before_s)
            continue;
        record_land(stream, record);
        late = stream->lost = true;
    }
    return late;
}

/* The same of the walls. */
static bool late_walls_land(struct record_sender *stream, double before_s)
{
    bool late = false;
    for (int64_t seq = stream->acked_walls; seq < stream->walls_end; seq++)
        for (int k = 0; k < 2; k++) {
            struct wall_copy *copy = &stream->wall[seq % WALLS_WINDOW][k];
            if (copy->held || copy->sent_s > before_s)
                continue;
            copy->sent_s = 0;
            late = true;
        }
    return late;
}

static void late_land(struct record_sender *stream)
{
    const double now_s = clock_now_s(), wait_s = resend_after_s(stream);
    const bool records = late_records_land(stream, now_s - wait_s), walls = late_walls_land(stream, now_s - wait_s);
    if ((!records && !walls) || now_s - stream->round_at_s < wait_s)
        return;
    stream->round_at_s = now_s;
    stream->repeats_without_progress++;
}

static enum status record_send(struct record_sender *stream, struct record *record)
{
    TRY(bus_publish(stream->bus, record_channel_name[record->channel], record->data, record->size));
    stream->repeated += record->sends > 0;
    record->sends++;
    record->sent_s = clock_now_s();
    record->in_flight = true;
    stream->in_flight_bytes += record->size;
    return STATUS_OK;
}

static bool record_fits(const struct record_sender *stream, const struct record *record)
{
    return stream->in_flight_bytes + record->size <= WINDOW_BYTES;
}

/* What was lost first. END may be held and yet has to be said again, for the answer. */
static enum status window_send(struct record_sender *stream)
{
    struct record *record = stream->lost ? stream->first : stream->unsent;
    for (; record != stream->unsent; record = record->next) {
        if (record->in_flight || (record->held && record->channel != RECORD_END))
            continue;
        if (!record_fits(stream, record))
            return STATUS_OK;
        TRY(record_send(stream, record));
    }
    stream->lost = false;
    while (stream->unsent && record_fits(stream, stream->unsent)) {
        TRY(record_send(stream, stream->unsent));
        stream->unsent = stream->unsent->next;
    }
    return STATUS_OK;
}

static enum status wall_send(struct record_sender *stream, struct wall_copy *copy, int k)
{
    static const char *const channel[2] = {CHANNEL_WALL_STATE, CHANNEL_WALL_COMMAND};
    TRY(bus_publish(stream->bus, channel[k], copy->data, copy->size));
    copy->sent_s = clock_now_s();
    stream->repeated++;
    return STATUS_OK;
}

/* The last time that a wall message went out that the recorder holds; 0: none. */
static double walls_held_s(const struct record_sender *stream)
{
    double sent_s = 0;
    for (int64_t seq = stream->acked_walls; seq < stream->walls_end; seq++)
        for (int k = 0; k < 2; k++)
            if (stream->wall[seq % WALLS_WINDOW][k].held)
                sent_s = at_least(sent_s, stream->wall[seq % WALLS_WINDOW][k].sent_s);
    return sent_s;
}

/* Those that were lost, as a later one is there, or as nothing new was heard (late_land). */
static enum status walls_send_again(struct record_sender *stream)
{
    const double held_s = stream->acked_walls < stream->walls_end ? walls_held_s(stream) : 0;
    for (int64_t seq = stream->acked_walls; seq < stream->walls_end; seq++)
        for (int k = 0; k < 2; k++) {
            struct wall_copy *copy = &stream->wall[seq % WALLS_WINDOW][k];
            if (!copy->held && (copy->sent_s <= 0 || copy->sent_s + reorder_s(stream) < held_s))
                TRY(wall_send(stream, copy, k));
        }
    return STATUS_OK;
}

/* How long the recorder may be silent. */
static double silence_max_s(const struct record_sender *stream)
{
    if (!stop_requested())
        return stream->timeout_s;
    return within(0, stream->timeout_s, stop_request_count() > 1 ? STOP_AT_ONCE_S : STOP_SILENCE_S);
}

static enum status silence_check(const struct record_sender *stream)
{
    const double now_s = clock_now_s(), silence_s = now_s - stream->heard_at_s, idle_s = now_s - stream->progress_at_s;
    if (stream->waiting == 0 && stream->acked_walls >= stream->walls_end)
        return STATUS_OK;
    if (stream->repeats_without_progress < REPEATS_BEFORE_TIMEOUT)
        return STATUS_OK;
    if (silence_s > silence_max_s(stream))
        return status_fail(STATUS_TIMEOUT,
                           "nothing heard of the recorder of run %" PRId64 " for %.1f s; %" PRId64
                           " records and %" PRId64
                           " exchanges of the walls wait for it (is it running, on the same LCM URL?)",
                           stream->run_id, silence_s, stream->waiting, stream->walls_end - stream->acked_walls);
    if (idle_s > PROGRESS_TIMEOUTS * stream->timeout_s && !stream->waits)
        return status_fail(STATUS_TIMEOUT,
                           "the recorder of run %" PRId64 " is heard but took nothing for %.1f s; %" PRId64
                           " records and %" PRId64 " exchanges of the walls wait for it",
                           stream->run_id, idle_s, stream->waiting, stream->walls_end - stream->acked_walls);
    return STATUS_OK;
}

enum status record_sender_service(struct record_sender *stream)
{
    bool handled = true;
    if (stream->bus->is_log)
        return STATUS_OK;
    for (int k = 0; handled && k < HANDLED_PER_SERVICE_MAX; k++)
        TRY(bus_handle(stream->bus, 0, &handled));
    if (stream->failed)
        return status_fail(STATUS_IO,
                           "the recorder of run %" PRId64
                           " has failed; what it says itself (in a folder of a run log/recorder.log) "
                           "is why",
                           stream->run_id);
    late_land(stream);
    TRY(silence_check(stream));
    TRY(walls_send_again(stream));
    return window_send(stream);
}

enum status record_sender_wait_for_walls(struct record_sender *stream, int64_t seq)
{
    bool handled;
    if (stream->bus->is_log)
        return STATUS_OK;
    while (seq - stream->acked_walls >= WALLS_WINDOW) {
        TRY(bus_wait(stream->bus, WAIT_STEP_S, BUS_SLEEP, &handled));
        TRY(record_sender_service(stream));
    }
    return STATUS_OK;
}

void record_sender_keep_wall(struct record_sender *stream, bool command, int64_t seq, const void *data, size_t size)
{
    if (stream->bus->is_log || size > WALL_MESSAGE_MAX)
        return;
    struct wall_copy *copy = &stream->wall[seq % WALLS_WINDOW][command];
    copy->size = size;
    copy->sent_s = clock_now_s();
    copy->held = false;
    memcpy(copy->data, data, size);
    if (!command)
        return;
    if (stream->acked_walls >= stream->walls_end)
        wait_note(stream);
    stream->walls_end = seq + 1;
}

/* A record whose run or number is not the stream's would never be acknowledged. */
static enum status record_check(const struct record_sender *stream, enum record_channel channel, const void *data,
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

static enum status record_append(struct record_sender *stream, enum record_channel channel, const void *data,
                                 size_t size)
{
    struct record *record = malloc(sizeof *record + size);
    if (!record)
        return status_fail(STATUS_NO_MEMORY, "no memory for a record of %zu bytes", size);
    *record = (struct record){.channel = channel, .seq = stream->total[channel], .size = size};
    memcpy(record->data, data, size);
    if (stream->waiting == 0)
        wait_note(stream);
    *stream->end = record;
    stream->end = &record->next;
    if (!stream->unsent)
        stream->unsent = record;
    stream->waiting++;
    stream->waiting_bytes += size;
    return STATUS_OK;
}

/* Services the stream until at most `bytes` wait. */
static enum status waiting_reduce(struct record_sender *stream, size_t bytes)
{
    bool handled = false;
    TRY(record_sender_service(stream));
    while (stream->waiting_bytes > bytes) {
        TRY(bus_wait(stream->bus, WAIT_STEP_S, BUS_SLEEP, &handled));
        TRY(record_sender_service(stream));
    }
    return STATUS_OK;
}

static void count(struct record_sender *stream, enum record_channel channel, const void *data, size_t size)
{
    stream->total[channel]++;
    if (!stream->repeats_start || channel > RECORD_PARTICLES)
        stream->hash[channel] = record_hash_add(stream->hash[channel], data, size);
}

enum status record_sender_publish(struct record_sender *stream, enum record_channel channel, const void *data,
                                  size_t size)
{
    TRY(record_check(stream, channel, data, size));
    if (stream->bus->is_log) {
        TRY(bus_publish(stream->bus, record_channel_name[channel], data, size));
        count(stream, channel, data, size);
        return STATUS_OK;
    }
    TRY(record_append(stream, channel, data, size));
    count(stream, channel, data, size);
    return waiting_reduce(stream, WAITING_BYTES_MAX);
}

enum status record_sender_flush(struct record_sender *stream)
{
    if (stream->bus->is_log)
        return bus_flush(stream->bus);
    return waiting_reduce(stream, 0);
}
