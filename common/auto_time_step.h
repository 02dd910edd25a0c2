/* The time step that a scene's own numbers ask for. */
#ifndef SHAKEDOWN_COMMON_AUTO_TIME_STEP_H
#define SHAKEDOWN_COMMON_AUTO_TIME_STEP_H

#include "common/scene.h"

/* dt_s = "auto" [s]: a twentieth of the contact time of two particles of the mean mass of the distribution, at most a
 * seventh of that of two of the smallest ones, t_c = pi sqrt(m/(2 k)) with the stiffest k of the stage's material; and
 * at most a third of what is stable with its dashpots, of rolling and torsion too (docs/verdict.md). From the scene
 * alone, so that every program that reads it takes the same. 0 if the material has no stiffness. Hertz-Mindlin: k and
 * dashpots of two mean particles under `force_n`, or, if that is 0, at an overlap of 0.1 % of the radius. */
double time_step_auto_s(const struct scene_sample *sample, const struct scene_material *material, double force_n);

/* Four times the mean force of contacts under the largest pressure of a stage: 4 p d^2, in 2D 4 p d (depth 1 m); 0:
 * none is given. */
double time_step_force_n(const struct scene *scene, const struct scene_stage *stage);

/* The least of time_step_auto_s over the stage's material and those of its walls, under time_step_force_n: what dt_s =
 * "auto" stands for. */
double time_step_of_stage_s(const struct scene *scene, const struct scene_stage *stage);

#endif
