/* The files of a run. The log (run.lcm) is the record: appended to, brought to disk when the sender asks. run.h5 is
 * made from the same messages in run.h5.part; what a reader sees is a copy that is put in its place whole, so that
 * whenever this process is killed run.h5 may be old, but never unreadable, and can be made again from the log. */
#ifndef SHAKEDOWN_RECORDER_RUN_STORE_H
#define SHAKEDOWN_RECORDER_RUN_STORE_H

#include "common/event_log.h"
#include "recorder/run_writer.h"

struct run_store;

/* Makes run.h5 in `directory` from the log (convert_into). */
typedef enum status (*store_remake)(const char *log_path, const char *directory, struct run_counts *counts);

struct run_store_options {
    const char *directory; /* made if it is not there, and locked */
    bool log;              /* write a log; else the messages come from one */
    bool replace;          /* run.h5 may be there already: it is replaced at the end */
    store_remake remake;   /* wanted by a store with a log */
};

/* STATUS_IO if the folder cannot be written, is another recorder's, or holds a run already. */
enum status run_store_create(struct run_store **store, const struct run_store_options *options) MUST_USE;

/* Creates the files of a run; keep_log: the log stays also when run.h5 is complete. */
enum status run_store_begin(struct run_store *store, const shakedown_run_info_t *info, bool walls,
                            bool keep_log) MUST_USE;

/* Goes on with the log of an earlier recorder from byte `size`, after its messages were taken again. */
enum status run_store_continue(struct run_store *store, int64_t size) MUST_USE;

/* Each goes into run.h5 to be. If that cannot be written, as the disk is full, a store with a log does without it, says
 * so, and makes it from the log at the end. */
enum status run_store_particles(struct run_store *store, const struct particle_set *set) MUST_USE;
enum status run_store_sample(struct run_store *store, const shakedown_sample_t *sample) MUST_USE;
enum status run_store_note(struct run_store *store, const shakedown_note_t *note) MUST_USE;
enum status run_store_particle_frame(struct run_store *store, const struct particle_frame *frame) MUST_USE;
enum status run_store_contact_frame(struct run_store *store, const struct contact_frame *frame) MUST_USE;
enum status run_store_wall_state(struct run_store *store, const shakedown_wall_state_t *state) MUST_USE;
enum status run_store_wall_command(struct run_store *store, const shakedown_wall_command_t *command) MUST_USE;

/* Appends a message to the log, if there is one. */
enum status run_store_log(struct run_store *store, int kind, const void *data, size_t size) MUST_USE;

/* Hands the log to the system, or brings it to disk. STATUS_IO with run_store_log_is_full: try again later. */
enum status run_store_secure(struct run_store *store, bool sync) MUST_USE;
bool run_store_log_is_full(const struct run_store *store);

/* Puts what is there so far in the place of run.h5 and run.xdmf. Failing at it is no failure of the run. */
void run_store_publish(struct run_store *store);

/* Writes what is left, and END if it came; run.h5 and run.xdmf in their places and on disk. */
enum status run_store_finish(struct run_store *store, const shakedown_end_t *end, bool complete) MUST_USE;

/* What run.h5 holds, after run_store_finish. */
struct run_counts run_store_counts(const struct run_store *store);
const char *run_store_path(const struct run_store *store);     /* of run.h5 */
const char *run_store_log_path(const struct run_store *store); /* of run.lcm */

/* Closes what is open, and unlocks the folder. NULL is nothing. */
void run_store_free(struct run_store *store);

#endif
