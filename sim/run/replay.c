#include "sim/run/replay.h"

#include <inttypes.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "common/message.h"

static bool belongs(struct replay *r, const struct message_header *header)
{
    if (!r->run_known) {
        r->run_known = true;
        r->run_id = header->run_id;
    }
    if (header->run_id == r->run_id)
        return true;
    r->counts.foreign++;
    return false;
}

/* The fields of a state, but for its step: single numbers, or one per wall. */
struct state_field {
    const char *name;
    size_t offset;
    enum { FIELD_INT, FIELD_INT64, FIELD_DOUBLE, FIELD_WALLS } type;
};
#define FIELD(name, type)                                                                                              \
    {                                                                                                                  \
#name, offsetof(struct wall_state, name), type                                                                 \
    }
static const struct state_field state_fields[] = {
    FIELD(n_walls, FIELD_INT),
    FIELD(stage, FIELD_INT),
    FIELD(stage_step, FIELD_INT64),
    FIELD(energy_step, FIELD_INT64),
    FIELD(time_s, FIELD_DOUBLE),
    FIELD(stage_time_s, FIELD_DOUBLE),
    FIELD(interval_s, FIELD_DOUBLE),
    FIELD(kinetic_energy_j, FIELD_DOUBLE),
    FIELD(elastic_energy_j, FIELD_DOUBLE),
    FIELD(command_step, FIELD_INT64),
    FIELD(interface_residual_j, FIELD_DOUBLE),
    FIELD(interface_error, FIELD_DOUBLE),
    FIELD(interface_error_before, FIELD_DOUBLE),
    FIELD(position_m, FIELD_WALLS),
    FIELD(velocity_m_per_s, FIELD_WALLS),
    FIELD(acceleration_m_per_s2, FIELD_WALLS),
    FIELD(force_n, FIELD_WALLS),
    FIELD(stiffness_n_per_m, FIELD_WALLS),
    FIELD(damping_kg_per_s, FIELD_WALLS),
    FIELD(stage_position_m, FIELD_WALLS),
    FIELD(force_before_n, FIELD_WALLS),
    FIELD(ahead_position_m, FIELD_WALLS),
    FIELD(ahead_velocity_m_per_s, FIELD_WALLS),
};

static enum status integer_compare(const struct state_field *field, int64_t step, const char *recorded, const char *now)
{
    int64_t was = 0, is = 0;
    if (field->type == FIELD_INT) {
        was = *(const int *)recorded;
        is = *(const int *)now;
    } else {
        was = *(const int64_t *)recorded;
        is = *(const int64_t *)now;
    }
    if (was == is)
        return STATUS_OK;
    return status_fail(STATUS_FORMAT, "step %" PRId64 ": %s was %" PRId64 " in the log, is %" PRId64 " here", step,
                       field->name, was, is);
}

/* Bits are compared, not values: -0 is not 0 here. */
static enum status doubles_compare(const struct state_field *field, int64_t step, const double *recorded,
                                   const double *now, int count)
{
    for (int k = 0; k < count; k++)
        if (memcmp(&recorded[k], &now[k], sizeof *now) != 0)
            return status_fail(STATUS_FORMAT, "step %" PRId64 ": %s[%d] was %.17g in the log, is %.17g here", step,
                               field->name, k, recorded[k], now[k]);
    return STATUS_OK;
}

static enum status state_compare(const struct wall_state *recorded, const struct wall_state *now)
{
    if (recorded->step != now->step)
        return status_fail(STATUS_FORMAT, "step %" PRId64 ": the next wall state in the log is for step %" PRId64,
                           now->step, recorded->step);
    for (size_t k = 0; k < sizeof state_fields / sizeof *state_fields; k++) {
        const struct state_field *field = &state_fields[k];
        const char *was = (const char *)recorded + field->offset, *is = (const char *)now + field->offset;
        if (field->type == FIELD_INT || field->type == FIELD_INT64)
            TRY(integer_compare(field, now->step, was, is));
        else
            TRY(doubles_compare(field, now->step, (const double *)was, (const double *)is,
                                field->type == FIELD_WALLS ? now->n_walls : 1));
    }
    return STATUS_OK;
}

