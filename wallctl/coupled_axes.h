/* Axes that follow the others: stresses that keep p, b or a straight path, lengths that keep the volume. Internal to
 * the law. */
#ifndef SHAKEDOWN_WALLCTL_COUPLED_AXES_H
#define SHAKEDOWN_WALLCTL_COUPLED_AXES_H

#include "common/coupling.h"
#include "common/scene.h"
#include "common/status.h"

/* Area [m^2] of the walls of a pair: the product of the other box lengths; 2D has a depth of 1 m. */
double walls_area_m2(const struct wall_state *state, int pair);

/* Stress of a pair of walls: mean of both forces over their area [N/m^2]. */
double walls_stress_pa(const struct wall_state *state, int pair);

/* p, the mean of all stresses, and q = sigma_zz - mean of the lateral ones [N/m^2]. */
double walls_mean_stress_pa(const struct wall_state *state);
double walls_deviator_pa(const struct wall_state *state);

/* Whether an axis is moved by a loop around its stress, or for the volume. */
bool axis_has_loop(const struct scene_axis *axis);
bool axis_keeps_volume(const struct scene_axis *axis);

/* target_pa [pairs]: of stress control its target at `t_s` in the stage; of coupled axes what follows from the stresses
 * of the others as they are at `state`; of all others their stress. STATUS_CONFIG if nothing follows from them. */
enum status coupled_targets(const struct scene *scene, const struct scene_stage *stage, const struct wall_state *state,
                            double t_s, double target_pa[SCENE_AXES]) MUST_USE;

/* Length of a pair that keeps the volume of the start of the stage, and its rate, when the other pairs have the lengths
 * `length_m` and rates `rate_m_per_s`; all [pairs], `start_m` at the start. Two such pairs are stretched alike. */
struct coupled_length {
    double length_m, rate_m_per_s;
};
struct coupled_length coupled_length(const bool *keeps_volume, int pairs, int pair, const double *start_m,
                                     const double *length_m, const double *rate_m_per_s);

#endif
