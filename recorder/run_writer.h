/* Writes run.h5 as docs/file-format.md says. Order of calls: create, particles, then samples, frames and wall messages
 * in any order, end, close. After a failure only run_writer_close may follow. */
#ifndef SHAKEDOWN_RECORDER_RUN_WRITER_H
#define SHAKEDOWN_RECORDER_RUN_WRITER_H

#include "recorder/assembly.h"

struct run_writer;

/* What a run holds so far. */
struct run_counts {
    int64_t samples, frames, contact_frames, wall_states, wall_commands;
};

/* Creates `path` (STATUS_IO if it exists) with everything that RUN_INFO fixes and `complete` = 0; readable from then
 * on. `walls`: with the tables of wall states and commands. On failure there is no file, and *writer may be not NULL
 * and wants closing. */
enum status run_writer_create(struct run_writer **writer, const char *path, const shakedown_run_info_t *info,
                              bool walls) MUST_USE;

/* Opens the file of a run that goes on (info->n_resumed > 0) and drops what was recorded after its checkpoint;
 * `complete` becomes 0. *counts: what is left; of the walls there may be less than the checkpoint knows of, which END's
 * totals will tell. STATUS_IO if it is another run's, has ended well, or lacks records. */
enum status run_writer_resume(struct run_writer **writer, const char *path, const shakedown_run_info_t *info,
                              bool walls, struct run_counts *counts) MUST_USE;

/* The times of the frames there are, [counts.frames]. */
enum status run_writer_frame_times(const struct run_writer *writer, double *time_s) MUST_USE;

/* Writes radius, mass and id of a complete set, unless they are there already. */
enum status run_writer_particles(struct run_writer *writer, const struct particle_set *set) MUST_USE;

/* Takes a sample, a wall state, a wall command whose counts fit the run; rows are written in blocks. */
enum status run_writer_sample(struct run_writer *writer, const shakedown_sample_t *sample) MUST_USE;
enum status run_writer_wall_state(struct run_writer *writer, const shakedown_wall_state_t *state) MUST_USE;
enum status run_writer_wall_command(struct run_writer *writer, const shakedown_wall_command_t *command) MUST_USE;

/* Writes a note as one line of text. */
enum status run_writer_note(struct run_writer *writer, const shakedown_note_t *message) MUST_USE;

/* Writes a full frame. */
enum status run_writer_particle_frame(struct run_writer *writer, const struct particle_frame *frame) MUST_USE;
enum status run_writer_contact_frame(struct run_writer *writer, const struct contact_frame *frame) MUST_USE;

/* Brings to the file what a reader may want after a kill: all but the last rows of compressed tables. */
enum status run_writer_flush(struct run_writer *writer) MUST_USE;

/* The same, and on disk. */
enum status run_writer_sync(struct run_writer *writer) MUST_USE;

/* Writes what END says as attributes. */
enum status run_writer_end(struct run_writer *writer, const shakedown_end_t *end) MUST_USE;

/* Whether a write has failed: the file is as the last flush left it. */
bool run_writer_has_failed(const struct run_writer *writer);

struct run_counts run_writer_counts(const struct run_writer *writer);

/* Writes what waits, flushes, then, if `complete`, sets the attribute `complete`; closes the file. After a failure the
 * file is left to the end of the process as the last flush left it. Frees the writer. NULL is nothing. */
enum status run_writer_close(struct run_writer *writer, bool complete) MUST_USE;

#endif
