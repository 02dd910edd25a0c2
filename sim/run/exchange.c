#include "sim/run/exchange.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "common/message.h"
#include "common/signals.h"
#include "sim/run/command_check.h"
#include "wallctl/control_law.h"

/* Without an answer the state is sent again when it is later than answers were so far, within these; each time in vain
 * the wait doubles. */
static const double RESEND_MIN_S = 0.002, RESEND_FIRST_S = 0.02, RESEND_MAX_S = 0.1, RESEND_BACKOFF_MAX_S = 0.2;
/* Longest wait for an answer when the run is to end. */
static const double STOP_PATIENCE_S = 0.5;

/* An answer that does not fit is late, a copy, or wrong: that only shows if no other comes (exchange_answer). */
static void ignore(struct exchange *exchange, const char *field, int64_t got, int64_t wanted)
{
    exchange->ignored++;
    if (got == wanted)
        snprintf(exchange->why, sizeof exchange->why, "%s", field);
    else
        snprintf(exchange->why, sizeof exchange->why, "its %s is %" PRId64 ", not %" PRId64, field, got, wanted);
}

static void on_command(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct exchange *exchange = user;
    struct message_header header;
    struct wall_command command;
    (void)channel;
    if (!wall_command_decode(buffer->data, buffer->data_size, &header, &command)) {
        ignore(exchange, "it is no wall_command_t of this version", 0, 0);
        return;
    }
    if (header.run_id != exchange->run_id)
        ignore(exchange, "run_id", header.run_id, exchange->run_id);
    else if (exchange->answered)
        return; /* a copy */
    else if (header.seq != exchange->seq)
        ignore(exchange, "seq", header.seq, exchange->seq);
    else if (header.step != exchange->asked.command_step)
        ignore(exchange, "step", header.step, exchange->asked.command_step);
    if (header.run_id != exchange->run_id || header.seq != exchange->seq || header.step != exchange->asked.command_step)
        return;
    exchange->answer = command;
    exchange->answered = true;
    if (exchange->record_walls)
        record_sender_keep_wall(exchange->stream, true, exchange->seq, buffer->data, buffer->data_size);
}

enum status exchange_init(struct exchange *exchange, const struct scene *scene, struct bus *bus,
                          struct record_sender *stream, int64_t run_id, bool in_process, struct replay *replay)
{
    *exchange = (struct exchange){.scene = scene,
                                  .bus = bus,
                                  .stream = stream,
                                  .run_id = run_id,
                                  .in_process = in_process,
                                  .replay = replay,
                                  .record_walls = stream && scene->record.walls == RECORD_WALLS_FULL};
    return in_process || replay ? STATUS_OK : bus_subscribe(bus, CHANNEL_WALL_COMMAND, on_command, exchange);
}

static enum status publish(struct exchange *exchange, bool is_command, const void *data, size_t size)
{
    const char *channel = is_command ? CHANNEL_WALL_COMMAND : CHANNEL_WALL_STATE;
    if (size == 0)
        return status_fail(STATUS_LIMIT, "%s is larger than %d bytes", channel, WALL_MESSAGE_MAX);
    if (exchange->record_walls)
        record_sender_keep_wall(exchange->stream, is_command, exchange->seq, data, size);
    return bus_publish(exchange->bus, channel, data, size);
}

static enum status publish_state(struct exchange *exchange, const struct wall_state *state)
{
    unsigned char buffer[WALL_MESSAGE_MAX];
    size_t size = wall_state_encode(state, exchange->run_id, exchange->seq, buffer);
    return publish(exchange, false, buffer, size);
}

static enum status publish_command(struct exchange *exchange, const struct wall_command *command, double time_s)
{
    unsigned char buffer[WALL_MESSAGE_MAX];
    size_t size = wall_command_encode(command, exchange->run_id, exchange->seq, time_s, buffer);
    return publish(exchange, true, buffer, size);
}

static enum status call_law(struct exchange *exchange, const struct wall_state *state, struct wall_command *command)
{
    TRY(wallctl_law(exchange->scene, state, command));
    if (exchange->record_walls) {
        TRY(publish_state(exchange, state));
        TRY(publish_command(exchange, command, state->time_s));
    }
    exchange->seq++;
    return STATUS_OK;
}

