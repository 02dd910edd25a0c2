/* Linear spring, f = k delta [D eq. 1]. */
#ifndef SHAKEDOWN_SIM_LAW_NORMAL_LINEAR_H
#define SHAKEDOWN_SIM_LAW_NORMAL_LINEAR_H

#include "sim/law/contact_law.h"
#include "sim/law/contact_model.h"

enum { LINEAR_K };

enum { normal_linear_traits = 0 };

static inline void normal_linear_constants(const struct scene_material *material, double *constant)
{
    constant[LINEAR_K] = material->kn_n_per_m;
}

static inline double normal_linear_stiffness(const double *constant, double radius_m, double force_n)
{
    (void)radius_m;
    (void)force_n;
    return constant[LINEAR_K];
}
#endif

#ifdef NORMAL_LANES
struct NAME(normal_law) {
    scalar k;
};

LANES_INLINE struct NAME(normal_law) NAME(normal_law_of)(const double *constant, const struct law_units *units)
{
    const double unit = units->length / units->force;
    return (struct NAME(normal_law)){.k = (scalar)(constant[LINEAR_K] * unit)};
}

#include "sim/law/normal_lossless_tmpl.h"
#include "sim/law/normal_memoryless_tmpl.h"

LANES_INLINE real NAME(normal_elastic)(const struct NAME(normal_law) * law, real delta,
                                       const struct NAME(normal_memory) * memory, struct NAME(normal_sums) * sums)
{
    (void)memory;
    (void)sums;
    return real_all(law->k) * delta;
}

LANES_INLINE real NAME(normal_friction_limit)(const struct NAME(normal_law) * law, real delta, real pressing)
{
    (void)law;
    (void)delta;
    return -pressing;
}

LANES_INLINE real NAME(normal_energy)(const struct NAME(normal_law) * law, real delta, real elastic)
{
    (void)delta;
    return elastic * elastic / real_all(2 * law->k);
}
#endif
