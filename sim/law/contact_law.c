#include "sim/law/contact_law.h"

#include <math.h>

#define MODEL_TEXT "sim/law/normal_constants.h"
#include "sim/law/for_each_model.h"

struct normal_functions {
    void (*constants)(const struct scene_material *material, double *constant);
    double (*stiffness)(const double *constant, double radius_m, double force_n);
    int traits;
};

static const struct normal_functions normal_functions[LAW_COUNT] = {
#define FUNCTIONS(name, NAME) {normal_##name##_constants, normal_##name##_stiffness, normal_##name##_traits},
    CONTACT_LAWS(FUNCTIONS)
#undef FUNCTIONS
};

static struct contact_resistance resistance_of(double mu, double k, double gamma)
{
    if (!(mu > 0 && k > 0))
        return (struct contact_resistance){0};
    return (struct contact_resistance){mu, k, 1 / k, gamma};
}

struct contact_law_constants contact_law_constants_of(const struct scene_material *m, int normal)
{
    const bool rough = m->mu_s > 0, mindlin = normal_functions[normal].traits & NORMAL_MINDLIN;
    const double kt = rough ? m->kt_n_per_m : 0;
    struct contact_law_constants law = {
        .gamma_n = m->gamma_n_kg_per_s,
        .mu_s = m->mu_s,
        .mu_d = m->mu_d,
        .kt = kt,
        .inv_kt = kt > 0 ? 1 / kt : 0,
        .gamma_t = rough ? m->gamma_t_kg_per_s : 0,
        .rolling = resistance_of(rough ? m->mu_rolling : 0, m->kr_n_per_m, m->gamma_r_kg_per_s),
        .torsion = resistance_of(rough ? m->mu_torsion : 0, m->ko_n_per_m, m->gamma_o_kg_per_s),
        .no_pull = m->dashpot_pull == DASHPOT_PULL_NONE,
        .elastic_limit = m->friction_limit == FRICTION_LIMIT_ELASTIC,
        .springs = rough && (mindlin || kt > 0),
    };
    law.normal[NORMAL_CONSTANTS_MAX - 1] = m->gamma_n_kg_per_s;
    normal_functions[normal].constants(m, law.normal);
    contact_law_set_scale(&law, normal, 0, 0);
    return law;
}

/* E and nu of two like bodies whose contact has the E* and G* of one between `a` and `b`. With e = (1 - nu^2)/E and g
 * = 2 (2 - nu)(1 + nu)/E of each, sum e = 1/E* and sum g = 1/G*; of like bodies e/g = (1 - nu)/(2 (2 - nu)). */
static void combine_elastic(const struct scene_material *a, const struct scene_material *b, struct scene_material *both)
{
    const struct scene_material *side[] = {a, b};
    double e = 0, g = 0;
    for (int k = 0; k < 2; k++) {
        const double nu = side[k]->poisson_ratio, young = side[k]->youngs_modulus_pa;
        e += (1 - nu * nu) / young;
        g += 2 * (2 - nu) * (1 + nu) / young;
    }
    both->poisson_ratio = (1 - 4 * e / g) / (1 - 2 * e / g);
    both->youngs_modulus_pa = 2 * (1 - both->poisson_ratio * both->poisson_ratio) / e;
}

struct contact_law_constants contact_law_constants_of_walls(const struct scene_stage *stage, enum axis axis, int normal)
{
    struct scene_material of_walls, both;
    if (!scene_wall_material(stage, axis, &of_walls)) {
        struct contact_law_constants law = contact_law_constants_of(&stage->material, normal);
        law.mu_s *= stage->material.wall_friction;
        law.mu_d *= stage->material.wall_friction;
        return law;
    }
    both = of_walls;
    if (of_walls.youngs_modulus_pa > 0)
        combine_elastic(&stage->material, &of_walls, &both);
    return contact_law_constants_of(&both, normal);
}

void contact_law_set_scale(struct contact_law_constants *law, int normal, double radius_m, double force_n)
{
    const double small = 0x1p-40; /* overlap over radius, about 1e-12 */
    int exponent = 0;
    law->stiffness = normal_functions[normal].stiffness(law->normal, radius_m, force_n);
    if (law->stiffness * radius_m > 0)
        (void)frexp(law->stiffness * radius_m * small, &exponent);
    law->per_force = ldexp(1, -exponent);
}

int contact_law_traits(int normal)
{
    return normal_functions[normal].traits;
}

void contact_losses_add(struct contact_losses *sum, const struct contact_losses *lost)
{
    sum->hysteresis += lost->hysteresis;
    sum->viscous_normal += lost->viscous_normal;
    sum->viscous_tangential += lost->viscous_tangential;
    sum->friction += lost->friction;
    sum->stiffness += lost->stiffness;
    sum->rolling += lost->rolling;
    sum->viscous_rolling += lost->viscous_rolling;
}
