#include "recorder/record_receiver.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/coupling.h"
#include "common/event_log.h"
#include "common/message.h"
#include "common/record_hash.h"
#include "common/scene_file.h"
#include "recorder/backlog.h"
#include "recorder/early_records.h"
#include "recorder/wall_order.h"

enum { WARNINGS_MAX = 5 };

struct record_receiver {
    struct run_store *store;
    bool any_run, from_log, resume;
    bool replaying; /* taking again what is in the log of a run that goes on */
    int64_t run_id;

    bool has_run;
    struct run_facts facts;
    bool wants_walls;
    int64_t next_seq[RECORD_CHANNELS];
    int64_t hash[RECORD_CHANNELS];
    int64_t last_step;
    double last_time_s;
    struct particle_set particles;
    struct particle_frame particle_frame;
    struct contact_frame contact_frame;
    struct wall_order walls;
    int64_t wall_total[2]; /* states, commands */
    struct early_records early;
    struct backlog backlog; /* wall messages before RUN_INFO says whether they are wanted */
    shakedown_end_t *end;   /* the last END, whether it matched or not */
    bool end_matches, finished, complete;
    bool sync_wanted; /* a CHECKPOINT or END was taken that is not on disk yet */
    struct record_receiver_drops drops;
    int warnings;
    int64_t refused_hash; /* of the last message of this run that could not be used; 0: none */
};

enum status record_receiver_create(struct record_receiver **result, const struct record_receiver_options *options)
{
    struct record_receiver *recording = *result = calloc(1, sizeof *recording);
    if (!recording)
        return status_fail(STATUS_NO_MEMORY, "no memory for the recording");
    for (int c = 0; c < RECORD_CHANNELS; c++)
        recording->hash[c] = RECORD_HASH_OF_NONE;
    recording->any_run = options->any_run;
    recording->run_id = options->run_id;
    recording->from_log = options->from_log;
    recording->resume = options->resume;
    const struct run_store_options store = {.directory = options->directory,
                                            .log = !options->from_log,
                                            .replace = options->resume || options->replace,
                                            .remake = options->remake};
    return run_store_create(&recording->store, &store);
}

/* Counts a message that cannot be used, and says so the first few times: it is a sign of a mistake. */
static void drop_malformed(struct record_receiver *recording)
{
    recording->drops.malformed++;
    if (recording->warnings++ < WARNINGS_MAX)
        fprintf(stderr, "recorder: warning: dropped a message: %s\n", status_message());
}

/* The next record of the run, and it cannot be used, as status_message() says. It may have been changed on its way, or
 * be a foreign one; but if it comes again, byte for byte, it is what the run says, and nothing better will ever come.
 */
static enum status refuse(struct record_receiver *recording, int kind, const void *data, size_t size)
{
    const int64_t hash = record_hash_add(RECORD_HASH_OF_NONE, data, size);
    if (!recording->from_log && hash == recording->refused_hash)
        return status_fail(STATUS_FORMAT, "a record on %s cannot be recorded, and comes again: %s",
                           message_channel(kind), status_message());
    recording->refused_hash = hash;
    drop_malformed(recording);
    return STATUS_OK;
}

static enum status log_message(struct record_receiver *recording, int kind, const void *data, size_t size)
{
    return recording->replaying ? STATUS_OK : run_store_log(recording->store, kind, data, size);
}

static enum status wall_write(struct record_receiver *recording, int kind, const union message *message,
                              const void *data, size_t size)
{
    TRY(kind == MESSAGE_WALL_STATE ? run_store_wall_state(recording->store, &message->wall_state)
                                   : run_store_wall_command(recording->store, &message->wall_command));
    recording->wall_total[kind - MESSAGE_WALL_STATE]++;
    return log_message(recording, kind, data, size);
}

