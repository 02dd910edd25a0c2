/* Walls as commands drive them: along a path, or by an impedance whose loop is closed here in every step. */
#ifndef SHAKEDOWN_SIM_DRIVE_H
#define SHAKEDOWN_SIM_DRIVE_H

#include "sim/world.h"

/* Puts a command that fits the current step in force. */
void drive_command(struct world *world, const struct wall_command *command);

/* Moves the walls to the current step, with their forces still those of the step before; true if one is too far from
 * where the lists were built. */
bool drive_walls(struct world *world);

/* Driving force of an impedance [N], inward, `tau_s` after the command. */
double drive_force_n(const struct wall_path *path, int w, double tau_s);

/* Where wall w will be at the end of an interval that begins now, and its mean velocity over the interval in force; of
 * an impedance: as it moves now. */
double drive_end_position_m(const struct world *world, int w);
double drive_mean_velocity_m_per_s(const struct world *world, int w);

#endif
