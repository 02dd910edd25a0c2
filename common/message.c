#include "common/message.h"

#include <limits.h>
#include <stddef.h>
#include <string.h>

#include "common/history_kind.h"
#include "common/wire.h"
#include "wire_layout.h"

_Static_assert(offsetof(shakedown_sample_t, time_s) == offsetof(union message, header.time_s), "common header");

_Static_assert(HISTORY_NUMBER == 0 && HISTORY_TANGENT == 1 && HISTORY_ROTATION == 2, "as run_info_t.lcm says");

enum { CHUNKS_MAX = 1 << 20, PARTICLES_MAX = 100 * 1000 * 1000 };

static bool dimension_ok(int dimension)
{
    return dimension == 2 || dimension == 3;
}

static bool chunk_ok(int chunk, int n_chunks)
{
    return n_chunks >= 1 && n_chunks <= CHUNKS_MAX && chunk >= 0 && chunk < n_chunks;
}

/* A range of ids [first, first + count) that an int32_t can hold. */
static bool range_ok(int first, int count)
{
    return first >= 0 && count >= 0 && first <= INT_MAX - count;
}

static bool totals_ok(const int64_t *total, int n)
{
    for (int c = 0; c < n; c++) {
        if (total[c] < 0)
            return false;
    }
    return true;
}