/* Those that waited for what has come. */
static enum status walls_write_next(struct record_receiver *recording)
{
    struct wall_waiting next;
    while (wall_order_next(&recording->walls, &next)) {
        const int kind = next.command ? MESSAGE_WALL_COMMAND : MESSAGE_WALL_STATE;
        union message message;
        TRY(message_decode(kind, next.data, next.size, &message));
        enum status status = wall_write(recording, kind, &message, next.data, next.size);
        message_free(kind, &message);
        TRY(status);
    }
    return STATUS_OK;
}

/* A wall message of this run. What is missing before it will be sent again; in a log it never comes. */
static enum status take_wall(struct record_receiver *recording, int kind, const union message *message,
                             const void *data, size_t size, enum recording_answer *answer)
{
    const int n_walls = kind == MESSAGE_WALL_STATE ? message->wall_state.n_walls : message->wall_command.n_walls;
    if (!recording->wants_walls)
        return STATUS_OK;
    if (n_walls != recording->facts.n_walls) {
        (void)status_fail(STATUS_FORMAT, "%s: %d walls in a run of %d", message_channel(kind), n_walls,
                          recording->facts.n_walls);
        drop_malformed(recording);
        return STATUS_OK;
    }
    switch (wall_order_take(&recording->walls, kind == MESSAGE_WALL_COMMAND, message->header.seq, data, size)) {
    case WALL_WAITS:
        *answer = ANSWER_NOW;
        return STATUS_OK;
    case WALL_NEXT:
        TRY(wall_write(recording, kind, message, data, size));
        return walls_write_next(recording);
    case WALL_REPEATED:
        recording->drops.repeated++;
        *answer = ANSWER_NOW;
        return STATUS_OK;
    case WALL_TOO_EARLY:
        if (recording->from_log && wall_order_skip(&recording->walls, message->header.seq)) {
            TRY(walls_write_next(recording));
            return take_wall(recording, kind, message, data, size, answer);
        }
        recording->drops.early++;
        *answer = ANSWER_NOW;
        return STATUS_OK;
    default:
        return STATUS_OK;
    }
}

/* What came before RUN_INFO. */
static enum status backlog_take(struct record_receiver *recording)
{
    struct backlog_item item;
    for (size_t at = 0; backlog_next(&recording->backlog, &at, &item);) {
        enum recording_answer answer;
        TRY(record_receiver_take(recording, item.kind, item.data, item.size, &answer));
    }
    backlog_free(&recording->backlog);
    return STATUS_OK;
}

/* Reads from the effective configuration what it says to the recorder. STATUS_FORMAT if it cannot be read. */
static enum status record_settings_read(const shakedown_run_info_t *info, struct scene_record *record)
{
    struct scene *scene = calloc(1, sizeof *scene);
    if (!scene)
        return status_fail(STATUS_NO_MEMORY, "no memory for the scene");
    enum status status = scene_parse(scene, info->effective_config, "RUN_INFO");
    *record = scene->record;
    if (status == STATUS_OK && scene->dimension != info->dimension)
        status = status_fail(STATUS_FORMAT, "RUN_INFO: its configuration has another dimension");
    scene_free(scene);
    free(scene);
    return status == STATUS_CONFIG ? STATUS_FORMAT : status;
}

static enum status begin(struct record_receiver *recording, const shakedown_run_info_t *info)
{
    struct scene_record record = {0};
    TRY(record_settings_read(info, &record));
    TRY(run_store_begin(recording->store, info, record.walls == RECORD_WALLS_FULL, record.event_log));
    recording->run_id = info->run_id;
    recording->facts = run_facts_of(info);
    recording->wants_walls = record.walls == RECORD_WALLS_FULL;
    TRY(particle_set_init(&recording->particles, &recording->facts));
    TRY(particle_frame_init(&recording->particle_frame, &recording->facts));
    recording->has_run = true;
    return STATUS_OK;
}

/* The CHECKPOINT that a run goes on from. */
static bool is_checkpoint(const struct event *event, const shakedown_run_info_t *info)
{
    struct message_header header;
    return strcmp(event->channel, record_channel_name[RECORD_CHECKPOINT]) == 0 &&
           message_header_read(event->data, event->size, &header) && header.run_id == info->run_id &&
           header.step == info->step && header.seq == info->resumed_total[RECORD_CHECKPOINT] - 1;
}

