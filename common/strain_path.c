#include "common/strain_path.h"

#include <math.h>

#include "common/course_shapes.h"

static const double PI = 3.14159265358979323846;

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
        return course_table(&axis->times_s, &axis->strains, t_s, rate_per_s);
    if (axis->course == COURSE_RATE)
        return rate_strain(axis, t_s, rate_per_s);
    const double f = axis->frequency_hz;
    const double amplitude = course_amplitude(axis, axis->strain, axis->strain_growth, t_s * f);
    double slope;
    const double shape = course_cycle(axis->course == COURSE_TRIANGLE, axis->two_way, t_s * f, &slope);
    *rate_per_s = amplitude * slope * f;
    return amplitude * shape;
}

bool strain_path_done(const struct scene_axis *axis, double t_s)
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

double strain_path_length_m(const struct scene_axis *axis, double z0_m, double t_s)
{
    double zf_m = z0_m * (1 - axis->strain), rate_per_s;
    if (axis->course == COURSE_RATE && strain_path_done(axis, t_s))
        return zf_m;
    if (axis->course != COURSE_SMOOTH)
        return z0_m * (1 - course_strain(axis, t_s, &rate_per_s));
    double phase = smooth_phase(axis, t_s);
    if (phase >= PI)
        return zf_m;
    return zf_m + 0.5 * (z0_m - zf_m) * (1 + cos(phase));
}

double strain_path_rate_m_per_s(const struct scene_axis *axis, double z0_m, double t_s)
{
    double rate_per_s;
    if (strain_path_done(axis, t_s))
        return 0;
    if (axis->course != COURSE_SMOOTH) {
        (void)course_strain(axis, t_s, &rate_per_s);
        return -z0_m * rate_per_s;
    }
    return -0.5 * z0_m * axis->strain * (2 * PI * axis->frequency_hz) * sin(smooth_phase(axis, t_s));
}
