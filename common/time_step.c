#include "common/time_step.h"

#include <math.h>

static const double PI = 3.14159265358979323846;
static const double MEAN_STEPS = 20, SMALLEST_STEPS = 7, STABLE_STEPS = 3;

static double sphere_mass_kg(double density_kg_per_m3, double cubed_m3)
{
    return 4 * PI / 3 * density_kg_per_m3 * cubed_m3;
}

/* Means of radius and of its cube, of the distribution as it is drawn from; a cut Gaussian as if it were not cut. */
static void radius_moments(const struct scene_sample *s, double *mean_m, double *cubed_m3)
{
    const double lo = s->radius_min_m, hi = s->radius_max_m, sd = s->radius_sd_m;
    if (s->radius_distribution == RADIUS_GAUSSIAN) {
        *mean_m = s->radius_mean_m;
        *cubed_m3 = s->radius_mean_m * (s->radius_mean_m * s->radius_mean_m + 3 * sd * sd);
        return;
    }
    *mean_m = 0.5 * (lo + hi);
    *cubed_m3 = 0.25 * (lo + hi) * (lo * lo + hi * hi); /* (hi^4 - lo^4)/(4 (hi - lo)) */
}

static double stable_s(double stiffness, double damping, double per_mass)
{
    const double omega2 = stiffness * per_mass, lambda = damping * per_mass;
    return 2 / (lambda + sqrt(lambda * lambda + omega2));
}

double time_step_auto_s(const struct scene_sample *sample, const struct scene_material *m)
{
    const double k = fmax(m->kn_n_per_m, m->k2_n_per_m), lo = sample->radius_min_m;
    double mean_m, cubed_m3;
    if (!(k > 0))
        return 0;
    radius_moments(sample, &mean_m, &cubed_m3);
    const double mean_kg = sphere_mass_kg(sample->density_kg_per_m3, cubed_m3);
    const double smallest_kg = sphere_mass_kg(sample->density_kg_per_m3, lo * lo * lo);
    const double per_mass = (1 + fmin(1, lo / mean_m)) * (1 / smallest_kg + 1 / mean_kg);
    double step = fmin(PI * sqrt(mean_kg / (2 * k)) / MEAN_STEPS, PI * sqrt(smallest_kg / (2 * k)) / SMALLEST_STEPS);
    step = fmin(step, stable_s(k, m->gamma_n_kg_per_s, per_mass) / STABLE_STEPS);
    if (m->mu_s > 0) /* a sphere's surface moves as 2/7 of its mass */
        step = fmin(step, stable_s(m->kt_n_per_m, m->gamma_t_kg_per_s, 3.5 * per_mass) / STABLE_STEPS);
    return step;
}
