#include "common/pressure_target.h"

#include <math.h>

#include "common/course_shapes.h"

static const double PI = 3.14159265358979323846;

static double cycle_pressure_pa(const struct scene_axis *axis, double t_s)
{
    const double cycles = t_s / axis->period_s;
    const double amplitude_pa = course_amplitude(axis, axis->amplitude_pa, axis->amplitude_growth_pa, cycles);
    double slope;
    if (axis->target == TARGET_COSINE && !axis->two_way)
        return axis->pressure_pa + 0.5 * amplitude_pa * (1 - cos(2 * PI * t_s / axis->period_s));
    const double shape = course_cycle(axis->target == TARGET_TRIANGLE, axis->two_way, cycles, &slope);
    return axis->pressure_pa + (axis->two_way ? 0.5 : 1) * amplitude_pa * shape;
}

double pressure_target_pa(const struct scene_axis *axis, double t_s)
{
    double slope;
    switch (axis->target) {
    case TARGET_RAMP:
        if (t_s >= axis->ramp_s)
            return axis->pressure_end_pa;
        return axis->pressure_pa + (axis->pressure_end_pa - axis->pressure_pa) * (t_s / axis->ramp_s);
    case TARGET_COSINE:
    case TARGET_TRIANGLE:
        return cycle_pressure_pa(axis, t_s);
    case TARGET_TABLE:
        return course_table(&axis->times_s, &axis->pressures_pa, t_s, &slope);
    default:
        return axis->pressure_pa;
    }
}