static void on_state(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct replay *r = user;
    struct message_header header;
    struct wall_state state;
    (void)channel;
    if (!wall_state_decode(buffer->data, buffer->data_size, &header, &state)) {
        r->counts.malformed++;
        return;
    }
    if (!belongs(r, &header) || r->failure != STATUS_OK)
        return;
    if (!r->now) {
        r->failure =
            status_fail(STATUS_FORMAT, "the log goes on with step %" PRId64 ", the protocol is done here", state.step);
        return;
    }
    if (state.step < r->now->step || state.command_step < r->now->command_step) /* a late copy */
        return;
    r->failure = state_compare(&state, r->now);
    r->state_seen = r->failure == STATUS_OK;
    r->counts.states += r->state_seen;
}

static void on_command(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct replay *r = user;
    struct message_header header;
    struct wall_command command;
    (void)channel;
    if (!wall_command_decode(buffer->data, buffer->data_size, &header, &command)) {
        r->counts.malformed++;
        return;
    }
    if (!belongs(r, &header) || !r->now || r->command_seen || command.step != r->now->command_step)
        return;
    r->command = command;
    r->command_seen = true;
}

static void on_end(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct replay *r = user;
    struct message_header header;
    union message message;
    (void)channel;
    if (!message_header_read(buffer->data, buffer->data_size, &header) ||
        message_decode(RECORD_END, buffer->data, buffer->data_size, &message) != STATUS_OK) {
        r->counts.malformed++;
        return;
    }
    if (belongs(r, &header)) {
        r->ended = true;
        r->end_step = message.end.step;
        r->end_hash = message.end.state_hash;
    }
    message_free(RECORD_END, &message);
}

enum status replay_open(struct replay *r, const char *path, bool run_id_given, int64_t run_id)
{
    char url[4096];
    *r = (struct replay){.run_known = run_id_given, .run_id = run_id};
    if (snprintf(url, sizeof url, "file://%s", path) >= (int)sizeof url)
        return status_fail(STATUS_USAGE, "the path of the log is too long");
    TRY(bus_open(&r->bus, url));
    enum status status = bus_subscribe(&r->bus, CHANNEL_WALL_STATE, on_state, r);
    if (status == STATUS_OK)
        status = bus_subscribe(&r->bus, CHANNEL_WALL_COMMAND, on_command, r);
    if (status == STATUS_OK)
        status = bus_subscribe(&r->bus, record_channel_name[RECORD_END], on_end, r);
    if (status != STATUS_OK)
        bus_close(&r->bus);
    return status;
}

void replay_close(struct replay *r)
{
    bus_close(&r->bus);
}

enum status replay_exchange(struct replay *r, const struct wall_state *state, struct wall_command *command)
{
    bool handled = true;
    r->now = state;
    r->state_seen = r->command_seen = false;
    while (handled && !r->ended && r->failure == STATUS_OK && !(r->state_seen && r->command_seen))
        TRY(bus_handle(&r->bus, 0, &handled));
    r->now = NULL;
    TRY(r->failure);
    if (!r->state_seen || !r->command_seen)
        return status_fail(STATUS_INCOMPLETE,
                           "step %" PRId64
                           ": the log has no wall %s for it%s; record them with record.walls = \"full\"",
                           state->step, r->state_seen ? "command" : "state", r->ended ? "" : " and no END");
    r->counts.commands++;
    *command = r->command;
    return STATUS_OK;
}

enum status replay_finish(struct replay *r, int64_t step, uint64_t state_hash)
{
    bool handled = true;
    while (handled && r->failure == STATUS_OK)
        TRY(bus_handle(&r->bus, 0, &handled));
    TRY(r->failure);
    if (!r->ended)
        return status_fail(STATUS_INCOMPLETE, "the log has no END: it was cut, or the run was");
    if (r->end_step != step || (uint64_t)r->end_hash != state_hash)
        return status_fail(STATUS_FORMAT,
                           "the state at the end was %016" PRIx64 " at step %" PRId64 ", is %016" PRIx64
                           " at step %" PRId64 " here",
                           (uint64_t)r->end_hash, r->end_step, state_hash, step);
    return STATUS_OK;
}
