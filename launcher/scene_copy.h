/* The copy of a scene, and of what the command line changes, that a run keeps. */
#ifndef SHAKEDOWN_LAUNCHER_SCENE_COPY_H
#define SHAKEDOWN_LAUNCHER_SCENE_COPY_H

#include "common/status.h"

/* Writes FOLDER/scene.cfg and FOLDER/overrides (one of the NULL ended `words` of the command line per line). Paths in a
 * scene are relative to its file, and the copy lies elsewhere: that of a checkpoint becomes absolute; tables of
 * grains and of sizes are copied too (FOLDER/grains.csv, FOLDER/sizes.csv), and the copied scene names the copies. All
 * else stays as it is, comments too. STATUS_CONFIG if a path cannot be found in the text, STATUS_USAGE for a word with
 * a line end, STATUS_IO. */
enum status scene_copy(const char *scene, const char *folder, char *const *words) MUST_USE;

#endif
