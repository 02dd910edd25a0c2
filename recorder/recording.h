/* The receiver's side of the record stream (lcmtypes/CHANNELS.md) and what it keeps: takes raw messages from anywhere
 * (bus, log, test), keeps those that are next, drops and counts all others, and knows when a run is complete. */
#ifndef SHAKEDOWN_RECORDER_RECORDING_H
#define SHAKEDOWN_RECORDER_RECORDING_H

#include "common/message.h"
#include "recorder/early.h"
#include "recorder/store.h"

struct recording;

struct recording_options {
    const char *directory; /* made if it is not there */
    bool any_run;          /* take the run of the first RUN_INFO; else: */
    int64_t run_id;
    bool from_log;       /* no log is written */
    bool replace;        /* run.h5 may be there already: it is replaced at the end */
    bool resume;         /* a run that goes on from a checkpoint, as its RUN_INFO says */
    store_remake remake; /* convert_into, unless from_log */
};

/* What was dropped. */
struct recording_drops {
    int64_t foreign;   /* of another run */
    int64_t malformed; /* no such message, or one that does not fit its run */
    int64_t oversized;
    int64_t repeated; /* had it already */
    int64_t early;    /* something before it is missing */
};

/* How soon the sender wants to hear. */
enum recording_answer { ANSWER_NONE, ANSWER_SOON /* a record was kept */, ANSWER_NOW };

/* Prepares the directory; STATUS_IO if it cannot be written or holds a run already. */
enum status recording_create(struct recording **recording, const struct recording_options *options) MUST_USE;

/* Takes one raw message of `kind` (messages.h). Whatever the bytes are, the status is only bad if the recorder itself
 * fails (STATUS_IO, STATUS_NO_MEMORY); then nothing more can be taken. */
enum status recording_take(struct recording *recording, int kind, const void *data, size_t size,
                           enum recording_answer *answer) MUST_USE;

/* To be called before what was taken is acknowledged: hands the log to the system, and brings it to disk after a
 * CHECKPOINT or END. STATUS_IO; if recording_waits_for_room then, it can be tried again. */
enum status recording_secure(struct recording *recording) MUST_USE;
bool recording_waits_for_room(const struct recording *recording);

/* Shows readers what is there so far (store_publish). */
void recording_publish(struct recording *recording);

/* An acknowledgement with the arrays it points to. */
struct recording_ack {
    shakedown_record_ack_t message; /* all but seq, waits and failed */
    int64_t next_seq[RECORD_CHANNELS];
    int32_t held_channel[EARLY_MAX];
    int64_t held_seq[EARLY_MAX];
};

/* What is here. `ack` must not be moved, as its message points into it. */
void recording_ack(const struct recording *recording, struct recording_ack *ack);

int64_t recording_run_id(const struct recording *recording);
bool recording_has_run(const struct recording *recording);     /* RUN_INFO was taken */
bool recording_wants_walls(const struct recording *recording); /* as RUN_INFO says */
bool recording_end_matches(const struct recording *recording); /* END was taken: every total matches */
const struct recording_drops *recording_drops(const struct recording *recording);

/* Writes and closes all files; `complete` is set if END matched. STATUS_INCOMPLETE, with what is missing, if it did
 * not. No record may follow. */
enum status recording_finish(struct recording *recording) MUST_USE;

/* True after a recording_finish that gave STATUS_OK. */
bool recording_is_complete(const struct recording *recording);

/* "DIR/run.h5 complete: 1300 samples, 14 frames, 2.1 MB". */
struct run_counts recording_counts(const struct recording *recording);

void recording_summary(const struct recording *recording, char *text, size_t size);

/* Releases all; files are closed by recording_finish alone. */
void recording_free(struct recording *recording);

#endif
