/* Walls as commands drive them: along a path, or by an impedance whose loop is closed here in every step. */
#ifndef SHAKEDOWN_SIM_SAMPLE_WALL_MOTION_H
#define SHAKEDOWN_SIM_SAMPLE_WALL_MOTION_H

#include "sim/sample/sample.h"

/* Puts a command that fits the current step in force. */
void walls_take_command(struct sample *sample, const struct wall_command *command);

/* Moves the walls to the current step, with their forces still those of the step before; true if one is too far from
 * where the lists were built. */
bool walls_move(struct sample *sample);

/* Driving force of an impedance [N], inward, `tau_s` after the command. */
double walls_driving_force_n(const struct wall_trajectory *path, int w, double tau_s);

/* Where wall w will be at the end of an interval that begins now, and its mean velocity over the interval in force; of
 * an impedance: as it moves now. */
double walls_end_position_m(const struct sample *sample, int w);
double walls_mean_velocity_m_per_s(const struct sample *sample, int w);

/* Upper bound of each wall's tangent stiffness, sum of k2, and damping, sum of gamma_n, over its contacts; [n_walls].
 */
void walls_stiffness(const struct sample *sample, double *stiffness_n_per_m, double *damping_kg_per_s);

#endif
