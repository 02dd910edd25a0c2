/* The pressure that a stress-controlled axis is to have over the time of a stage: constant, ramp, cycles, table. */
#ifndef SHAKEDOWN_COMMON_PRESSURE_TARGET_H
#define SHAKEDOWN_COMMON_PRESSURE_TARGET_H

#include "common/scene.h"

/* Target pressure of a stress-controlled axis, or of one that keeps p, at time t in its stage [N/m^2]. */
double pressure_target_pa(const struct scene_axis *axis, double t_s);

#endif
