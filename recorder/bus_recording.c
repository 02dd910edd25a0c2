#include "recorder/bus_recording.h"

#include <math.h>
#include <stdio.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

#include "common/signals.h"

/* How the sender is told (lcmtypes/CHANNELS.md), and how the end is kept: END comes again until the sender
 * knows that the run is complete, at least five times a second. */
enum { ACK_EVERY_RECORDS = 8, ACK_EVERY_WALLS = 16, WAIT_MS = 10, SETTLE_MS = 1 };
static const double ACK_EVERY_S = 0.05, ACK_SPACING_S = 0.0002, STOP_PATIENCE_S = 10.0;
/* Readers see a new run.h5 that often, or less if copying it takes long. */
static const double PUBLISH_EVERY_S = 2.0, PUBLISH_TIMES = 50.0;
/* Between attempts to write while the disk is full. */
static const double ROOM_EVERY_S = 0.5;
/* Without its starter, nobody else would end a recorder whose simulator is gone. */
static const double ORPHAN_PATIENCE_S = 60.0;
static const double LINGER_S = 0.3, LINGER_STOPPED_S = 0.05, LINGER_MAX_S = 5.0, FAILED_ACKS_S = 0.5;

struct recording_session;

/* One subscription. */
struct recorded_channel {
    struct recording_session *session;
    int kind;
    void *subscription; /* NULL: ended */
};

struct recording_session {
    struct bus bus;
    struct record_receiver *recording;
    double timeout_s;
    pid_t parent;
    struct recorded_channel channels[MESSAGE_LOGGED_KINDS], life;
    enum status status; /* of the last handler that failed */
    bool failed;        /* told to the sender */
    int64_t ack_seq;
    int records_unanswered, walls_unanswered;
    bool answer_now;
    int64_t ends; /* copies of END that came */
    double ack_at_s, publish_at_s, message_at_s, stop_at_s;
};

static void on_message(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct recorded_channel *source = user;
    struct recording_session *session = source->session;
    enum recording_answer answer;
    (void)channel;
    if (session->status != STATUS_OK)
        return;
    int64_t foreign = record_receiver_drops(session->recording)->foreign;
    session->status = record_receiver_take(session->recording, source->kind, buffer->data, buffer->data_size, &answer);
    if (record_receiver_drops(session->recording)->foreign == foreign)
        session->message_at_s = clock_now_s();
    session->records_unanswered += answer == ANSWER_SOON;
    session->walls_unanswered += source->kind >= MESSAGE_WALL_STATE;
    session->answer_now |= answer == ANSWER_NOW;
    session->ends += source->kind == RECORD_END;
}

/* STATUS is not recorded, but a sign that the run goes on, however far its records are apart. */
static void on_life(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct recorded_channel *source = user;
    struct message_header header;
    (void)channel;
    if (message_header_read(buffer->data, buffer->data_size, &header) &&
        header.run_id == record_receiver_run_id(source->session->recording))
        source->session->message_at_s = clock_now_s();
}

static enum status publish_ack(struct recording_session *session, bool waits)
{
    enum { ACK_SIZE_MAX = 256 + 12 * EARLY_MAX };
    unsigned char bytes[ACK_SIZE_MAX];
    struct record_receiver_ack ack;
    record_receiver_ack(session->recording, &ack);
    ack.message.seq = session->ack_seq++;
    ack.message.failed = session->failed;
    ack.message.waits = waits;
    int size = shakedown_record_ack_t_encode(bytes, 0, sizeof bytes, &ack.message);
    if (size < 0)
        return status_fail(STATUS_FORMAT, "cannot encode RECORD_ACK");

    session->answer_now = false;
    session->records_unanswered = session->walls_unanswered = 0;
    session->ack_at_s = clock_now_s();
    return bus_publish(&session->bus, CHANNEL_RECORD_ACK, bytes, (size_t)size);
}

/* The disk is full: the sender is told to wait, until there is room or somebody wants to end it. What comes meanwhile
 * waits in its queue: no more than the sender's window. */
static enum status wait_for_room(struct recording_session *session)
{
    bool told = false;
    while (record_receiver_waits_for_room(session->recording) && !stop_requested()) {
        if (!told)
            fprintf(stderr, "recorder: warning: %s; waiting for room\n", status_message());
        told = true;
        TRY(publish_ack(session, true));
        struct timespec pause = {.tv_nsec = (long)(1e9 * ROOM_EVERY_S)};
        (void)nanosleep(&pause, NULL); /* a signal may end it early */
        if (record_receiver_secure(session->recording) == STATUS_OK) {
            fprintf(stderr, "recorder: there is room again\n");
            return STATUS_OK;
        }
    }
    return status_fail(STATUS_IO, "%s", "cannot write run.lcm: No space left on device");
}

/* What is acknowledged is out of this process' hands. */
static enum status send_ack(struct recording_session *session)
{
    enum status status = session->failed ? STATUS_OK : record_receiver_secure(session->recording);
    if (status != STATUS_OK && record_receiver_waits_for_room(session->recording))
        status = wait_for_room(session);
    TRY(status);
    return publish_ack(session, false);
}

/* Walls come at the full rate of exchange: if they are not wanted they should not cost anything. */
static void unsubscribe_walls(struct recording_session *session)
{
    if (!record_receiver_has_run(session->recording) || record_receiver_wants_walls(session->recording))
        return;
    for (int kind = MESSAGE_WALL_STATE; kind <= MESSAGE_WALL_COMMAND; kind++) {
        bus_unsubscribe(&session->bus, session->channels[kind].subscription);
        session->channels[kind].subscription = NULL;
    }
}

