#include "sim/measure/step_limit.h"

#include <math.h>
#include <stdio.h>

#include "sim/law/damping_ratio.h"
#include "wallctl/control_law.h"

static const double PI = 3.14159265358979323846;

/* Solid fraction of a random close packing, of discs and of spheres. */
static const double PACKED[] = {0.84, 0.64};

struct grain_sizes {
    double lightest_kg, radius_m; /* and its radius */
    double mean_kg, mean_radius_m;
};

static struct grain_sizes sizes_of(const struct particles *p)
{
    struct grain_sizes sizes = {.lightest_kg = INFINITY};
    for (int i = 0; i < p->count; i++) {
        sizes.mean_kg += p->mass[i] / p->count;
        sizes.mean_radius_m += p->radius[i] / p->count;
        if (!(p->mass[i] < sizes.lightest_kg))
            continue;
        sizes.lightest_kg = p->mass[i];
        sizes.radius_m = p->radius[i];
    }
    return sizes;
}

/* omega2 = k/m [1/s^2], lambda = gamma/m [1/s]. */
static double stable_step_s(double omega2, double lambda)
{
    return 2 / (lambda + sqrt(lambda * lambda + omega2));
}

/* The longest step of a wall that all particles of a dense layer touch; 0: none holds. */
static double wall_step_s(const struct sample *sample, const struct scene_axis *axis, double contacts,
                          const struct contact_law_constants *law, double dt_s)
{
    const double k = contacts * law->stiffness, gamma = contacts * law->gamma_n;
    const struct scene_coupling single = {.scheme = SCHEME_HOLD, .interval_steps = 1};
    (void)sample;
    double holds = 0, fails = INFINITY, trial = dt_s;
    for (int k_try = 0; k_try < 60 && !(fails - holds < 0.01 * fails); k_try++) {
        if (wallctl_stable_steps(&single, axis, k, gamma, trial) >= 1)
            holds = trial;
        else
            fails = trial;
        trial = isfinite(fails) ? 0.5 * (holds + fails) : 2 * trial;
    }
    return isfinite(fails) ? holds : INFINITY;
}

static void walls_limit(const struct sample *sample, const struct scene_stage *stage,
                        const struct contact_law_constants *wall_law, double mean_radius_m, struct step_limit *limit)
{
    const int dim = sample->particles.dimension;
    const double volume = particles_solid_volume(&sample->particles) / PACKED[dim - 2];
    const double side = pow(volume, 1.0 / dim) / (2 * mean_radius_m);
    const double contacts = fmax(1, dim == 2 ? side : side * side);
    limit->wall_stable_s = INFINITY;
    for (int c = 0; c < dim; c++) {
        const enum axis name = sample_axis(sample, c);
        const struct scene_axis *axis = &stage->axis[name];
        const bool follows = axis->mode == WALL_COUPLED && axis->keep == KEEP_VOLUME;
        if ((axis->mode != WALL_STRESS && axis->mode != WALL_COUPLED) || follows)
            continue;
        const double holds = wall_step_s(sample, axis, contacts, &wall_law[c], stage->dt_s);
        if (!(holds < limit->wall_stable_s))
            continue;
        limit->wall_stable_s = holds;
        limit->wall_axis = "xyz"[name];
    }
}

static void take_shorter(double stable_s, bool tangential, char axis, struct step_limit *limit)
{
    if (!(stable_s < limit->stable_s))
        return;
    limit->stable_s = stable_s;
    limit->tangential = tangential;
    limit->contact_axis = axis;
}

/* Of particles among themselves, or (axis) on walls, which are counted like particles: their own spring, that of one
 * particle, but no motion. */
static void contacts_limit(const struct contact_law_constants *law, const struct scene_material *material,
                           const struct grain_sizes *sizes, char axis, struct step_limit *limit)
{
    const double contacts = 1 + fmin(1, sizes->radius_m / sizes->mean_radius_m);
    const double per_mass = contacts * (1 / sizes->lightest_kg + 1 / sizes->mean_kg);
    const double reduced_kg = 1 / (1 / sizes->lightest_kg + 1 / sizes->mean_kg);
    const bool asked = material->law == LAW_LINEAR_RESTITUTION || material->law == LAW_HERTZ;
    const double ratio = asked ? damping_ratio_of(material) : 0;
    const double gamma = law->gamma_n + 2 * ratio * sqrt(law->stiffness * reduced_kg);
    limit->contact_s = fmin(limit->contact_s, PI / sqrt(2 * law->stiffness / sizes->lightest_kg));
    take_shorter(stable_step_s(law->stiffness * per_mass, gamma * per_mass), false, axis, limit);
    if (law->mu_s > 0)
        take_shorter(stable_step_s((3.5 * law->kt + 2.5 * (law->rolling.k + law->torsion.k)) * per_mass,
                                   (3.5 * law->gamma_t + 2.5 * (law->rolling.gamma + law->torsion.gamma)) * per_mass),
                     true, axis, limit);
}

struct step_limit step_limit_of(const struct sample *sample, const struct scene_stage *stage)
{
    const struct grain_sizes sizes = sizes_of(&sample->particles);
    const int normal = sample->pairs.model.normal;
    struct step_limit limit = {.stable_s = INFINITY, .contact_s = INFINITY, .radius_m = sizes.radius_m};
    struct contact_law_constants law = contact_law_constants_of(&stage->material, normal), of_walls[3];
    contact_law_set_scale(&law, normal, sizes.radius_m, 0);
    contacts_limit(&law, &stage->material, &sizes, '\0', &limit);
    for (int c = 0; c < sample->particles.dimension; c++) {
        const enum axis axis = sample_axis(sample, c);
        struct scene_material material;
        of_walls[c] = contact_law_constants_of_walls(stage, axis, normal);
        contact_law_set_scale(&of_walls[c], normal, sizes.radius_m, 0);
        (void)scene_wall_material(stage, axis, &material);
        contacts_limit(&of_walls[c], &material, &sizes, "xyz"[axis], &limit);
    }
    walls_limit(sample, stage, of_walls, sizes.mean_radius_m, &limit);
    return limit;
}

enum status step_limit_check(const struct sample *sample)
{
    const struct scene *scene = sample->scene;
    for (int s = 0; s < scene->n_stages; s++) {
        const struct scene_stage *stage = &scene->stage[s];
        const struct step_limit limit = step_limit_of(sample, stage);
        if (stage->dt_s <= limit.stable_s)
            continue;
        char partner[32] = "", place[256];
        scene_stage_place(scene, stage, place, sizeof place);
        if (limit.contact_axis)
            snprintf(partner, sizeof partner, " with the walls in %c", limit.contact_axis);
        return status_fail(STATUS_CONFIG,
                           "%s: dt_s = %.3g s is too long for the %s contacts of the smallest particles%s "
                           "(radius %.3g m, t_c = %.2g s): they bear up to %.2g s; dt_s = \"auto\" is accurate",
                           place, stage->dt_s, limit.tangential ? "tangential" : "normal", partner, limit.radius_m,
                           limit.contact_s, limit.stable_s);
    }
    return STATUS_OK;
}
