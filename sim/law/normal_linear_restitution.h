/* Linear spring whose dashpot gives every pair the restitution e asked for: gamma_n = gamma + 2 zeta sqrt(k m_ij),
 * zeta as damping_ratio.h. */
#ifndef SHAKEDOWN_SIM_LAW_NORMAL_LINEAR_RESTITUTION_H
#define SHAKEDOWN_SIM_LAW_NORMAL_LINEAR_RESTITUTION_H

#include <math.h>

#include "sim/law/contact_law.h"
#include "sim/law/contact_model.h"
#include "sim/law/damping_ratio.h"

enum { RESTITUTION_K, RESTITUTION_GAMMA, RESTITUTION_DAMPING };

enum { normal_linear_restitution_traits = NORMAL_PER_PAIR };

static inline void normal_linear_restitution_constants(const struct scene_material *material, double *constant)
{
    constant[RESTITUTION_K] = material->kn_n_per_m;
    constant[RESTITUTION_GAMMA] = material->gamma_n_kg_per_s;
    constant[RESTITUTION_DAMPING] = 2 * damping_ratio_of(material) * sqrt(material->kn_n_per_m);
}

static inline double normal_linear_restitution_stiffness(const double *constant, double radius_m, double force_n)
{
    (void)radius_m;
    (void)force_n;
    return constant[RESTITUTION_K];
}
#endif

#ifdef NORMAL_LANES
struct NAME(normal_law) {
    scalar k, gamma, damping, half_unit;
};

LANES_INLINE struct NAME(normal_law) NAME(normal_law_of)(const double *constant, const struct law_units *units)
{
    const double unit = units->length / units->force, damped = units->speed / units->force;
    return (struct NAME(normal_law)){.k = (scalar)(constant[RESTITUTION_K] * unit),
                                     .gamma = (scalar)(constant[RESTITUTION_GAMMA] * damped),
                                     .damping = (scalar)(constant[RESTITUTION_DAMPING] * damped),
                                     .half_unit = (scalar)(0.5 * units->length * units->force)};
}

#include "sim/law/normal_lossless_tmpl.h"
#include "sim/law/normal_memoryless_tmpl.h"

struct NAME(pair) {
    real elastic, gamma_n, stored;
};

LANES_INLINE struct NAME(pair)
    NAME(pair_of)(const struct NAME(normal_law) * law, real delta, real root_mass, real radius,
                  const struct NAME(normal_memory) * memory, struct NAME(normal_sums) * sums)
{
    struct NAME(pair) pair;
    (void)radius;
    (void)memory;
    (void)sums;
    pair.elastic = real_all(law->k) * delta;
    pair.gamma_n = real_fma(real_all(law->damping), root_mass, real_all(law->gamma));
    pair.stored = real_all(law->half_unit) * pair.elastic * delta;
    return pair;
}

LANES_INLINE real NAME(normal_friction_limit)(const struct NAME(normal_law) * law, real delta, real pressing)
{
    (void)law;
    (void)delta;
    return -pressing;
}
#endif
