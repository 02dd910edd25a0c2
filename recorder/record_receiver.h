/* The receiver's side of the record stream (lcmtypes/CHANNELS.md) and what it keeps: takes raw messages from anywhere
 * (bus, log, test), keeps those that are next, drops and counts all others, and knows when a run is complete. */
#ifndef SHAKEDOWN_RECORDER_RECORD_RECEIVER_H
#define SHAKEDOWN_RECORDER_RECORD_RECEIVER_H

#include "common/message.h"
#include "recorder/early_records.h"
#include "recorder/run_store.h"

struct record_receiver;

struct record_receiver_options {
    const char *directory; /* made if it is not there */
    bool any_run;          /* take the run of the first RUN_INFO; else: */
    int64_t run_id;
    bool from_log;       /* no log is written */
    bool replace;        /* run.h5 may be there already: it is replaced at the end */
    bool resume;         /* a run that goes on from a checkpoint, as its RUN_INFO says */
    store_remake remake; /* convert_into, unless from_log */
};

/* What was dropped. */
struct record_receiver_drops {
    int64_t foreign;   /* of another run */
    int64_t malformed; /* no such message, or one that does not fit its run */
    int64_t oversized;
    int64_t repeated; /* had it already */
    int64_t early;    /* something before it is missing */
};

/* How soon the sender wants to hear. */
enum recording_answer { ANSWER_NONE, ANSWER_SOON /* a record was kept */, ANSWER_NOW };

/* Prepares the directory; STATUS_IO if it cannot be written or holds a run already. */
enum status record_receiver_create(struct record_receiver **recording,
                                   const struct record_receiver_options *options) MUST_USE;

/* Takes one raw message of `kind` (messages.h). Whatever the bytes are, the status is only bad if the recorder itself
 * fails (STATUS_IO, STATUS_NO_MEMORY), or if the run says again what cannot be recorded (STATUS_FORMAT); then nothing
 * more can be taken. */
enum status record_receiver_take(struct record_receiver *recording, int kind, const void *data, size_t size,
                                 enum recording_answer *answer) MUST_USE;

/* To be called before what was taken is acknowledged: hands the log to the system, and brings it to disk after a
 * CHECKPOINT or END. STATUS_IO; if record_receiver_waits_for_room then, it can be tried again. */
enum status record_receiver_secure(struct record_receiver *recording) MUST_USE;
bool record_receiver_waits_for_room(const struct record_receiver *recording);

/* Shows readers what is there so far (run_store_publish). */
void record_receiver_publish(struct record_receiver *recording);

/* An acknowledgement with the arrays it points to. */
struct record_receiver_ack {
    shakedown_record_ack_t message; /* all but seq, waits and failed */
    int64_t next_seq[RECORD_CHANNELS];
    int32_t held_channel[EARLY_MAX];
    int64_t held_seq[EARLY_MAX];
};

/* What is here. `ack` must not be moved, as its message points into it. */
void record_receiver_ack(const struct record_receiver *recording, struct record_receiver_ack *ack);

int64_t record_receiver_run_id(const struct record_receiver *recording);
bool record_receiver_has_run(const struct record_receiver *recording);     /* RUN_INFO was taken */
bool record_receiver_wants_walls(const struct record_receiver *recording); /* as RUN_INFO says */
bool record_receiver_end_matches(const struct record_receiver *recording); /* END was taken: every total matches */
const struct record_receiver_drops *record_receiver_drops(const struct record_receiver *recording);

/* Writes and closes all files; `complete` is set if END matched. STATUS_INCOMPLETE, with what is missing, if it did
 * not. No record may follow. */
enum status record_receiver_finish(struct record_receiver *recording) MUST_USE;

/* True after a record_receiver_finish that gave STATUS_OK. */
bool record_receiver_is_complete(const struct record_receiver *recording);

/* "DIR/run.h5 complete: 1300 samples, 14 frames, 2.1 MB". */
struct run_counts record_receiver_counts(const struct record_receiver *recording);

void record_receiver_summary(const struct record_receiver *recording, char *text, size_t size);

/* Releases all; files are closed by record_receiver_finish alone. */
void record_receiver_free(struct record_receiver *recording);

#endif
