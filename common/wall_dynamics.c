#include "common/wall_dynamics.h"

#include <float.h>
#include <math.h>

double wall_velocity_after(double mass_kg, double damping_kg_per_s, double t_s, double velocity_m_per_s, double net_n)
{
    if (!(mass_kg > 0))
        return net_n / damping_kg_per_s;
    double x = damping_kg_per_s * t_s / mass_kg;
    if (x < 0.25 * DBL_EPSILON) /* the limit, to the last bit; below, gamma may be too small to divide by */
        return velocity_m_per_s + net_n * t_s / mass_kg;
    return exp(-x) * velocity_m_per_s - expm1(-x) / damping_kg_per_s * net_n;
}

struct wall_motion wall_motion_step(double mass_kg, double damping_kg_per_s, double last_interval_s, double interval_s,
                                    double last_m_per_s, double net_n)
{
    double apart_s = 0.5 * (last_interval_s + interval_s);
    double velocity = wall_velocity_after(mass_kg, damping_kg_per_s, apart_s, last_m_per_s, net_n);
    double acceleration = (velocity - last_m_per_s) / apart_s;
    return (struct wall_motion){velocity - 0.5 * acceleration * interval_s, acceleration};
}
