/* Prepared samples: a scene's stages but the last, run once by sim, and the last stage as a scene of its own. */
#ifndef SHAKEDOWN_BENCH_PREPARED_SAMPLE_H
#define SHAKEDOWN_BENCH_PREPARED_SAMPLE_H

#include "common/scene.h"
#include "sim/sample/sample.h"

/* Runs all stages but the last of the scene at `path`, with `overrides` ["path=value"], by the program `sim`, and keeps
 * the sample as FOLDER/prepared.h5, its name in `checkpoint` [CONFIG_STRING_MAX]. One that is there already is taken as
 * it is. STATUS_USAGE for a scene of one stage; STATUS_IO. */
enum status prepare_sample(const char *sim, const char *path, const char *const *overrides, int n_overrides,
                           const char *folder, char *checkpoint) MUST_USE;

/* A copy that owns its stages and text, or NULL without memory; released by prepare_scene_free, to which NULL may be
 * given. */
struct scene *prepare_scene_copy(const struct scene *from);
void prepare_scene_free(struct scene *scene);

/* Leaves only stage `stage` of `scene`, started from `checkpoint`. */
void prepare_stage(struct scene *scene, int stage, const char *checkpoint);

/* Leaves no contact of the sample a history, spring or state of sliding. STATUS_NO_MEMORY. */
enum status prepare_forget(struct sample *sample) MUST_USE;

/* The name of an existing file as a scene takes it: absolute, and not too long. `checkpoint` [CONFIG_STRING_MAX]. */
enum status prepare_path(const char *file, char *checkpoint) MUST_USE;

/* Writes the scene as a file that sim reads. STATUS_IO. */
enum status prepare_scene_file(const struct scene *scene, const char *path) MUST_USE;

#endif