/* Finds where in the log the record stands that the checkpoint knows of. */
static enum status find_checkpoint(struct event_reader *reader, const shakedown_run_info_t *info, int64_t *place)
{
    struct event event;
    bool found;
    *place = -1;
    TRY(event_reader_next(reader, &event, &found));
    while (found) {
        if (message_is_good_end(event.channel, event.data, event.size) && reader->skipped_bytes == 0)
            return status_fail(STATUS_IO, "its run is complete already");
        if (*place < 0 && is_checkpoint(&event, info))
            *place = event_reader_place(reader);
        TRY(event_reader_next(reader, &event, &found));
    }
    return *place >= 0 ? STATUS_OK : status_fail(STATUS_IO, "the log does not reach to the checkpoint");
}

static enum status take_again(struct record_receiver *recording, struct event_reader *reader, int64_t place)
{
    struct event event;
    bool found = true;
    while (event_reader_place(reader) < place) {
        enum recording_answer answer;
        TRY(event_reader_next(reader, &event, &found));
        if (!found)
            break;
        int kind = message_kind(event.channel);
        if (kind >= 0 && kind < MESSAGE_LOGGED_KINDS)
            TRY(record_receiver_take(recording, kind, event.data, event.size, &answer));
    }
    return STATUS_OK;
}

static enum status resumed_totals_check(const struct record_receiver *recording, const shakedown_run_info_t *info)
{
    for (int c = 0; c < RECORD_CHANNELS; c++) {
        if (recording->next_seq[c] != info->resumed_total[c])
            return status_fail(STATUS_IO, "%s: %s %" PRId64 " of %" PRId64 " that the checkpoint knows of",
                               run_store_log_path(recording->store), record_channel_name[c], recording->next_seq[c],
                               info->resumed_total[c]);
    }
    if (recording->wants_walls && wall_order_exchanges(&recording->walls) < info->resumed_wall_states)
        return status_fail(STATUS_IO, "%s: exchanges of the walls before the checkpoint are missing",
                           run_store_log_path(recording->store));
    return STATUS_OK;
}

static enum status resume_from(struct record_receiver *recording, const shakedown_run_info_t *info,
                               struct event_reader *reader)
{
    int64_t place;
    TRY(find_checkpoint(reader, info, &place));
    if (fseeko(reader->file, 0, SEEK_SET) != 0)
        return status_fail(STATUS_IO, "cannot read the log: %s", strerror(errno));
    recording->replaying = true;
    enum status status = take_again(recording, reader, place);
    recording->replaying = false;
    TRY(status);
    TRY(resumed_totals_check(recording, info));
    recording->next_seq[RECORD_RUN_INFO] = recording->next_seq[RECORD_PARTICLES] = 0; /* are said again */
    particle_set_restart(&recording->particles);
    return run_store_continue(recording->store, place);
}

/* A run that goes on: everything up to its checkpoint is taken again from the log, which is cut there. */
static enum status resume(struct record_receiver *recording, const shakedown_run_info_t *info)
{
    struct event_reader reader;
    char reason[512];
    if (!recording->resume)
        return status_fail(STATUS_IO, "the run goes on from a checkpoint: the recorder needs --resume");
    if (access(run_store_log_path(recording->store), F_OK) != 0 && access(run_store_path(recording->store), F_OK) == 0)
        return status_fail(STATUS_IO, "%s is complete already, its log was removed", run_store_path(recording->store));
    enum status status = event_reader_open(&reader, run_store_log_path(recording->store));
    if (status == STATUS_OK)
        status = resume_from(recording, info, &reader);
    event_reader_close(&reader);
    if (status == STATUS_OK)
        return STATUS_OK;
    snprintf(reason, sizeof reason, "%s", status_message());
    return status_fail(STATUS_IO, "%s cannot be gone on with: %s", run_store_log_path(recording->store), reason);
}

