/* The control law of the walls and the protocol of stages, without a bus: state in, command out, nothing kept.
 * The same function runs in wallctl and inside `sim --in-process`, and must give the same bits. */
#ifndef SHAKEDOWN_WALLCTL_CONTROL_LAW_H
#define SHAKEDOWN_WALLCTL_CONTROL_LAW_H

#include "common/coupling.h"
#include "common/scene.h"
#include "common/status.h"

/* The command that answers `state` under `scene`. Pure: the same input gives the same bits. Time in the stage is
 * stage_step * dt_s, so that it does not depend on how the sender adds it up.
 * Strain control [LH eq. 1.1]: ends every interval on the path; `opposite`: the lower wall rests or takes half.
 * Stress control [LH eq. 1.2]: m dv/dt = F - p A - gamma v, v the outward velocity, from the middle of the last
 * interval to the middle of the next, T apart (the damping exactly integrated): v+ = exp(-gamma T/m) v- + (1 -
 * exp(-gamma T/m))/gamma (F - p A); v+ is the mean velocity over the next interval. Mirrored walls are one degree of
 * freedom of that mass and damping with the mean of both forces; opposite "constant" is a wall of its own at
 * pressure_pa. A stage ends after duration_s/dt_s steps, or when all its conditions hold; then the command begins the
 * next one. STATUS_FORMAT if the state does not fit the scene (number of walls, stage index, not finite, walls
 * crossed), STATUS_UNSTABLE if no finite command follows. */
enum status wallctl_law(const struct scene *scene, const struct wall_state *state,
                        struct wall_command *command) MUST_USE;

/* The longest exchange interval [steps] at which the scheme of `coupling` (for an impedance: hold) is stable for a
 * stress-controlled wall of `axis` on contacts of that stiffness and damping: at most the interval asked for (hold), or
 * half of it, rounded up; 0 if even a single step of dt_s is not. */
int wallctl_stable_steps(const struct scene_coupling *coupling, const struct scene_axis *axis, double stiffness_n_per_m,
                         double damping_kg_per_s, double dt_s);

#endif
