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

LANES_INLINE struct NAME(normal_law) NAME(normal_law_of)(const double *constant, double unit)
{
    return (struct NAME(normal_law)){.k = (scalar)(constant[LINEAR_K] * unit)};
}

struct NAME(normal_memory) {
    char none;
};

struct NAME(normal_sums) {
    char none;
};

struct NAME(normal_totals) {
    char none;
};

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

LANES_INLINE struct NAME(normal_memory) NAME(normal_memory_at)(void *const *history, size_t slot)
{
    (void)history;
    (void)slot;
    return (struct NAME(normal_memory)){0};
}

LANES_INLINE void NAME(normal_sums_close)(struct NAME(normal_sums) * sums, struct NAME(normal_totals) * totals)
{
    (void)sums;
    (void)totals;
}

LANES_INLINE double NAME(normal_hysteresis_j)(const struct NAME(normal_totals) * totals, const double *constant,
                                              double unit)
{
    (void)totals;
    (void)constant;
    (void)unit;
    return 0;
}
#endif
