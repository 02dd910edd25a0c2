/* Shapes that strain paths and pressure targets have in common: tables, cycles, growing amplitudes. */
#ifndef SHAKEDOWN_COMMON_COURSE_SHAPES_H
#define SHAKEDOWN_COMMON_COURSE_SHAPES_H

#include "common/scene.h"

/* Straight lines between the points of a table, the last value after them; `slope`: of the line that goes on at t. */
double course_table(const struct config_floats *times, const struct config_floats *values, double t_s, double *slope);

/* The amplitude after so many cycles: grows by `growth` every growth_cycles. */
double course_amplitude(const struct scene_axis *axis, double amplitude, double growth, double cycles);

/* A cycle of unit amplitude at `phase`, in cycles: 0 to 1 and back; two-way: 0 to 1, to -1, and back. `slope`: its
 * derivative by the phase. */
double course_cycle(bool triangle, bool two_way, double phase, double *slope);

#endif
