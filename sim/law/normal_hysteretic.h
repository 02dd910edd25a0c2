/* Linear hysteretic law with cohesion [LH eq. 1.6]: loading k1 delta, un- and reloading k2 (delta - delta_0), adhesion
 * branch -kc delta. k1 = k2 and kc = 0 give exactly the linear law. */
#ifndef SHAKEDOWN_SIM_LAW_NORMAL_HYSTERETIC_H
#define SHAKEDOWN_SIM_LAW_NORMAL_HYSTERETIC_H

#include "sim/law/contact_law.h"
#include "sim/law/contact_model.h"

enum {
    HYSTERETIC_K2,
    HYSTERETIC_KC,
    HYSTERETIC_K2_MINUS_K1,   /* k2 delta_0 = (k2 - k1) delta_max */
    HYSTERETIC_BRANCH_RATIO,  /* on the adhesion branch delta_max = branch_ratio delta; 0 if k1 = k2 */
    HYSTERETIC_LOADING_LOSS,  /* hysteresis loss per increase of delta_max^2: k1 (1 - k1/k2) / 2 */
    HYSTERETIC_ADHESION_LOSS, /* and per decrease: kc (1 + kc/k2) ((k2 - k1)/(k2 + kc))^2 / 2 */
};

enum { normal_hysteretic_traits = NORMAL_REMEMBERS_OVERLAP };

static inline void normal_hysteretic_constants(const struct scene_material *material, double *constant)
{
    const bool linear = material->law == LAW_LINEAR;
    const double k1 = linear ? material->kn_n_per_m : material->k1_n_per_m,
                 k2 = linear ? material->kn_n_per_m : material->k2_n_per_m, kc = linear ? 0 : material->kc_n_per_m;
    const double delta_min_ratio = (k2 - k1) / (k2 + kc); /* delta_min = ratio delta_max [LH] */
    constant[HYSTERETIC_K2] = k2;
    constant[HYSTERETIC_KC] = kc;
    constant[HYSTERETIC_K2_MINUS_K1] = k2 - k1;
    constant[HYSTERETIC_BRANCH_RATIO] = k2 - k1 > 0 ? (k2 + kc) / (k2 - k1) : 0;
    constant[HYSTERETIC_LOADING_LOSS] = 0.5 * k1 * (1 - k1 / k2);
    constant[HYSTERETIC_ADHESION_LOSS] = 0.5 * kc * (1 + kc / k2) * delta_min_ratio * delta_min_ratio;
}

static inline double normal_hysteretic_stiffness(const double *constant, double radius_m, double force_n)
{
    (void)radius_m;
    (void)force_n;
    return constant[HYSTERETIC_K2];
}
#endif

#ifdef NORMAL_LANES
struct NAME(normal_law) {
    scalar k2, kc, k2_minus_k1, branch_ratio;
};

LANES_INLINE struct NAME(normal_law) NAME(normal_law_of)(const double *constant, const struct law_units *units)
{
    const double unit = units->length / units->force;
    return (struct NAME(normal_law)){.k2 = (scalar)(constant[HYSTERETIC_K2] * unit),
                                     .kc = (scalar)(constant[HYSTERETIC_KC] * unit),
                                     .k2_minus_k1 = (scalar)(constant[HYSTERETIC_K2_MINUS_K1] * unit),
                                     .branch_ratio = (scalar)constant[HYSTERETIC_BRANCH_RATIO]};
}

struct NAME(normal_memory) {
    scalar *max_overlap;
};

/* Of the rises and the falls of delta_max^2. */
struct NAME(normal_sums) {
    real change, rise;
};

struct NAME(normal_totals) {
    struct NAME(doubles) change, rise;
};

/* The history moves first, then one formula for all branches: k2 (delta - delta_0) with k2 delta_0 = (k2 - k1)
 * delta_max, where delta_max grows with delta (the branch k1 delta) and shrinks with it where the adhesion branch -kc
 * delta would be left. */
LANES_INLINE real NAME(normal_elastic)(const struct NAME(normal_law) * law, real delta,
                                       const struct NAME(normal_memory) * memory, struct NAME(normal_sums) * sums)
{
    real before = real_load(memory->max_overlap);
    real after = real_larger(delta, real_smaller(before, real_all(law->branch_ratio) * delta));
    real change = after - before, both = after + before;
    sums->change = real_fma(change, both, sums->change);
    sums->rise = real_fma(real_larger(change, real_all(0.0)), both, sums->rise);
    real_store(memory->max_overlap, after);
    return real_fma(real_all(-law->k2_minus_k1), after, real_all(law->k2) * delta);
}

/* Friction is limited by the normal force above the adhesion branch (docs/theory.md). */
LANES_INLINE real NAME(normal_friction_limit)(const struct NAME(normal_law) * law, real delta, real pressing)
{
    return real_fma(real_all(law->kc), delta, -pressing);
}

LANES_INLINE real NAME(normal_energy)(const struct NAME(normal_law) * law, real delta, real elastic)
{
    (void)delta;
    return elastic * elastic / real_all(2 * law->k2);
}

LANES_INLINE struct NAME(normal_memory) NAME(normal_memory_at)(void *const *history, size_t slot)
{
    return (struct NAME(normal_memory)){.max_overlap = (scalar *)history[HISTORY_MAX_OVERLAP] + slot};
}

LANES_INLINE void NAME(normal_sums_close)(struct NAME(normal_sums) * sums, struct NAME(normal_totals) * totals)
{
    NAME(close)(&sums->change, &totals->change);
    NAME(close)(&sums->rise, &totals->rise);
}

LANES_INLINE double NAME(normal_hysteresis_j)(const struct NAME(normal_totals) * totals, const double *constant,
                                              const struct law_units *units)
{
    const double unit = units->length;
    const double rise = NAME(doubles_sum)(totals->rise), fall = rise - NAME(doubles_sum)(totals->change);
    return unit * unit * (constant[HYSTERETIC_LOADING_LOSS] * rise + constant[HYSTERETIC_ADHESION_LOSS] * fall);
}
#endif
