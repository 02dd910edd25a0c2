/* prepare = { ... }: the stages that bring a sample to "dense" or "loose" at a pressure, or to a solid fraction.
 * Internal to common/scene*.c. */
#ifndef SHAKEDOWN_COMMON_SCENE_PREPARE_H
#define SHAKEDOWN_COMMON_SCENE_PREPARE_H

#include <libconfig.h>

#include "common/scene.h"

/* The stages as a scene would write them, "stages = ( ... );", from prepare in `root`; NULL in *text if the scene has
 * none. To be freed. STATUS_CONFIG for keys that do not fit each other, or the sample. */
enum status scene_prepare_text(const struct scene *scene, const config_setting_t *root, char **text) MUST_USE;

#endif
