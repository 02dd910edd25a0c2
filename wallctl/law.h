/* The control law of the walls and the protocol of stages, without a bus: state in, command out, nothing kept.
 * The same function runs in wallctl and inside `sim --in-process`, and must give the same bits. */
#ifndef SHAKEDOWN_WALLCTL_LAW_H
#define SHAKEDOWN_WALLCTL_LAW_H

#include "common/coupling.h"
#include "common/scene.h"
#include "common/status.h"

/* The command that answers `state` under `scene`. Pure: the same input gives the same bits.
 * STATUS_FORMAT if the state does not fit the scene (number of walls, stage index, not finite). */
enum status wallctl_law(const struct scene *scene, const struct wall_state *state, struct wall_command *command) MUST_USE;

/* Target pressure of a stress-controlled axis at time t in its stage [N/m^2]. */
double wallctl_target_pressure_pa(const struct scene_axis *axis, double t_s);

/* Strain path [LH eq. 1.1]: length z(t) [m] of an axis of length z0 at t = 0, and its rate [m/s]. */
double wallctl_strain_length_m(const struct scene_axis *axis, double z0_m, double t_s);
double wallctl_strain_rate_m_per_s(const struct scene_axis *axis, double z0_m, double t_s);

#endif
