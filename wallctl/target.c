#include "wallctl/target.h"

#include <math.h>

static const double PI = 3.14159265358979323846;

double wallctl_target_pressure_pa(const struct scene_axis *axis, double t_s)
{
    switch (axis->target) {
    case TARGET_RAMP:
        if (t_s >= axis->ramp_s)
            return axis->pressure_end_pa;
        return axis->pressure_pa + (axis->pressure_end_pa - axis->pressure_pa) * (t_s / axis->ramp_s);
    case TARGET_COSINE:
        return axis->pressure_pa + 0.5 * axis->amplitude_pa * (1 - cos(2 * PI * t_s / axis->period_s));
    default:
        return axis->pressure_pa;
    }
}

/* Phase omega t of the strain path; pi from its end on. */
static double strain_phase(const struct scene_axis *axis, double t_s)
{
    return fmin(PI, 2 * PI * axis->frequency_hz * t_s);
}

bool wallctl_strain_done(const struct scene_axis *axis, double t_s)
{
    return strain_phase(axis, t_s) >= PI;
}

double wallctl_strain_length_m(const struct scene_axis *axis, double z0_m, double t_s)
{
    double zf_m = z0_m * (1 - axis->strain);
    double phase = strain_phase(axis, t_s);
    if (phase >= PI)
        return zf_m;
    return zf_m + 0.5 * (z0_m - zf_m) * (1 + cos(phase));
}

double wallctl_strain_rate_m_per_s(const struct scene_axis *axis, double z0_m, double t_s)
{
    double phase = strain_phase(axis, t_s);
    if (phase >= PI)
        return 0;
    return -0.5 * z0_m * axis->strain * (2 * PI * axis->frequency_hz) * sin(phase);
}
