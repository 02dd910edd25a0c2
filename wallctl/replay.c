#include "wallctl/replay.h"

#include <inttypes.h>
#include <string.h>

#include "common/coupling.h"
#include "common/message.h"
#include "shakedown_end_t.h"
#include "wallctl/control_law.h"

struct replay {
    const struct scene *scene;
    bool run_known;
    int64_t run_id;
    struct replay_counts *counts;
    bool have_expected;
    struct wall_command expected; /* the law's answer to the last state */
    bool ended;
    enum status failure;
};

static bool belongs(struct replay *r, const struct message_header *header)
{
    if (!r->run_known) {
        r->run_known = true;
        r->run_id = header->run_id;
    }
    if (header->run_id == r->run_id)
        return true;
    r->counts->foreign++;
    return false;
}

static void on_state(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct replay *r = user;
    struct message_header header;
    struct wall_state state;
    (void)channel;
    if (!wall_state_decode(buffer->data, buffer->data_size, &header, &state)) {
        r->counts->malformed++;
        return;
    }
    if (!belongs(r, &header) || r->failure != STATUS_OK)
        return;
    r->counts->states++;
    r->failure = wallctl_law(r->scene, &state, &r->expected);
    r->have_expected = r->failure == STATUS_OK;
}

static enum status integer_compare(int64_t step, const char *field, int64_t recorded, int64_t now)
{
    if (recorded == now)
        return STATUS_OK;
    return status_fail(STATUS_FORMAT, "step %" PRId64 ": %s was %" PRId64 " in the log, the law says %" PRId64, step,
                       field, recorded, now);
}

/* Bits are compared, not values: -0 is not 0 here. */
static enum status doubles_compare(int64_t step, const char *field, const double *recorded, const double *now,
                                   int count)
{
    for (int k = 0; k < count; k++)
        if (memcmp(&recorded[k], &now[k], sizeof *now) != 0)
            return status_fail(STATUS_FORMAT, "step %" PRId64 ": %s[%d] was %.17g in the log, the law says %.17g", step,
                               field, k, recorded[k], now[k]);
    return STATUS_OK;
}

static enum status command_compare(const struct wall_command *recorded, const struct wall_command *now)
{
    int64_t step = now->step;
    int n = now->n_walls;
    TRY(integer_compare(step, "stage", recorded->stage, now->stage));
    TRY(integer_compare(step, "finished", recorded->finished, now->finished));
    TRY(integer_compare(step, "ended", recorded->ended, now->ended));
    TRY(integer_compare(step, "measure", recorded->measure, now->measure));
    TRY(integer_compare(step, "n_steps", recorded->n_steps, now->n_steps));
    TRY(integer_compare(step, "n_walls", recorded->n_walls, n));
    TRY(doubles_compare(step, "fraction_done", &recorded->fraction_done, &now->fraction_done, 1));
    TRY(doubles_compare(step, "position_m", recorded->position_m, now->position_m, n));
    TRY(doubles_compare(step, "velocity_m_per_s", recorded->velocity_m_per_s, now->velocity_m_per_s, n));
    for (int wall = 0; wall < n; wall++)
        TRY(integer_compare(step, "drive", recorded->drive[wall], now->drive[wall]));
    TRY(doubles_compare(step, "force_n", recorded->force_n, now->force_n, n));
    TRY(doubles_compare(step, "force_rate_n_per_s", recorded->force_rate_n_per_s, now->force_rate_n_per_s, n));
    TRY(doubles_compare(step, "force_rate2_n_per_s2", recorded->force_rate2_n_per_s2, now->force_rate2_n_per_s2, n));
    TRY(doubles_compare(step, "mass_kg", recorded->mass_kg, now->mass_kg, n));
    TRY(doubles_compare(step, "damping_kg_per_s", recorded->damping_kg_per_s, now->damping_kg_per_s, n));
    return doubles_compare(step, "acceleration_m_per_s2", recorded->acceleration_m_per_s2, now->acceleration_m_per_s2,
                           n);
}

static void on_command(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct replay *r = user;
    struct message_header header;
    struct wall_command command;
    (void)channel;
    if (!wall_command_decode(buffer->data, buffer->data_size, &header, &command)) {
        r->counts->malformed++;
        return;
    }
    if (!belongs(r, &header) || r->failure != STATUS_OK)
        return;
    if (!r->have_expected || r->expected.step != command.step) {
        r->counts->unpaired++;
        return;
    }
    r->failure = command_compare(&command, &r->expected);
    r->counts->commands += r->failure == STATUS_OK;
}

static void on_end(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct replay *r = user;
    struct message_header header;
    (void)channel;
    if (!message_header_read(buffer->data, buffer->data_size, &header) ||
        header.fingerprint != __shakedown_end_t_get_hash())
        r->counts->malformed++;
    else if (belongs(r, &header))
        r->ended = true;
}

/* Reads on until the log ends or a comparison fails. */
static enum status log_read(struct bus *bus, struct replay *r)
{
    bool handled = true;
    while (handled && r->failure == STATUS_OK)
        TRY(bus_handle(bus, 0, &handled));
    TRY(r->failure);
    if (!r->ended)
        return status_fail(STATUS_INCOMPLETE, "the log has no END: it was cut, or the run was");
    if (r->counts->commands == 0)
        return status_fail(STATUS_INCOMPLETE,
                           "the log has no wall command with its state; record them with record.walls = \"full\"");
    return STATUS_OK;
}

enum status replay_run(struct bus *bus, const struct scene *scene, bool run_id_given, int64_t run_id,
                       struct replay_counts *counts)
{
    struct replay r = {.scene = scene, .run_known = run_id_given, .run_id = run_id, .counts = counts};
    void *states = NULL, *commands = NULL, *ends = NULL;
    memset(counts, 0, sizeof *counts);
    if (!bus->is_log || bus->log)
        return status_fail(STATUS_USAGE, "a replay reads an event log");
    enum status status = bus_subscribe_for_a_while(bus, CHANNEL_WALL_STATE, on_state, &r, &states);
    if (status == STATUS_OK)
        status = bus_subscribe_for_a_while(bus, CHANNEL_WALL_COMMAND, on_command, &r, &commands);
    if (status == STATUS_OK)
        status = bus_subscribe_for_a_while(bus, record_channel_name[RECORD_END], on_end, &r, &ends);
    if (status == STATUS_OK)
        status = log_read(bus, &r);
    bus_unsubscribe(bus, states); /* they point to `r` */
    bus_unsubscribe(bus, commands);
    bus_unsubscribe(bus, ends);
    return status;
}
