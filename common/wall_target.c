#include "common/wall_target.h"

#include <math.h>

static const double PI = 3.14159265358979323846;

/* Straight lines between the points of a table, the last value after them; `slope`: of the line that goes on at t. */
static double table_value(const struct config_floats *times, const struct config_floats *values, double t_s,
                          double *slope)
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

/* Amplitude at t: grows by `growth` every growth_cycles. */
static double amplitude_at(const struct scene_axis *axis, double amplitude, double growth, double cycles)
{
    return growth != 0 ? amplitude + growth * floor(floor(cycles) / (double)axis->growth_cycles) : amplitude;
}

/* A cycle of unit amplitude at `phase`, in cycles: 0 to 1 and back; two-way: 0 to 1, to -1, and back. `slope`: its
 * derivative by the phase. */
static double cycle_shape(bool triangle, bool two_way, double phase, double *slope)
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

static double cycle_pressure_pa(const struct scene_axis *axis, double t_s)
{
    const double cycles = t_s / axis->period_s;
    const double amplitude_pa = amplitude_at(axis, axis->amplitude_pa, axis->amplitude_growth_pa, cycles);
    double slope;
    if (axis->target == TARGET_COSINE && !axis->two_way)
        return axis->pressure_pa + 0.5 * amplitude_pa * (1 - cos(2 * PI * t_s / axis->period_s));
    const double shape = cycle_shape(axis->target == TARGET_TRIANGLE, axis->two_way, cycles, &slope);
    return axis->pressure_pa + (axis->two_way ? 0.5 : 1) * amplitude_pa * shape;
}

double wall_target_pressure_pa(const struct scene_axis *axis, double t_s)
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
        return table_value(&axis->times_s, &axis->pressures_pa, t_s, &slope);
    default:
        return axis->pressure_pa;
    }
}

/* Phase omega t of the smooth course; pi from its end on. */
static double smooth_phase(const struct scene_axis *axis, double t_s)
{
    return fmin(PI, 2 * PI * axis->frequency_hz * t_s);
}

/* Strain at a rate that rises to its value, and its rate. */
static double rate_strain(const struct scene_axis *axis, double t_s, double *rate_per_s)
{
    const double r = axis->rate_per_s, rise_s = axis->rise_s;
    *rate_per_s = t_s < rise_s ? r * (t_s / rise_s) : r;
    return t_s < rise_s ? 0.5 * r * t_s * (t_s / rise_s) : r * (t_s - 0.5 * rise_s);
}

/* e(t) and its rate of any course but the smooth one. */
static double course_strain(const struct scene_axis *axis, double t_s, double *rate_per_s)
{
    if (axis->course == COURSE_TABLE)
        return table_value(&axis->times_s, &axis->strains, t_s, rate_per_s);
    if (axis->course == COURSE_RATE)
        return rate_strain(axis, t_s, rate_per_s);
    const double f = axis->frequency_hz;
    const double amplitude = amplitude_at(axis, axis->strain, axis->strain_growth, t_s * f);
    double slope;
    const double shape = cycle_shape(axis->course == COURSE_TRIANGLE, axis->two_way, t_s * f, &slope);
    *rate_per_s = amplitude * slope * f;
    return amplitude * shape;
}

bool wall_course_done(const struct scene_axis *axis, double t_s)
{
    switch (axis->course) {
    case COURSE_SMOOTH:
        return smooth_phase(axis, t_s) >= PI;
    case COURSE_RATE:
        return axis->strain != 0 && t_s >= scene_axis_rate_end_s(axis);
    case COURSE_TABLE:
        return t_s >= axis->times_s.value[axis->times_s.count - 1];
    default:
        return false;
    }
}

double wall_course_length_m(const struct scene_axis *axis, double z0_m, double t_s)
{
    double zf_m = z0_m * (1 - axis->strain), rate_per_s;
    if (axis->course == COURSE_RATE && wall_course_done(axis, t_s))
        return zf_m;
    if (axis->course != COURSE_SMOOTH)
        return z0_m * (1 - course_strain(axis, t_s, &rate_per_s));
    double phase = smooth_phase(axis, t_s);
    if (phase >= PI)
        return zf_m;
    return zf_m + 0.5 * (z0_m - zf_m) * (1 + cos(phase));
}

double wall_course_rate_m_per_s(const struct scene_axis *axis, double z0_m, double t_s)
{
    double rate_per_s;
    if (wall_course_done(axis, t_s))
        return 0;
    if (axis->course != COURSE_SMOOTH) {
        (void)course_strain(axis, t_s, &rate_per_s);
        return -z0_m * rate_per_s;
    }
    return -0.5 * z0_m * axis->strain * (2 * PI * axis->frequency_hz) * sin(smooth_phase(axis, t_s));
}
