/* Scene files: reading and checking. */
#ifndef SHAKEDOWN_COMMON_SCENE_FILE_H
#define SHAKEDOWN_COMMON_SCENE_FILE_H

#include "common/scene.h"

/* Reads a scene file, applies `n_overrides` assignments "path=value", checks it. `scene` is large: allocate it.
 * Numbers are taken exactly or refused (common/config_literals.h). Errors: STATUS_IO (no such file), STATUS_CONFIG
 * ("file:line: key: what is wrong; what is allowed"). */
enum status scene_load(struct scene *scene, const char *path, const char *const *overrides, int n_overrides) MUST_USE;

/* The same from a text, e.g. the effective configuration of a recorded run; `name` stands for the file in errors. */
enum status scene_parse(struct scene *scene, const char *text, const char *name) MUST_USE;

#endif
