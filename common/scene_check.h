/* Checks between the keys of a scene. Internal to common/scene*.c. STATUS_CONFIG with file, line, key, what is wrong
 * and what is allowed. */
#ifndef SHAKEDOWN_COMMON_SCENE_CHECK_H
#define SHAKEDOWN_COMMON_SCENE_CHECK_H

#include <libconfig.h>

#include "common/scene.h"

/* The sample, and what follows from it; reads the file of its grains. `path`: of the scene, from which other paths are
 * relative; NULL: the sample comes from a record, which says what the file held. */
enum status scene_check_sample(struct scene *scene, const char *path, const config_setting_t *at) MUST_USE;

/* A stage as read from `at`, under the path `where`, before what follows from its keys is filled in: its material, and
 * what moves its walls; `root`: of the scene, whose material and walls it takes over. */
enum status scene_check_material(const struct scene *scene, const struct scene_stage *stage, const config_setting_t *at,
                                 const char *where) MUST_USE;
enum status scene_check_walls(const struct scene *scene, const struct scene_stage *stage, const config_setting_t *root,
                              const config_setting_t *at, const char *where) MUST_USE;

/* The complete stage: length, frames, conditions. */
enum status scene_check_stage(const struct scene_stage *stage, const config_setting_t *at, const char *where) MUST_USE;

/* Whether the paths and cycles of all stages fit into them. Of scenes that are to be run, not of records. */
enum status scene_check_paths(const struct scene *scene) MUST_USE;

/* Stage `index` against those before it: two must not write one checkpoint. */
enum status scene_check_name(const struct scene *scene, int64_t index, const config_setting_t *at,
                             const char *where) MUST_USE;

#endif
