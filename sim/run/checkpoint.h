/* Checkpoints: everything that decides later bits, in one file (docs/checkpoints.md). One table drives saving, loading
 * and comparing. */
#ifndef SHAKEDOWN_SIM_RUN_CHECKPOINT_H
#define SHAKEDOWN_SIM_RUN_CHECKPOINT_H

#include <stddef.h>

#include "common/scene.h"
#include "sim/run/run_progress.h"
#include "sim/sample/sample.h"

/* Writes `path` (a temporary file beside it, fsync, rename, fsync of the folder): a kill at any moment leaves the old
 * file or the new one. STATUS_IO, the old file untouched, if the disk does not take it. */
enum status checkpoint_write(const char *path, struct sample *sample, const struct run_progress *progress) MUST_USE;

/* `copy` becomes another name of the file at `path` (a copy where links are not to be had); an older one is replaced.
 */
enum status checkpoint_share(const char *path, const char *copy) MUST_USE;

/* Makes the sample as it was and says where its run stood. `scene` must be the run's and outlive the sample. STATUS_IO
 * (no such file), STATUS_FORMAT (not a checkpoint, or damaged), STATUS_CONFIG (another scene: names the first key that
 * differs). */
enum status checkpoint_resume(const char *path, const struct scene *scene, struct sample **sample,
                              struct run_progress *progress) MUST_USE;

/* The sample that a checkpoint holds, as the scene that wrote it had it. */
struct checkpoint_content {
    struct scene scene;
    struct sample *sample;
    struct run_progress progress;
    char *config, *kernel_set;
};

/* Reads a checkpoint to start from; what files of older versions lack may be missing. Errors as above. */
enum status checkpoint_load_sample(struct checkpoint_content **content, const char *path) MUST_USE;
void checkpoint_content_free(struct checkpoint_content *content);

/* Whether two states are the same bits; else `difference` [size] names the first item that differs. */
bool checkpoint_equal(struct sample *a, struct sample *b, char *difference, size_t size);

#endif
