/* Checkpoints: everything that decides later bits, in one file (docs/checkpoints.md). One table drives saving, loading
 * and comparing. */
#ifndef SHAKEDOWN_SIM_RUN_CHECKPOINT_H
#define SHAKEDOWN_SIM_RUN_CHECKPOINT_H

#include <stddef.h>

#include "common/bus.h"
#include "common/scene.h"
#include "sim/sample/sample.h"

/* Where a run stands, beside the state of the sample. */
struct run_progress {
    int64_t run_id;
    double fraction_done;
    double kinetic_j, elastic_j; /* as the controller was told last, measured at energy_step */
    int64_t energy_step;
    int64_t frame_strain_next;
    int64_t exchanges, commands_repeated; /* answered states; states sent again */
    int64_t frames;                       /* recorded */
    int64_t last_sample_step, last_frame_step;
    int64_t record_total[RECORD_CHANNELS]; /* records sent, all of them acknowledged */
    int64_t log_bytes;                     /* length of the event log that sim writes itself; 0: none */
    double elapsed_s;
    int has_command; /* the command for the current step was asked for ahead: this one */
    struct wall_command command;
};

/* Writes `path` (a temporary file beside it, fsync, rename, fsync of the folder): a kill at any moment leaves the old
 * file or the new one. STATUS_IO, the old file untouched, if the disk does not take it. */
enum status checkpoint_write(const char *path, const struct sample *sample,
                             const struct run_progress *progress) MUST_USE;

/* `copy` becomes another name of the file at `path` (a copy where links are not to be had); an older one is replaced.
 */
enum status checkpoint_share(const char *path, const char *copy) MUST_USE;

/* Makes the sample as it was and says where its run stood. `scene` must be the run's and outlive the sample. STATUS_IO
 * (no such file), STATUS_FORMAT (not a checkpoint, or damaged), STATUS_CONFIG (another scene: names the first key that
 * differs). */
enum status checkpoint_resume(const char *path, const struct scene *scene, struct sample **sample,
                              struct run_progress *progress) MUST_USE;

/* Takes particles, contacts and walls over into a sample of another scene that is just being made. Histories and
 * springs are taken where both scenes model them; a history that the checkpoint lacks starts as the overlap, a spring
 * as zero. The walls start at rest. Errors as above; STATUS_CONFIG names number of particles or dimension if they
 * differ. */
enum status checkpoint_start(const char *path, struct sample *sample) MUST_USE;

/* Whether two states are the same bits; else `difference` [size] names the first item that differs. */
bool checkpoint_equal(const struct sample *a, const struct sample *b, char *difference, size_t size);

#endif
