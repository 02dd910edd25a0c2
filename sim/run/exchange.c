#include "sim/run/exchange.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "common/message.h"
#include "common/signals.h"
#include "sim/run/command_check.h"
#include "wallctl/control_law.h"

/* Without an answer the state is sent again when it is later than answers were so far, within these; after WAITS_EVEN
 * times in vain the wait doubles each time. */
static const double RESEND_MIN_S = 0.0001, RESEND_FIRST_S = 0.02, RESEND_MAX_S = 0.1, RESEND_BACKOFF_MAX_S = 0.2;
enum { WAITS_EVEN = 3 };
/* A wait costs more than a copy. A state goes out in as many that all of them are lost less often than this, at the
 * loss of so many of the last states: once where one in twenty is lost. */
static const double WAIT_SHARE_MAX = 0.05, LOSS_MEMORY = 64;
enum { COPIES_MAX = 4 };
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

/* Copies are answered alike. Which of them was answered first after a wait shows only when each has been: the first
 * one. */
static void answer_count(struct exchange *exchange, struct exchange_attempt *attempt)
{
    const bool first = attempt->answers++ == 0;
    if (first)
        attempt->trip_s = clock_now_s() - attempt->asked_at_s;
    if (attempt->waits == 0 ? first : attempt->answers == attempt->sends)
        round_trip_note(&exchange->trip, attempt->trip_s);
}

/* Answers to the last but one state are no longer looked at: what it got of them is what came. */
static void attempt_begin(struct exchange *exchange)
{
    const struct exchange_attempt *done = &exchange->before;
    if (done->seq >= 0)
        exchange->loss += (1 - fmin(1, (double)done->answers / done->sends) - exchange->loss) / LOSS_MEMORY;
    exchange->before = exchange->now;
    exchange->now = (struct exchange_attempt){.seq = exchange->seq, .asked_at_s = clock_now_s()};
}

static int copies_needed(const struct exchange *exchange)
{
    int copies = 1;
    for (double all_lost = exchange->loss; all_lost > WAIT_SHARE_MAX && copies < COPIES_MAX; copies++)
        all_lost *= exchange->loss;
    return copies;
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
    const bool is_ours = header.run_id == exchange->run_id;
    if (is_ours && header.seq == exchange->before.seq) {
        answer_count(exchange, &exchange->before);
        return;
    }
    if (!is_ours)
        ignore(exchange, "run_id", header.run_id, exchange->run_id);
    else if (header.seq != exchange->now.seq)
        ignore(exchange, "seq", header.seq, exchange->now.seq);
    else if (header.step != exchange->asked.command_step)
        ignore(exchange, "step", header.step, exchange->asked.command_step);
    if (!is_ours || header.seq != exchange->now.seq || header.step != exchange->asked.command_step)
        return;
    answer_count(exchange, &exchange->now);
    if (exchange->answered)
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
                                  .now.seq = -1,
                                  .before.seq = -1,
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

static enum status state_send(struct exchange *exchange)
{
    for (int copies = copies_needed(exchange); copies > 0; copies--) {
        exchange->repeated += exchange->now.sends > 0;
        exchange->now.sends++;
        TRY(publish_state(exchange, &exchange->asked));
    }
    return STATUS_OK;
}

static enum status state_repeat(struct exchange *exchange)
{
    exchange->now.waits++;
    return state_send(exchange);
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

static double resend_after_s(const struct exchange *exchange)
{
    double wait_s = round_trip_late_s(&exchange->trip, RESEND_MIN_S, RESEND_FIRST_S, RESEND_MAX_S);
    for (int waits = exchange->now.waits; waits >= WAITS_EVEN && wait_s < RESEND_BACKOFF_MAX_S; waits--)
        wait_s *= 2;
    return fmin(wait_s, RESEND_BACKOFF_MAX_S);
}

static enum status wait_for_answer(struct exchange *exchange)
{
    const struct wall_state *state = &exchange->asked;
    const enum bus_patience patience = exchange->scene->coupling.busy_poll ? BUS_BUSY : BUS_LOOK;
    double start = clock_now_s(), sent = start;
    while (!exchange->answered) {
        bool handled;
        const double again = sent + resend_after_s(exchange);
        TRY(bus_wait(exchange->bus, fmax(0, again - clock_now_s()), patience, &handled));
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
        }
    }
    exchange_close(exchange);
    return STATUS_OK;
}

enum status exchange_settle(struct exchange *exchange)
{
    const double start = clock_now_s();
    while (exchange->open && !exchange->answered && clock_now_s() - start < STOP_PATIENCE_S) {
        bool handled;
        TRY(bus_wait(exchange->bus, resend_after_s(exchange), BUS_SLEEP, &handled));
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
    exchange->answered = false;
    exchange->ignored = 0;
    if (exchange->record_walls)
        TRY(record_sender_wait_for_walls(exchange->stream, exchange->seq));
    attempt_begin(exchange);
    exchange->open = !exchange->replay && !exchange->in_process;
    if (exchange->open)
        return state_send(exchange);
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
