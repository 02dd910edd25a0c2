#include "common/coupling.h"

#include <string.h>

#include "shakedown_wall_command_t.h"
#include "shakedown_wall_state_t.h"

static bool wall_count_fits(int n_walls)
{
    return n_walls == 4 || n_walls == 6;
}

const char *stage_end_text(int end)
{
    static const char *const texts[] = {
#define STAGE_END_TEXT(name, text) text,
        STAGE_END_LIST(STAGE_END_TEXT)
#undef STAGE_END_TEXT
    };
    return end >= 0 && (size_t)end < sizeof texts / sizeof texts[0] ? texts[end] : "unknown";
}

int coupling_ahead_steps(const struct scene_coupling *coupling, int n_steps)
{
    const int half = n_steps / 2;
    if (coupling->scheme == SCHEME_PIPELINED)
        return n_steps;
    if (coupling->scheme != SCHEME_COMPENSATED)
        return 0;
    return coupling->ahead_steps < half ? (int)coupling->ahead_steps : half;
}

void wall_state_to_message(const struct wall_state *state, int64_t run_id, int64_t seq,
                           struct _shakedown_wall_state_t *message)
{
    /* The generated type has no const; encoding does not write. */
    struct wall_state *s = (struct wall_state *)state;
    *message = (shakedown_wall_state_t){.run_id = run_id,
                                        .seq = seq,
                                        .step = s->step,
                                        .time_s = s->time_s,
                                        .stage = s->stage,
                                        .stage_step = s->stage_step,
                                        .stage_time_s = s->stage_time_s,
                                        .interval_s = s->interval_s,
                                        .command_step = s->command_step,
                                        .kinetic_energy_j = s->kinetic_energy_j,
                                        .elastic_energy_j = s->elastic_energy_j,
                                        .energy_step = s->energy_step,
                                        .interface_residual_j = s->interface_residual_j,
                                        .interface_error = s->interface_error,
                                        .interface_error_before = s->interface_error_before,
                                        .n_walls = s->n_walls,
                                        .position_m = s->position_m,
                                        .velocity_m_per_s = s->velocity_m_per_s,
                                        .acceleration_m_per_s2 = s->acceleration_m_per_s2,
                                        .force_n = s->force_n,
                                        .stiffness_n_per_m = s->stiffness_n_per_m,
                                        .damping_kg_per_s = s->damping_kg_per_s,
                                        .stage_position_m = s->stage_position_m,
                                        .force_before_n = s->force_before_n,
                                        .ahead_position_m = s->ahead_position_m,
                                        .ahead_velocity_m_per_s = s->ahead_velocity_m_per_s};
}

bool wall_state_from_message(const struct _shakedown_wall_state_t *message, struct wall_state *state)
{
    if (!wall_count_fits(message->n_walls))
        return false;
    *state = (struct wall_state){.step = message->step,
                                 .time_s = message->time_s,
                                 .stage = message->stage,
                                 .stage_step = message->stage_step,
                                 .stage_time_s = message->stage_time_s,
                                 .interval_s = message->interval_s,
                                 .command_step = message->command_step,
                                 .kinetic_energy_j = message->kinetic_energy_j,
                                 .elastic_energy_j = message->elastic_energy_j,
                                 .energy_step = message->energy_step,
                                 .interface_residual_j = message->interface_residual_j,
                                 .interface_error = message->interface_error,
                                 .interface_error_before = message->interface_error_before,
                                 .n_walls = message->n_walls};
    size_t bytes = (size_t)message->n_walls * sizeof(double);
    memcpy(state->position_m, message->position_m, bytes);
    memcpy(state->velocity_m_per_s, message->velocity_m_per_s, bytes);
    memcpy(state->acceleration_m_per_s2, message->acceleration_m_per_s2, bytes);
    memcpy(state->force_n, message->force_n, bytes);
    memcpy(state->stiffness_n_per_m, message->stiffness_n_per_m, bytes);
    memcpy(state->damping_kg_per_s, message->damping_kg_per_s, bytes);
    memcpy(state->stage_position_m, message->stage_position_m, bytes);
    memcpy(state->force_before_n, message->force_before_n, bytes);
    memcpy(state->ahead_position_m, message->ahead_position_m, bytes);
    memcpy(state->ahead_velocity_m_per_s, message->ahead_velocity_m_per_s, bytes);
    return true;
}

