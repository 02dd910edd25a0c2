/* What the walls of an axis are to do over the time of a stage: pressures and strain paths. */
#ifndef SHAKEDOWN_COMMON_WALL_TARGET_H
#define SHAKEDOWN_COMMON_WALL_TARGET_H

#include "common/scene.h"

/* Target pressure of a stress-controlled axis, or of one that keeps p, at time t in its stage [N/m^2]. */
double wall_target_pressure_pa(const struct scene_axis *axis, double t_s);

/* Course of a strain-controlled axis (smooth: [LH eq. 1.1]): length z(t) [m] of an axis of length z0 at t = 0, its rate
 * [m/s], and whether it has come to its end. */
double wall_course_length_m(const struct scene_axis *axis, double z0_m, double t_s);
double wall_course_rate_m_per_s(const struct scene_axis *axis, double z0_m, double t_s);
bool wall_course_done(const struct scene_axis *axis, double t_s);

#endif