static enum status take_run_info(struct record_receiver *recording, const shakedown_run_info_t *info)
{
    if (info->n_resumed == 0)
        return begin(recording, info);
    struct scene_record record = {0};
    TRY(record_settings_read(info, &record)); /* STATUS_FORMAT before anything is touched */
    return resume(recording, info);
}

static enum status take_particles(struct record_receiver *recording, const shakedown_particles_t *chunk)
{
    TRY(particle_set_add(&recording->particles, &recording->facts, chunk));
    if (!particle_set_is_complete(&recording->particles))
        return STATUS_OK;
    return run_store_particles(recording->store, &recording->particles);
}

static enum status take_sample(struct record_receiver *recording, const shakedown_sample_t *sample)
{
    if (sample->dimension != recording->facts.dimension)
        return status_fail(STATUS_FORMAT, "SAMPLE: its dimension is not the run's");
    return run_store_sample(recording->store, sample);
}

static enum status take_note(struct record_receiver *recording, const shakedown_note_t *message)
{
    return run_store_note(recording->store, message);
}

static enum status take_frame_particles(struct record_receiver *recording, const shakedown_frame_particles_t *chunk)
{
    bool full;
    TRY(particle_frame_add(&recording->particle_frame, &recording->facts, chunk, &full));
    if (!full)
        return STATUS_OK;
    TRY(run_store_particle_frame(recording->store, &recording->particle_frame));
    frame_place_next(&recording->particle_frame.place);
    return STATUS_OK;
}

static enum status take_frame_contacts(struct record_receiver *recording, const shakedown_frame_contacts_t *chunk)
{
    bool full;
    TRY(contact_frame_add(&recording->contact_frame, &recording->facts, chunk, &full));
    if (!full)
        return STATUS_OK;
    TRY(run_store_contact_frame(recording->store, &recording->contact_frame));
    frame_place_next(&recording->contact_frame.place);
    return STATUS_OK;
}

/* Hands a record that is next to its taker. STATUS_FORMAT: it does not fit, and nothing was changed. */
static enum status take_record(struct record_receiver *recording, int kind, const union message *message)
{
    switch (kind) {
    case RECORD_RUN_INFO:
        return take_run_info(recording, &message->run_info);
    case RECORD_PARTICLES:
        return take_particles(recording, &message->particles);
    case RECORD_SAMPLE:
        return take_sample(recording, &message->sample);
    case RECORD_FRAME_PARTICLES:
        return take_frame_particles(recording, &message->frame_particles);
    case RECORD_FRAME_CONTACTS:
        return take_frame_contacts(recording, &message->frame_contacts);
    case RECORD_NOTE:
        return take_note(recording, &message->note);
    default:
        return STATUS_OK; /* CHECKPOINT, END: all that matters was checked before */
    }
}

/* Whether everything that END counts is here (END itself is the one that is being taken). */
static bool totals_match(const struct record_receiver *recording, const shakedown_end_t *end)
{
    for (int c = 0; c < RECORD_CHANNELS; c++) {
        if (end->total[c] != recording->next_seq[c] + (c == RECORD_END))
            return false;
    }
    if (!particle_set_is_complete(&recording->particles) || recording->particle_frame.place.next_chunk != 0 ||
        recording->contact_frame.place.next_chunk != 0)
        return false;
    return !recording->wants_walls ||
           (end->wall_states == recording->wall_total[0] && end->wall_commands == recording->wall_total[1]);
}

static bool everything_before_is_here(const struct record_receiver *recording, const shakedown_checkpoint_t *checkpoint)
{
    if (recording->wants_walls && wall_order_exchanges(&recording->walls) < checkpoint->wall_states)
        return false;
    for (int c = 0; c < RECORD_CHANNELS; c++) {
        if (checkpoint->total[c] != recording->next_seq[c])
            return false;
    }
    return true;
}

static enum status keep_end(struct record_receiver *recording, const shakedown_end_t *end)
{
    shakedown_end_t *copy = shakedown_end_t_copy(end);
    if (!copy)
        return status_fail(STATUS_NO_MEMORY, "no memory for END");
    if (recording->end)
        shakedown_end_t_destroy(recording->end);
    recording->end = copy;
    recording->end_matches = totals_match(recording, end);
    return STATUS_OK;
}

