/* The copy of a scene, and of what the command line changes, that a run keeps. */
#ifndef SHAKEDOWN_LAUNCHER_SCENE_COPY_H
#define SHAKEDOWN_LAUNCHER_SCENE_COPY_H

#include "common/status.h"

/* Writes FOLDER/scene.cfg and FOLDER/overrides (one of the NULL ended `words` of the command line per line). The path
 * of the checkpoint that a sample comes from is relative to the scene's file: it becomes absolute, as the copy lies
 * elsewhere. All else stays as it is, comments too. STATUS_CONFIG if the path cannot be found in the text,
 * STATUS_USAGE for a word with a line end. */
enum status scene_copy(const char *scene, const char *folder, char *const *words) MUST_USE;

#endif
