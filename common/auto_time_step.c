#include "common/auto_time_step.h"

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

double time_step_force_n(const struct scene *scene, const struct scene_stage *stage)
{
    const double d = 2 * scene->sample.mean_radius_m;
    double pressure_pa = 0;
    for (int k = 0; k < SCENE_AXES; k++) {
        const struct scene_axis *axis = &stage->axis[k];
        pressure_pa =
            fmax(pressure_pa, fmax(fabs(axis->pressure_pa) + fabs(axis->amplitude_pa), fabs(axis->pressure_end_pa)));
        for (int j = 0; j < axis->pressures_pa.count; j++)
            pressure_pa = fmax(pressure_pa, fabs(axis->pressures_pa.value[j]));
    }
    return 4 * pressure_pa * (scene->dimension == 2 ? d : d * d);
}

/* Damping over critical damping of a dashpot that gives the restitution, if the law has one. Without pull the exact one
 * is not needed (sim/law/damping_ratio.h): with e = exp(-2 z acos(z)/sqrt(1 - z^2)) it is below both -ln(e)/2 and
 * 1/(2 sqrt(e)). */
static double damping_ratio(const struct scene_material *m)
{
    if (m->law != LAW_LINEAR_RESTITUTION && m->law != LAW_HERTZ)
        return 0;
    const double loss = -log(m->restitution);
    return m->dashpot_pull == DASHPOT_PULL_NONE ? fmin(0.5 * loss, 0.5 / sqrt(m->restitution))
                                                : loss / sqrt(PI * PI + loss * loss);
}

/* The linear law that is as stiff and as damped (docs/theory.md), with all that stands beside the law: rolling and
 * torsion. */
static struct scene_material hertz_as_linear(const struct scene_sample *s, const struct scene_material *m,
                                             double force_n)
{
    const double nu = m->poisson_ratio, r = 0.5 * s->mean_radius_m;
    const double modulus = m->youngs_modulus_pa / (2 * (1 - nu * nu));
    const double shear = m->youngs_modulus_pa / (4 * (2 - nu) * (1 + nu));
    const double contact = force_n > 0 ? cbrt(0.75 * force_n * r / modulus) : sqrt(1e-3 * r * s->mean_radius_m);
    const double reduced_kg = 0.5 * sphere_mass_kg(s->density_kg_per_m3, s->mean_cube_m3);
    struct scene_material linear = *m;
    linear.law = LAW_LINEAR; /* its dashpot is a number below */
    linear.kn_n_per_m = 2 * modulus * contact;
    linear.kt_n_per_m = 8 * shear * contact;
    linear.gamma_n_kg_per_s = 2 * sqrt(5.0 / 6) * damping_ratio(m) * sqrt(linear.kn_n_per_m * reduced_kg);
    linear.gamma_t_kg_per_s = linear.gamma_n_kg_per_s * sqrt(linear.kt_n_per_m / linear.kn_n_per_m);
    return linear;
}

static double linear_step_s(const struct scene_sample *sample, const struct scene_material *m)
{
    const double k = fmax(fmax(m->kn_n_per_m, m->k2_n_per_m), m->kp_n_per_m), lo = sample->radius_min_m;
    const double mean_m = sample->mean_radius_m;
    if (!(k > 0))
        return 0;
    const double mean_kg = sphere_mass_kg(sample->density_kg_per_m3, sample->mean_cube_m3);
    const double smallest_kg = sphere_mass_kg(sample->density_kg_per_m3, lo * lo * lo);
    const double per_mass = (1 + fmin(1, lo / mean_m)) * (1 / smallest_kg + 1 / mean_kg);
    double step = fmin(PI * sqrt(mean_kg / (2 * k)) / MEAN_STEPS, PI * sqrt(smallest_kg / (2 * k)) / SMALLEST_STEPS);
    const double reduced_kg = 1 / (1 / smallest_kg + 1 / mean_kg);
    const double gamma = m->gamma_n_kg_per_s + 2 * damping_ratio(m) * sqrt(k * reduced_kg);
    step = fmin(step, stable_s(k, gamma, per_mass) / STABLE_STEPS);
    const double resists = (m->mu_rolling > 0 ? m->kr_n_per_m : 0) + (m->mu_torsion > 0 ? m->ko_n_per_m : 0),
                 slows = (m->mu_rolling > 0 ? m->gamma_r_kg_per_s : 0) +
                         (m->mu_torsion > 0 ? m->gamma_o_kg_per_s : 0); /* a^2/I = 2.5/m = (3.5/1.4)/m */
    if (m->mu_s > 0) /* a sphere's surface moves as 2/7 of its mass */
        step = fmin(step, stable_s(m->kt_n_per_m + resists / 1.4, m->gamma_t_kg_per_s + slows / 1.4, 3.5 * per_mass) /
                              STABLE_STEPS);
    return step;
}

double time_step_auto_s(const struct scene_sample *sample, const struct scene_material *material, double force_n)
{
    if (material->law != LAW_HERTZ || !(material->youngs_modulus_pa > 0))
        return linear_step_s(sample, material);
    const struct scene_material linear = hertz_as_linear(sample, material, force_n);
    return linear_step_s(sample, &linear);
}

double time_step_of_stage_s(const struct scene *scene, const struct scene_stage *stage)
{
    const double force_n = time_step_force_n(scene, stage);
    double step_s = time_step_auto_s(&scene->sample, &stage->material, force_n);
    for (int k = 0; k < SCENE_AXES; k++) {
        struct scene_material of_walls;
        if (scene_wall_material(stage, (enum axis)k, &of_walls))
            step_s = fmin(step_s, time_step_auto_s(&scene->sample, &of_walls, force_n));
    }
    return step_s;
}
