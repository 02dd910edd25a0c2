/* The messages of lcmtypes/: one decoder for all who take them from a bus or a log, which survives any bytes. The
 * generated decoders trust the counts in a message: a hostile one overflows their arithmetic and reads past the end. */
#ifndef SHAKEDOWN_COMMON_MESSAGE_H
#define SHAKEDOWN_COMMON_MESSAGE_H

#include <shakedown_checkpoint_t.h>
#include <shakedown_end_t.h>
#include <shakedown_frame_contacts_t.h>
#include <shakedown_frame_particles_t.h>
#include <shakedown_note_t.h>
#include <shakedown_particles_t.h>
#include <shakedown_record_ack_t.h>
#include <shakedown_run_info_t.h>
#include <shakedown_sample_t.h>
#include <shakedown_status_t.h>
#include <shakedown_wall_command_t.h>
#include <shakedown_wall_state_t.h>

#include "common/bus.h"

/* Kinds 0 ... RECORD_CHANNELS-1 are enum record_channel; the coupling's two follow, then what is not recorded. */
enum {
    MESSAGE_WALL_STATE = RECORD_CHANNELS,
    MESSAGE_WALL_COMMAND,
    MESSAGE_RECORD_ACK,
    MESSAGE_STATUS,
    MESSAGE_KINDS,
    MESSAGE_LOGGED_KINDS = MESSAGE_RECORD_ACK /* kinds below may stand in a log */
};

/* Of note_t. */
enum note_severity { NOTE_PLAIN, NOTE_DOUBTFUL, NOTE_FAILED, NOTE_SEVERITIES };

/* Every type starts with the header. */
union message {
    struct {
        int64_t run_id, seq, step;
        double time_s;
    } header;
    shakedown_run_info_t run_info;
    shakedown_particles_t particles;
    shakedown_sample_t sample;
    shakedown_frame_particles_t frame_particles;
    shakedown_frame_contacts_t frame_contacts;
    shakedown_note_t note;
    shakedown_checkpoint_t checkpoint;
    shakedown_end_t end;
    shakedown_wall_state_t wall_state;
    shakedown_wall_command_t wall_command;
    shakedown_record_ack_t record_ack;
    shakedown_status_t status;
};

/* Name of the channel of a kind, and the kind of a channel (-1: none of ours). */
const char *message_channel(int kind);
int message_kind(const char *channel);

/* Decodes `data` [size] as a message of `kind` and checks that its counts agree with each other. On success the caller
 * releases `message` with message_free; STATUS_FORMAT if the bytes are not such a message (nothing to release). */
enum status message_decode(int kind, const void *data, size_t size, union message *message) MUST_USE;
void message_free(int kind, union message *message);

/* Whether it is the END of a run that went well. */
bool message_is_good_end(const char *channel, const void *data, size_t size);

/* The first fields of every message, with the type's fingerprint before them. */
struct message_header {
    int64_t fingerprint;
    int64_t run_id;
    int64_t seq;
    int64_t step;
    double time_s;
};

/* Reads the header of an encoded message; false if it is too short. */
bool message_header_read(const void *data, size_t size, struct message_header *header);

#endif
