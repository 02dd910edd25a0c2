/* The time step that a scene's own numbers ask for. */
#ifndef SHAKEDOWN_COMMON_TIME_STEP_H
#define SHAKEDOWN_COMMON_TIME_STEP_H

#include "common/scene.h"

/* dt_s = "auto" [s]: a twentieth of the contact time of two particles of the mean mass of the distribution, at most a
 * seventh of that of two of the smallest ones, t_c = pi sqrt(m/(2 k)) with the stiffest k of the stage's material; and
 * at most a third of what is stable with its dashpots (docs/verdict.md). From the scene alone, so that every program
 * that reads it takes the same. 0 if the material has no stiffness. */
double time_step_auto_s(const struct scene_sample *sample, const struct scene_material *material);

#endif