void wall_command_to_message(const struct wall_command *command, int64_t run_id, int64_t seq, double time_s,
                             struct _shakedown_wall_command_t *message)
{
    struct wall_command *c = (struct wall_command *)command; /* as above */
    *message = (shakedown_wall_command_t){.run_id = run_id,
                                          .seq = seq,
                                          .step = c->step,
                                          .time_s = time_s,
                                          .stage = c->stage,
                                          .finished = c->finished,
                                          .ended = c->ended,
                                          .measure = c->measure,
                                          .n_steps = c->n_steps,
                                          .fraction_done = c->fraction_done,
                                          .n_walls = c->n_walls,
                                          .drive = c->drive,
                                          .position_m = c->position_m,
                                          .velocity_m_per_s = c->velocity_m_per_s,
                                          .acceleration_m_per_s2 = c->acceleration_m_per_s2,
                                          .force_n = c->force_n,
                                          .force_rate_n_per_s = c->force_rate_n_per_s,
                                          .force_rate2_n_per_s2 = c->force_rate2_n_per_s2,
                                          .mass_kg = c->mass_kg,
                                          .damping_kg_per_s = c->damping_kg_per_s};
}

bool wall_command_from_message(const struct _shakedown_wall_command_t *message, struct wall_command *command)
{
    if (!wall_count_fits(message->n_walls))
        return false;
    *command = (struct wall_command){.step = message->step,
                                     .stage = message->stage,
                                     .finished = message->finished != 0,
                                     .ended = message->ended,
                                     .measure = message->measure != 0,
                                     .n_steps = message->n_steps,
                                     .fraction_done = message->fraction_done,
                                     .n_walls = message->n_walls};
    size_t bytes = (size_t)message->n_walls * sizeof(double);
    memcpy(command->position_m, message->position_m, bytes);
    memcpy(command->velocity_m_per_s, message->velocity_m_per_s, bytes);
    memcpy(command->acceleration_m_per_s2, message->acceleration_m_per_s2, bytes);
    memcpy(command->drive, message->drive, (size_t)message->n_walls * sizeof *command->drive);
    memcpy(command->force_n, message->force_n, bytes);
    memcpy(command->force_rate_n_per_s, message->force_rate_n_per_s, bytes);
    memcpy(command->force_rate2_n_per_s2, message->force_rate2_n_per_s2, bytes);
    memcpy(command->mass_kg, message->mass_kg, bytes);
    memcpy(command->damping_kg_per_s, message->damping_kg_per_s, bytes);
    return true;
}

/* Decodes; false, with the header if it can be read (else zero), if the bytes are no such message. */
static bool wall_message_decode(int kind, const void *data, size_t size, struct message_header *header,
                                union message *message)
{
    memset(header, 0, sizeof *header);
    return message_header_read(data, size, header) && message_decode(kind, data, size, message) == STATUS_OK;
}

bool wall_state_decode(const void *data, size_t size, struct message_header *header, struct wall_state *state)
{
    union message message;
    if (!wall_message_decode(MESSAGE_WALL_STATE, data, size, header, &message))
        return false;
    bool fits = wall_state_from_message(&message.wall_state, state);
    message_free(MESSAGE_WALL_STATE, &message);
    return fits;
}

bool wall_command_decode(const void *data, size_t size, struct message_header *header, struct wall_command *command)
{
    union message message;
    if (!wall_message_decode(MESSAGE_WALL_COMMAND, data, size, header, &message))
        return false;
    bool fits = wall_command_from_message(&message.wall_command, command);
    message_free(MESSAGE_WALL_COMMAND, &message);
    return fits;
}

size_t wall_state_encode(const struct wall_state *state, int64_t run_id, int64_t seq, unsigned char *buffer)
{
    shakedown_wall_state_t message;
    wall_state_to_message(state, run_id, seq, &message);
    int size = shakedown_wall_state_t_encode(buffer, 0, WALL_MESSAGE_MAX, &message);
    return size < 0 ? 0 : (size_t)size;
}

size_t wall_command_encode(const struct wall_command *command, int64_t run_id, int64_t seq, double time_s,
                           unsigned char *buffer)
{
    shakedown_wall_command_t message;
    wall_command_to_message(command, run_id, seq, time_s, &message);
    int size = shakedown_wall_command_t_encode(buffer, 0, WALL_MESSAGE_MAX, &message);
    return size < 0 ? 0 : (size_t)size;
}