/* Numbers prove that all records are here, hashes that they are those that were sent: a foreign or changed one that
 * passed all other checks is found here. */
static enum status hashes_check(const struct record_receiver *recording, const int64_t hash[RECORD_CHANNELS])
{
    for (int c = 0; c < RECORD_END; c++) {
        if (hash[c] != recording->hash[c])
            return status_fail(STATUS_INCOMPLETE, "the records on %s are not those that were sent (their hash differs)",
                               record_channel_name[c]);
    }
    return STATUS_OK;
}

/* Whether what a record builds on is here. The channels are numbered each for itself, so that after a loss a frame can
 * come before the particles. END is taken when all it counts is, and is then the last record of an event log too. */
static enum status is_ready(struct record_receiver *recording, int kind, const union message *message, bool *ready)
{
    *ready = kind == RECORD_RUN_INFO || recording->has_run;
    if (*ready && (kind == RECORD_FRAME_PARTICLES || kind == RECORD_FRAME_CONTACTS))
        *ready = particle_set_is_complete(&recording->particles);
    if (*ready && kind == RECORD_CHECKPOINT)
        *ready = everything_before_is_here(recording, &message->checkpoint);
    if (*ready && kind == RECORD_CHECKPOINT)
        TRY(hashes_check(recording, message->checkpoint.hash));
    if (*ready && kind == RECORD_END) {
        TRY(keep_end(recording, &message->end));
        *ready = recording->end_matches;
        recording->end_matches = false; /* until the hashes are compared */
        if (*ready)
            TRY(hashes_check(recording, message->end.hash));
        recording->end_matches = *ready;
    }
    return STATUS_OK;
}

/* It cannot be taken before others are here. */
static void take_early(struct record_receiver *recording, int kind, const union message *message, const void *data,
                       size_t size)
{
    recording->drops.early++;
    if (!recording->from_log && !recording->replaying) /* what a log lacks never comes */
        early_records_keep(&recording->early, kind, message->header.seq, data, size);
}

/* A record of this run that is next on its channel. */
static enum status take_next(struct record_receiver *recording, int kind, const union message *message,
                             const void *data, size_t size, enum recording_answer *answer)
{
    bool ready;
    TRY(is_ready(recording, kind, message, &ready));
    if (!ready) {
        take_early(recording, kind, message, data, size);
        *answer = ANSWER_NOW;
        return STATUS_OK;
    }
    enum status status = take_record(recording, kind, message);
    if (status == STATUS_FORMAT)
        return refuse(recording, kind, data, size);
    TRY(status);
    bool repeated = recording->resume && !recording->replaying && (kind == RECORD_RUN_INFO || kind == RECORD_PARTICLES);
    if (!repeated) /* by a run that goes on: the log has it */
        TRY(log_message(recording, kind, data, size));
    if (!repeated)
        recording->hash[kind] = record_hash_add(recording->hash[kind], data, size);
    recording->sync_wanted |= kind >= RECORD_CHECKPOINT;
    recording->next_seq[kind]++;
    recording->last_step = message->header.step;
    recording->last_time_s = message->header.time_s;
    *answer = kind == RECORD_RUN_INFO || kind >= RECORD_CHECKPOINT ? ANSWER_NOW : ANSWER_SOON;
    return kind == RECORD_RUN_INFO && !recording->replaying ? backlog_take(recording) : STATUS_OK;
}

/* Whether a kept one is next and can be taken; it is taken out of those that are kept, also if it is no use. */
static enum status early_try(struct record_receiver *recording, int k, bool *taken)
{
    const struct early_record *kept = recording->early.record[k];
    union message message;
    enum recording_answer answer;
    *taken = false;
    if (kept->seq > recording->next_seq[kept->kind])
        return STATUS_OK;
    if (kept->seq == recording->next_seq[kept->kind]) {
        TRY(message_decode(kept->kind, kept->data, kept->size, &message)); /* it was decoded before */
        enum status status = is_ready(recording, kept->kind, &message, taken);
        if (status == STATUS_OK && *taken)
            status = take_next(recording, kept->kind, &message, kept->data, kept->size, &answer);
        message_free(kept->kind, &message);
        TRY(status);
        if (!*taken)
            return STATUS_OK;
    }
    free(early_records_take(&recording->early, k));
    return STATUS_OK;
}

