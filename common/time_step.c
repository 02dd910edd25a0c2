#include "common/time_step.h"

#include <math.h>

static const double PI = 3.14159265358979323846;
static const double MEAN_STEPS = 20, SMALLEST_STEPS = 7, STABLE_STEPS = 3;

static double sphere_mass_kg(double density_kg_per_m3, double cubed_m3)
{
    return 4 * PI / 3 * density_kg_per_m3 * cubed_m3;
}

static double stable_s(double stiffness, double damping, double per_mass)
{
    const double omega2 = stiffness * per_mass, lambda = damping * per_mass;
    return 2 / (lambda + sqrt(lambda * lambda + omega2));
}

double time_step_auto_s(const struct scene_sample *sample, const struct scene_material *m)
{
    const double k = fmax(m->kn_n_per_m, m->k2_n_per_m), lo = sample->radius_min_m;
    const double mean_m = sample->mean_radius_m;
    if (!(k > 0))
        return 0;
    const double mean_kg = sphere_mass_kg(sample->density_kg_per_m3, sample->mean_cube_m3);
    const double smallest_kg = sphere_mass_kg(sample->density_kg_per_m3, lo * lo * lo);
    const double per_mass = (1 + fmin(1, lo / mean_m)) * (1 / smallest_kg + 1 / mean_kg);
    double step = fmin(PI * sqrt(mean_kg / (2 * k)) / MEAN_STEPS, PI * sqrt(smallest_kg / (2 * k)) / SMALLEST_STEPS);
    step = fmin(step, stable_s(k, m->gamma_n_kg_per_s, per_mass) / STABLE_STEPS);
    if (m->mu_s > 0) /* a sphere's surface moves as 2/7 of its mass */
        step = fmin(step, stable_s(m->kt_n_per_m, m->gamma_t_kg_per_s, 3.5 * per_mass) / STABLE_STEPS);
    return step;
}