/* Whether the sender is to be told now: at once of what it waits for, but never more often than it can listen, soon of
 * several messages, of fewer when no more come, and now and then that we are here. */
static bool ack_is_due(const struct recording_session *session, bool idle)
{
    const double since_s = clock_now_s() - session->ack_at_s;
    if (session->answer_now || session->records_unanswered >= ACK_EVERY_RECORDS ||
        session->walls_unanswered >= ACK_EVERY_WALLS)
        return idle || since_s >= ACK_SPACING_S;
    return since_s >= ACK_EVERY_S || (idle && (session->records_unanswered > 0 || session->walls_unanswered > 0));
}

static enum status handle(struct recording_session *session)
{
    const bool unanswered = session->answer_now || session->records_unanswered > 0 || session->walls_unanswered > 0;
    bool handled;
    TRY(bus_handle(&session->bus, unanswered ? SETTLE_MS : WAIT_MS, &handled));
    TRY(session->status);
    return ack_is_due(session, !handled) ? send_ack(session) : STATUS_OK;
}

/* Whether to go on waiting for END. */
static bool has_patience(struct recording_session *session)
{
    double now_s = clock_now_s();
    if (stop_requested() && session->stop_at_s == INFINITY) {
        session->stop_at_s = now_s + STOP_PATIENCE_S;
        fprintf(stderr, "recorder: stop requested, waiting for END for at most %g s\n", STOP_PATIENCE_S);
    }
    if (now_s > session->stop_at_s || stop_request_count() > 1)
        return false;
    const double silence_s = now_s - session->message_at_s;
    if (silence_s <= session->timeout_s && (silence_s <= ORPHAN_PATIENCE_S || getppid() == session->parent))
        return true;
    fprintf(stderr, "recorder: no message of this run for %.1f s%s\n", silence_s,
            getppid() == session->parent ? "" : ", and who started it has ended");
    return false;
}

static void publish_now_and_then(struct recording_session *session)
{
    const double start_s = clock_now_s();
    if (!record_receiver_has_run(session->recording) || start_s < session->publish_at_s)
        return;
    record_receiver_publish(session->recording);
    const double took_s = clock_now_s() - start_s;
    session->publish_at_s = clock_now_s() + fmax(PUBLISH_EVERY_S, PUBLISH_TIMES * took_s);
}

static enum status record_until_end(struct recording_session *session)
{
    while (!record_receiver_end_matches(session->recording) && has_patience(session)) {
        TRY(handle(session));
        unsubscribe_walls(session);
        publish_now_and_then(session);
    }
    return STATUS_OK;
}

/* How long no copy of END has to come; the launcher stops a recorder whose sender has ended. */
static double linger_s(void)
{
    return stop_requested() ? LINGER_STOPPED_S : LINGER_S;
}

/* Answers the copies of END until the sender has stopped asking. */
static enum status linger(struct recording_session *session)
{
    double start_s = clock_now_s(), last_end_s = start_s;
    TRY(send_ack(session));
    for (double now_s = start_s; now_s - last_end_s < linger_s() && now_s - start_s < LINGER_MAX_S;
         now_s = clock_now_s()) {
        int64_t ends = session->ends;
        TRY(handle(session));
        if (session->ends != ends)
            last_end_s = clock_now_s();
    }
    return STATUS_OK;
}

/* Tells the sender that it need not go on, more than once because it may be lost. `status` stays the reason. */
static void tell_failure(struct recording_session *session)
{
    double start_s = clock_now_s();
    session->failed = true;
    do {
        bool handled; /* what comes is dropped: session->status says so to the handler */
        if (send_ack(session) != STATUS_OK ||
            bus_handle(&session->bus, (int)(1e3 * ACK_EVERY_S), &handled) != STATUS_OK)
            return;
    } while (clock_now_s() - start_s < FAILED_ACKS_S);
}

static enum status subscribe(struct recording_session *session)
{
    for (int kind = 0; kind < MESSAGE_LOGGED_KINDS; kind++) {
        struct recorded_channel *channel = &session->channels[kind];
        channel->session = session;
        channel->kind = kind;
        TRY(bus_subscribe_for_a_while(&session->bus, message_channel(kind), on_message, channel,
                                      &channel->subscription));
    }
    session->life.session = session;
    return bus_subscribe(&session->bus, CHANNEL_STATUS, on_life, &session->life);
}

static enum status record(struct recording_session *session)
{
    TRY(subscribe(session));
    session->message_at_s = clock_now_s();
    TRY(record_until_end(session));
    TRY(record_receiver_finish(session->recording));
    return linger(session);
}

enum status bus_recording_record(struct record_receiver *recording, const struct bus_recording_options *options)
{
    struct recording_session session = {
        .recording = recording, .timeout_s = options->timeout_s, .stop_at_s = INFINITY, .parent = getppid()};
    TRY(bus_open_direct(&session.bus, options->lcm_url));
    enum status status = record(&session);
    if (session.status != STATUS_OK || status == STATUS_IO || status == STATUS_NO_MEMORY) {
        char reason[1024];
        snprintf(reason, sizeof reason, "%s", status_message());
        session.status = status;
        tell_failure(&session);
        if (record_receiver_finish(recording) != STATUS_OK)
            (void)status_fail(status, "%s", reason); /* the first reason is the one to report */
    }
    bus_close(&session.bus);
    return status;
}
