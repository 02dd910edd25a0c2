/* What the tests of the control law and of wallctl share: a small scene, and a stand-in for sim that moves walls as
 * commanded and lets springs push on them. */
#ifndef SHAKEDOWN_TESTS_WALL_FIXTURE_H
#define SHAKEDOWN_TESTS_WALL_FIXTURE_H

#include "common/coupling.h"
#include "common/scene.h"

/* A scene of one stage "a", dt 1 ms, 1 s long, all walls fixed, with material and sample filled in: tests set the rest
 * in the struct. Allocated; fixture_scene_free releases it. Fails the test if the text does not parse. */
struct scene *fixture_scene(int dimension);
void fixture_scene_free(struct scene *scene);

/* The text of a scene for the process: 2D, strain in z, pressure cycles in x, three stages, n = interval_steps. */
const char *fixture_scene_text(void);

/* Walls at rest before the first command; the box is [0, length_m] on every axis. */
struct wall_state fixture_state(int n_walls, double length_m);

/* Carries out `command`: the state at step + n_steps. Forces are left as they are. */
void fixture_advance(const struct scene *scene, const struct wall_command *command, struct wall_state *state);

/* Outward forces of springs of stiffness k that are unstretched at the box [0, length_m]. */
void fixture_springs(struct wall_state *state, double k_n_per_m, double length_m);

#endif
