#include "wallctl/controller.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "common/coupling.h"
#include "common/message.h"
#include "common/signals.h"
#include "shakedown_end_t.h"
#include "wallctl/control_law.h"

/* How often the stop signals are looked at while nothing comes, and how long END is waited for after one. */
static const double WAIT_STEP_S = 0.1;
static const double GRACE_S = 5;

struct controller {
    struct bus *bus;
    const struct scene *scene;
    int64_t run_id;
    struct controller_counts *counts;
    bool ended;
    int last_stage;      /* whose end was said; copies of states come again */
    enum status failure; /* of sending an answer; a handler cannot return it */
};

static void say_end(struct controller *c, const struct wall_state *state, const struct wall_command *command)
{
    if (command->ended == STAGE_END_NONE || state->stage <= c->last_stage)
        return;
    c->last_stage = state->stage;
    printf("stage \"%s\" ended at step %" PRId64 " after %g s by %s\n", c->scene->stage[state->stage].name,
           command->step, state->stage_time_s, stage_end_text(command->ended));
    (void)fflush(stdout); /* a log; nothing depends on it */
}

/* A repeated state gets the same command under the same seq: copies cannot be told apart, and need not be. */
static enum status state_answer(struct controller *c, const struct message_header *header,
                                const struct wall_state *state)
{
    unsigned char buffer[WALL_MESSAGE_MAX];
    struct wall_command command;
    if (wallctl_law(c->scene, state, &command) != STATUS_OK) {
        if (c->counts->rejected++ == 0)
            fprintf(stderr, "wallctl: error: %s; this state gets no answer\n", status_message());
        return STATUS_OK;
    }
    say_end(c, state, &command);
    size_t size = wall_command_encode(&command, c->run_id, header->seq, state->time_s, buffer);
    if (size == 0)
        return status_fail(STATUS_LIMIT, "a wall command does not fit into %d bytes", WALL_MESSAGE_MAX);
    TRY(bus_publish(c->bus, CHANNEL_WALL_COMMAND, buffer, size));
    c->counts->answered++;
    return STATUS_OK;
}

static void on_state(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct controller *c = user;
    struct message_header header;
    struct wall_state state;
    (void)channel;
    bool fits = wall_state_decode(buffer->data, buffer->data_size, &header, &state);
    if (!fits)
        c->counts->malformed++;
    else if (header.run_id != c->run_id)
        c->counts->foreign++;
    else if (c->failure == STATUS_OK)
        c->failure = state_answer(c, &header, &state);
}

static void on_end(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct controller *c = user;
    struct message_header header;
    (void)channel;
    /* The header is enough: the rest is the recorder's. */
    if (!message_header_read(buffer->data, buffer->data_size, &header) ||
        header.fingerprint != __shakedown_end_t_get_hash())
        c->counts->malformed++;
    else if (header.run_id != c->run_id)
        c->counts->foreign++;
    else
        c->ended = true;
}

/* Handles messages until END, a failure, or the end of the grace after a stop signal. */
static enum status loop(struct controller *c)
{
    double stop_at_s = 0; /* 0: not asked to */
    while (!c->ended && c->failure == STATUS_OK) {
        bool handled = false;
        TRY(bus_wait(c->bus, WAIT_STEP_S, c->scene->coupling.busy_poll ? BUS_BUSY : BUS_LOOK, &handled));
        if (!stop_requested())
            continue;
        if (stop_at_s <= 0)
            stop_at_s = clock_now_s() + GRACE_S;
        const bool at_once = stop_request_count() > 1 && !handled; /* END may be among what has come */
        if (!c->ended && (at_once || clock_now_s() > stop_at_s))
            return status_fail(STATUS_INTERRUPTED, "stopped by a signal before END of run %" PRId64, c->run_id);
    }
    return c->failure;
}

enum status controller_run(struct bus *bus, const struct scene *scene, int64_t run_id, struct controller_counts *counts)
{
    struct controller c = {.bus = bus, .scene = scene, .run_id = run_id, .counts = counts, .last_stage = -1};
    void *states = NULL, *ends = NULL;
    memset(counts, 0, sizeof *counts);
    enum status status = bus_subscribe_for_a_while(bus, CHANNEL_WALL_STATE, on_state, &c, &states);
    if (status == STATUS_OK)
        status = bus_subscribe_for_a_while(bus, record_channel_name[RECORD_END], on_end, &c, &ends);
    if (status == STATUS_OK)
        status = loop(&c);
    bus_unsubscribe(bus, states); /* they point to `c` */
    bus_unsubscribe(bus, ends);
    return status;
}