/* Those whose turn it is now; each may be what others wait for. */
static enum status early_try_all(struct record_receiver *recording)
{
    bool taken = false;
    if (recording->replaying)
        return STATUS_OK;
    for (int k = 0; k < recording->early.count; k = taken ? 0 : k + 1)
        TRY(early_try(recording, k, &taken));
    return STATUS_OK;
}

static bool is_foreign(const struct record_receiver *recording, int kind, const union message *message)
{
    if (recording->any_run && !recording->has_run)
        return kind != RECORD_RUN_INFO && kind < RECORD_CHANNELS;
    return message->header.run_id != recording->run_id;
}

static enum status take_message(struct record_receiver *recording, int kind, const union message *message,
                                const void *data, size_t size, enum recording_answer *answer)
{
    if (is_foreign(recording, kind, message)) {
        recording->drops.foreign++;
        return STATUS_OK;
    }
    if (kind >= RECORD_CHANNELS) {
        *answer = ANSWER_NONE;
        if (!recording->has_run)
            return backlog_add(&recording->backlog, kind, data, size);
        TRY(take_wall(recording, kind, message, data, size, answer));
        return early_try_all(recording);
    }
    if (message->header.seq == recording->next_seq[kind]) {
        TRY(take_next(recording, kind, message, data, size, answer));
        return early_try_all(recording);
    }
    if (message->header.seq < recording->next_seq[kind])
        recording->drops.repeated++;
    else
        take_early(recording, kind, message, data, size);
    *answer = ANSWER_NOW;
    return STATUS_OK;
}

enum status record_receiver_take(struct record_receiver *recording, int kind, const void *data, size_t size,
                                 enum recording_answer *answer)
{
    union message message;
    *answer = ANSWER_NONE;
    if (size > BUS_MESSAGE_MAX) {
        recording->drops.oversized++;
        return STATUS_OK;
    }
    if (recording->has_run && kind >= RECORD_CHANNELS && !recording->wants_walls)
        return STATUS_OK;
    if (message_decode(kind, data, size, &message) != STATUS_OK) {
        drop_malformed(recording);
        return STATUS_OK;
    }
    enum status status = take_message(recording, kind, &message, data, size, answer);
    message_free(kind, &message);
    return status;
}

enum status record_receiver_secure(struct record_receiver *recording)
{
    if (!recording->has_run || recording->finished)
        return STATUS_OK;
    TRY(run_store_secure(recording->store, recording->sync_wanted));
    recording->sync_wanted = false;
    return STATUS_OK;
}

bool record_receiver_waits_for_room(const struct record_receiver *recording)
{
    return run_store_log_is_full(recording->store);
}

void record_receiver_publish(struct record_receiver *recording)
{
    if (recording->has_run && !recording->finished)
        run_store_publish(recording->store);
}

void record_receiver_ack(const struct record_receiver *recording, struct record_receiver_ack *ack)
{
    const struct early_records *early = &recording->early;
    memcpy(ack->next_seq, recording->next_seq, sizeof ack->next_seq);
    for (int k = 0; k < early->count; k++) {
        ack->held_channel[k] = early->record[k]->kind;
        ack->held_seq[k] = early->record[k]->seq;
    }
    ack->message = (shakedown_record_ack_t){.run_id = recording->run_id,
                                            .step = recording->last_step,
                                            .time_s = recording->last_time_s,
                                            .next_wall_seq = wall_order_exchanges(&recording->walls),
                                            .walls_held = (int32_t)wall_order_held(&recording->walls),
                                            .n_channels = RECORD_CHANNELS,
                                            .next_seq = ack->next_seq,
                                            .n_held = early->count,
                                            .held_channel = ack->held_channel,
                                            .held_seq = ack->held_seq,
                                            .complete = recording->complete};
}

