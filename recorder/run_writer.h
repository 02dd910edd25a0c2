/* Writes run.h5 as docs/file-format.md says. Order of calls: create, particles, then samples, frames and wall messages
 * in any order, end, close. After a failure only run_writer_abandon may follow. */
#ifndef SHAKEDOWN_RECORDER_RUN_WRITER_H
#define SHAKEDOWN_RECORDER_RUN_WRITER_H

#include "recorder/chunk_assembly.h"

struct run_writer;

/* What a run holds so far. */
struct run_counts {
    int64_t samples, frames, contact_frames, wall_states, wall_commands;
};

/* Creates `path` (STATUS_IO if it exists) with everything that RUN_INFO fixes and `complete` = 0. `walls`: with the
 * tables of wall states and commands. On failure *writer may be not NULL and wants run_writer_abandon. */
enum status run_writer_create(struct run_writer **writer, const char *path, const shakedown_run_info_t *info,
                              bool walls) MUST_USE;

/* Writes radius, mass and id of a complete set; the second time, of a run that goes on, there is nothing to do. */
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

/* Brings to the file what a reader of a copy may want: all but the last rows of compressed tables. */
enum status run_writer_flush(struct run_writer *writer) MUST_USE;

/* Writes what END says as attributes. */
enum status run_writer_end(struct run_writer *writer, const shakedown_end_t *end) MUST_USE;

struct run_counts run_writer_counts(const struct run_writer *writer);

/* Writes what waits, then, if `complete`, sets the attribute `complete`; closes the file and frees the writer, also on
 * failure. NULL is nothing. */
enum status run_writer_close(struct run_writer *writer, bool complete) MUST_USE;

/* Gives up a file that cannot be written, and its room on the disk; frees the writer. NULL is nothing. */
void run_writer_abandon(struct run_writer *writer);

#endif