static enum status state_repeat(struct exchange *exchange)
{
    exchange->repeated++;
    return publish_state(exchange, &exchange->asked);
}

static void exchange_close(struct exchange *exchange)
{
    exchange->open = false;
    exchange->seq++;
}

static enum status no_answer(const struct exchange *exchange)
{
    const long long step = exchange->asked.step;
    const double timeout_s = exchange->scene->coupling.timeout_s;
    if (exchange->ignored == 0)
        return status_fail(STATUS_TIMEOUT, "step %lld: wallctl did not answer within %g s", step, timeout_s);
    return status_fail(
        STATUS_TIMEOUT,
        "step %lld: no answer of the controller within %g s fits; %lld were ignored, the last because %s", step,
        timeout_s, (long long)exchange->ignored, exchange->why);
}

static double resend_after_s(const struct exchange *exchange, int repeats)
{
    double wait_s =
        exchange->trip.mean_s > 0 ? round_trip_late_s(&exchange->trip, RESEND_MIN_S, RESEND_MAX_S) : RESEND_FIRST_S;
    for (; repeats > 0 && wait_s < RESEND_BACKOFF_MAX_S; repeats--)
        wait_s *= 2;
    return fmin(wait_s, RESEND_BACKOFF_MAX_S);
}

static int wait_ms(double until_s)
{
    return (int)fmax(1, ceil(1e3 * (until_s - clock_now_s())));
}

static enum status wait_for_answer(struct exchange *exchange)
{
    const struct wall_state *state = &exchange->asked;
    double start = clock_now_s(), sent = start;
    int repeats = 0;
    while (!exchange->answered) {
        bool handled;
        const double again = sent + resend_after_s(exchange, repeats);
        TRY(bus_wait(exchange->bus, wait_ms(again), exchange->scene->coupling.busy_poll, &handled));
        if (exchange->answered)
            break;
        if (stop_requested() && clock_now_s() - start > STOP_PATIENCE_S)
            return status_fail(STATUS_INTERRUPTED, "interrupted at step %lld", (long long)state->step);
        TRY(record_sender_service(exchange->stream));
        double now = clock_now_s();
        if (now - start > exchange->scene->coupling.timeout_s)
            return no_answer(exchange);
        if (now >= again) {
            TRY(state_repeat(exchange));
            sent = now;
            repeats++;
        }
    }
    if (repeats == 0)
        round_trip_note(&exchange->trip, clock_now_s() - exchange->asked_at_s);
    exchange_close(exchange);
    return STATUS_OK;
}

enum status exchange_settle(struct exchange *exchange)
{
    const double start = clock_now_s();
    for (int repeats = 0; exchange->open && !exchange->answered && clock_now_s() - start < STOP_PATIENCE_S; repeats++) {
        bool handled;
        TRY(bus_handle(exchange->bus, wait_ms(clock_now_s() + resend_after_s(exchange, repeats)), &handled));
        if (!handled)
            TRY(state_repeat(exchange));
    }
    if (exchange->open && exchange->answered)
        exchange_close(exchange);
    return STATUS_OK;
}

int64_t exchange_states(const struct exchange *exchange)
{
    return exchange->seq + exchange->open;
}

enum status exchange_ask(struct exchange *exchange, const struct wall_state *state)
{
    exchange->asked = *state;
    exchange->asked_at_s = clock_now_s();
    exchange->answered = false;
    exchange->ignored = 0;
    if (exchange->record_walls)
        TRY(record_sender_wait_for_walls(exchange->stream, exchange->seq));
    exchange->open = !exchange->replay && !exchange->in_process;
    if (exchange->open)
        return publish_state(exchange, state);
    TRY(exchange->replay ? replay_exchange(exchange->replay, state, &exchange->answer)
                         : call_law(exchange, state, &exchange->answer));
    exchange->answered = true;
    return STATUS_OK;
}

enum status exchange_answer(struct exchange *exchange, struct wall_command *command)
{
    if (!exchange->replay && !exchange->in_process)
        TRY(wait_for_answer(exchange));
    *command = exchange->answer;
    return command_check(exchange->scene, &exchange->asked, command);
}