int64_t record_receiver_run_id(const struct record_receiver *recording)
{
    return recording->run_id;
}

bool record_receiver_has_run(const struct record_receiver *recording)
{
    return recording->has_run;
}

bool record_receiver_wants_walls(const struct record_receiver *recording)
{
    return recording->wants_walls;
}

bool record_receiver_end_matches(const struct record_receiver *recording)
{
    return recording->end_matches;
}

bool record_receiver_is_complete(const struct record_receiver *recording)
{
    return recording->complete;
}

const struct record_receiver_drops *record_receiver_drops(const struct record_receiver *recording)
{
    return &recording->drops;
}

/* Says which totals differ. */
static enum status incomplete(const struct record_receiver *recording)
{
    char text[512] = "";
    size_t used = 0;
    const shakedown_end_t *end = recording->end;
    if (!recording->has_run)
        return status_fail(STATUS_INCOMPLETE, "no RUN_INFO came: nothing was recorded");
    if (!end)
        return status_fail(STATUS_INCOMPLETE, "%s: END is missing", run_store_path(recording->store));
    for (int c = 0; c < RECORD_END && used < sizeof text; c++) {
        if (end->total[c] != recording->next_seq[c])
            used += (size_t)snprintf(text + used, sizeof text - used, " %s %" PRId64 " of %" PRId64,
                                     record_channel_name[c], recording->next_seq[c], end->total[c]);
    }
    const int64_t sent[] = {end->wall_states, end->wall_commands};
    for (int k = 0; k < 2 && recording->wants_walls && used < sizeof text; k++) {
        if (sent[k] != recording->wall_total[k])
            used += (size_t)snprintf(text + used, sizeof text - used, " %s %" PRId64 " of %" PRId64,
                                     message_channel(MESSAGE_WALL_STATE + k), recording->wall_total[k], sent[k]);
    }
    return status_fail(STATUS_INCOMPLETE, "%s: messages are missing:%s", run_store_path(recording->store),
                       text[0] ? text : " chunks of a frame");
}

enum status record_receiver_finish(struct record_receiver *recording)
{
    if (recording->finished)
        return recording->complete ? STATUS_OK : incomplete(recording);
    recording->finished = true;
    while (recording->has_run && wall_order_skip(&recording->walls, -1)) /* what waits for what never came */
        TRY(walls_write_next(recording));
    TRY(run_store_finish(recording->store, recording->end, recording->end_matches));
    recording->complete = recording->end_matches;
    return recording->complete ? STATUS_OK : incomplete(recording);
}

struct run_counts record_receiver_counts(const struct record_receiver *recording)
{
    return run_store_counts(recording->store);
}

void record_receiver_summary(const struct record_receiver *recording, char *text, size_t size)
{
    struct stat file;
    const struct run_counts counts = run_store_counts(recording->store);
    double bytes = stat(run_store_path(recording->store), &file) == 0 ? (double)file.st_size : 0.0;
    int used = snprintf(text, size, "%s %s: %" PRId64 " samples, %" PRId64 " frames", run_store_path(recording->store),
                        recording->complete ? "complete" : "incomplete", counts.samples, counts.frames);
    if (recording->wants_walls && used > 0 && (size_t)used < size)
        used += snprintf(text + used, size - (size_t)used, ", %" PRId64 " wall states", counts.wall_states);
    if (used > 0 && (size_t)used < size)
        snprintf(text + used, size - (size_t)used, ", %.1f MB", 1e-6 * bytes);
}

void record_receiver_free(struct record_receiver *recording)
{
    if (!recording)
        return;
    run_store_free(recording->store);
    early_records_free(&recording->early);
    backlog_free(&recording->backlog);
    particle_set_free(&recording->particles);
    particle_frame_free(&recording->particle_frame);
    contact_frame_free(&recording->contact_frame);
    if (recording->end)
        shakedown_end_t_destroy(recording->end);
    free(recording);
}
