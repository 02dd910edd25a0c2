#include "common/course_shapes.h"

#include <math.h>

static const double PI = 3.14159265358979323846;

double course_table(const struct config_floats *times, const struct config_floats *values, double t_s, double *slope)
{
    int64_t k = 0;
    *slope = 0;
    while (k < times->count && t_s >= times->value[k])
        k++;
    if (k == times->count)
        return values->value[k - 1];
    *slope = (values->value[k] - values->value[k - 1]) / (times->value[k] - times->value[k - 1]);
    return values->value[k - 1] + *slope * (t_s - times->value[k - 1]);
}

double course_amplitude(const struct scene_axis *axis, double amplitude, double growth, double cycles)
{
    return growth != 0 ? amplitude + growth * floor(floor(cycles) / (double)axis->growth_cycles) : amplitude;
}

double course_cycle(bool triangle, bool two_way, double phase, double *slope)
{
    const double x = phase - floor(phase);
    if (!triangle) {
        *slope = two_way ? 2 * PI * cos(2 * PI * phase) : PI * sin(2 * PI * phase);
        return two_way ? sin(2 * PI * phase) : 0.5 * (1 - cos(2 * PI * phase));
    }
    if (!two_way) {
        *slope = x < 0.5 ? 2 : -2;
        return x < 0.5 ? 2 * x : 2 - 2 * x;
    }
    *slope = x < 0.25 || x >= 0.75 ? 4 : -4;
    return x < 0.25 ? 4 * x : x < 0.75 ? 2 - 4 * x : 4 * x - 4;
}