/* A name becomes one of a dataset. */
static bool history_name_ok(const char *name)
{
    const size_t length = strspn(name, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_");
    return length > 0 && length < HISTORY_NAME_MAX && name[length] == '\0';
}

static bool history_ok(const shakedown_run_info_t *info)
{
    if (info->n_history > HISTORY_FIELDS_MAX)
        return false;
    for (int k = 0; k < info->n_history; k++) {
        if (!history_name_ok(info->history_name[k]) || strlen(info->history_unit[k]) >= HISTORY_UNIT_MAX ||
            info->history_kind[k] < 0 || info->history_kind[k] >= HISTORY_KINDS)
            return false;
        for (int other = 0; other < k; other++) {
            if (strcmp(info->history_name[k], info->history_name[other]) == 0)
                return false;
        }
    }
    return true;
}

static bool check_run_info(const union message *message)
{
    const shakedown_run_info_t *info = &message->run_info;
    return dimension_ok(info->dimension) && info->n_particles > 0 && info->n_particles <= PARTICLES_MAX &&
           info->n_stages >= 0 && (info->n_resumed == 0 || info->n_resumed == RECORD_CHANNELS) &&
           info->resumed_frames >= 0 && info->resumed_wall_states >= 0 && info->resumed_wall_states < INT64_MAX / 4 &&
           totals_ok(info->resumed_total, info->n_resumed) && history_ok(info);
}

static bool check_particles(const union message *message)
{
    const shakedown_particles_t *set = &message->particles;
    return chunk_ok(set->chunk, set->n_chunks) && range_ok(set->first, set->count);
}

static bool check_sample(const union message *message)
{
    const shakedown_sample_t *sample = &message->sample;
    return dimension_ok(sample->dimension) && sample->n_stress == sample->dimension * sample->dimension &&
           sample->n_walls == 2 * sample->dimension;
}

static bool check_frame_particles(const union message *message)
{
    const shakedown_frame_particles_t *frame = &message->frame_particles;
    if (!dimension_ok(frame->dimension) || !chunk_ok(frame->chunk, frame->n_chunks) || frame->frame < 0)
        return false;
    int spins = frame->dimension == 2 ? 1 : 3;
    return range_ok(frame->first, frame->count) && (int64_t)frame->count * frame->dimension == frame->n_values &&
           (frame->n_angular == 0 || frame->n_angular == (int64_t)frame->count * spins);
}

static bool check_frame_contacts(const union message *message)
{
    const shakedown_frame_contacts_t *frame = &message->frame_contacts;
    if (!dimension_ok(frame->dimension) || !chunk_ok(frame->chunk, frame->n_chunks) || frame->frame < 0)
        return false;
    return (int64_t)frame->count * frame->dimension == frame->n_values &&
           (frame->n_tangential == 0 || frame->n_tangential == frame->n_values) &&
           (frame->n_sliding == 0 || frame->n_sliding == frame->count);
}

static bool check_note(const union message *message)
{
    const shakedown_note_t *note = &message->note;
    return note->stage >= -1 && note->severity >= 0 && note->severity < NOTE_SEVERITIES;
}

static bool check_checkpoint(const union message *message)
{
    const shakedown_checkpoint_t *checkpoint = &message->checkpoint;
    return checkpoint->n_channels == RECORD_CHANNELS && totals_ok(checkpoint->total, checkpoint->n_channels) &&
           checkpoint->n_frames >= 0 && checkpoint->wall_states >= 0;
}

static bool check_end(const union message *message)
{
    const shakedown_end_t *end = &message->end;
    if (end->n_channels != RECORD_CHANNELS)
        return false;
    for (int c = 0; c < RECORD_CHANNELS; c++) {
        if (strcmp(end->channel[c], record_channel_name[c]) != 0 || end->total[c] < 0)
            return false;
    }
    return end->wall_states >= 0 && end->wall_commands >= 0;
}

static bool check_wall_state(const union message *message)
{
    int n_walls = message->wall_state.n_walls;
    return n_walls == 4 || n_walls == 6;
}

static bool check_wall_command(const union message *message)
{
    int n_walls = message->wall_command.n_walls;
    return n_walls == 4 || n_walls == 6;
}

static bool check_record_ack(const union message *message)
{
    const shakedown_record_ack_t *ack = &message->record_ack;
    if (ack->n_channels != RECORD_CHANNELS || !totals_ok(ack->next_seq, ack->n_channels) || ack->next_wall_seq < 0)
        return false;
    for (int k = 0; k < ack->n_held; k++) {
        if (ack->held_channel[k] < 0 || ack->held_channel[k] >= RECORD_CHANNELS || ack->held_seq[k] < 0)
            return false;
    }
    return true;
}

static bool check_status(const union message *message)
{
    return dimension_ok(message->status.dimension);
}

#define MESSAGE_LIST(X)                                                                                                \
    X(RECORD_RUN_INFO, run_info, RUN_INFO_T)                                                                           \
    X(RECORD_PARTICLES, particles, PARTICLES_T)                                                                        \
    X(RECORD_SAMPLE, sample, SAMPLE_T)                                                                                 \
    X(RECORD_FRAME_PARTICLES, frame_particles, FRAME_PARTICLES_T)                                                      \
    X(RECORD_FRAME_CONTACTS, frame_contacts, FRAME_CONTACTS_T)                                                         \
    X(RECORD_NOTE, note, NOTE_T)                                                                                       \
    X(RECORD_CHECKPOINT, checkpoint, CHECKPOINT_T)                                                                     \
    X(RECORD_END, end, END_T)                                                                                          \
    X(MESSAGE_WALL_STATE, wall_state, WALL_STATE_T)                                                                    \
    X(MESSAGE_WALL_COMMAND, wall_command, WALL_COMMAND_T)                                                              \
    X(MESSAGE_RECORD_ACK, record_ack, RECORD_ACK_T)                                                                    \
    X(MESSAGE_STATUS, status, STATUS_T)

#define MESSAGE_FUNCTIONS(kind, stem, layout)                                                                          \
    static int decode_##stem(const void *data, size_t size, union message *message)                                    \
    {                                                                                                                  \
        return shakedown_##stem##_t_decode(data, 0, (int)size, &message->stem);                                        \
    }                                                                                                                  \
    static void free_##stem(union message *message)                                                                    \
    {                                                                                                                  \
        (void)shakedown_##stem##_t_decode_cleanup(&message->stem);                                                     \
    }
MESSAGE_LIST(MESSAGE_FUNCTIONS)
#undef MESSAGE_FUNCTIONS

static const struct {
    const char *layout;
    int (*decode)(const void *data, size_t size, union message *message);
    bool (*check)(const union message *message);
    void (*release)(union message *message);
} types[MESSAGE_KINDS] = {
#define MESSAGE_TYPE(kind, stem, layout) [kind] = {WIRE_LAYOUT_##layout, decode_##stem, check_##stem, free_##stem},
    MESSAGE_LIST(MESSAGE_TYPE)
#undef MESSAGE_TYPE
};

const char *message_channel(int kind)
{
    static const char *const other[] = {CHANNEL_WALL_STATE, CHANNEL_WALL_COMMAND, CHANNEL_RECORD_ACK, CHANNEL_STATUS};
    return kind < RECORD_CHANNELS ? record_channel_name[kind] : other[kind - RECORD_CHANNELS];
}

int message_kind(const char *channel)
{
    for (int kind = 0; kind < MESSAGE_KINDS; kind++) {
        if (strcmp(channel, message_channel(kind)) == 0)
            return kind;
    }
    return -1;
}

enum status message_decode(int kind, const void *data, size_t size, union message *message)
{
    memset(message, 0, sizeof *message);
    if (size > INT_MAX || !wire_check(types[kind].layout, data, size))
        return status_fail(STATUS_FORMAT, "%s: %zu bytes that are no such message", message_channel(kind), size);
    if (types[kind].decode(data, size, message) != (int)size) {
        types[kind].release(message);
        return status_fail(STATUS_FORMAT, "%s: %zu bytes of another type or version", message_channel(kind), size);
    }
    if (!types[kind].check(message)) {
        types[kind].release(message);
        return status_fail(STATUS_FORMAT, "%s: its counts do not agree with each other", message_channel(kind));
    }
    return STATUS_OK;
}

void message_free(int kind, union message *message)
{
    types[kind].release(message);
    memset(message, 0, sizeof *message);
}

bool message_is_good_end(const char *channel, const void *data, size_t size)
{
    union message message;
    if (message_kind(channel) != RECORD_END || message_decode(RECORD_END, data, size, &message) != STATUS_OK)
        return false;
    const bool good = message.end.status == STATUS_OK;
    message_free(RECORD_END, &message);
    return good;
}

enum { INT64_BYTES = 8, HEADER_BYTES = 5 * INT64_BYTES };

static uint64_t big_endian(const unsigned char *bytes, int count)
{
    uint64_t value = 0;
    for (int k = 0; k < count; k++)
        value = value << 8 | bytes[k];
    return value;
}

bool message_header_read(const void *data, size_t size, struct message_header *header)
{
    const unsigned char *bytes = data;
    if (size < HEADER_BYTES)
        return false;
    header->fingerprint = (int64_t)big_endian(bytes, INT64_BYTES);
    header->run_id = (int64_t)big_endian(bytes + INT64_BYTES, INT64_BYTES);
    header->seq = (int64_t)big_endian(bytes + 2 * INT64_BYTES, INT64_BYTES);
    header->step = (int64_t)big_endian(bytes + 3 * INT64_BYTES, INT64_BYTES);
    uint64_t time_bits = big_endian(bytes + 4 * INT64_BYTES, INT64_BYTES);
    memcpy(&header->time_s, &time_bits, sizeof header->time_s);
    return true;
}
