/* The strain path of a strain-controlled axis over the time of a stage: smooth [LH eq. 1.1], at a rate, cycles, table.
 */
#ifndef SHAKEDOWN_COMMON_STRAIN_PATH_H
#define SHAKEDOWN_COMMON_STRAIN_PATH_H

#include "common/scene.h"

/* Length z(t) [m] of an axis of length z0 at t = 0, its rate [m/s], and whether the path has come to its end. */
double strain_path_length_m(const struct scene_axis *axis, double z0_m, double t_s);
double strain_path_rate_m_per_s(const struct scene_axis *axis, double z0_m, double t_s);
bool strain_path_done(const struct scene_axis *axis, double t_s);

#endif
