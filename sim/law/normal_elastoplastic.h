/* Adhesive elasto-plastic contacts (Luding, Granular Matter 10 (2008) 235): the linear hysteretic law with cohesion
 * whose k2 grows with the largest overlap, k2 = k1 + (kp - k1) delta_max/delta_p up to kp at delta_p = kp/(kp - k1)
 * phi_f 2 R, R the reduced radius. With a constant k2 (material of law "hysteretic") it is that law, bit for bit.
 *
 * With B = (kp - k1)/delta_p and C = 4 (k1 + kc)/B, the history h goes to max(delta, min(h, max(hq, hl))): on the
 * adhesion branch -kc delta it falls to hq = (delta + sqrt(delta (delta + C)))/2, or beyond delta_p to hl = (kp +
 * kc)/(kp - k1) delta. What is lost is a function of h alone: rising k1 h (k2 - k1) h/(2 k2), falling kc ((k2 - k1)
 * h)^2/(2 k2 (k2 + kc)) (docs/theory.md). */
#ifndef SHAKEDOWN_SIM_LAW_NORMAL_ELASTOPLASTIC_H
#define SHAKEDOWN_SIM_LAW_NORMAL_ELASTOPLASTIC_H

#include "sim/law/contact_law.h"
#include "sim/law/contact_model.h"

enum {
    ELASTOPLASTIC_K1,
    ELASTOPLASTIC_KP,
    ELASTOPLASTIC_KC,
    ELASTOPLASTIC_START,  /* k2 at no history; */
    ELASTOPLASTIC_HEIGHT, /* and k2 - k1 there */
    ELASTOPLASTIC_GROWTH, /* B R [N/m] */
    ELASTOPLASTIC_ROOT,   /* C/R */
    ELASTOPLASTIC_BRANCH, /* (kp + kc)/(kp - k1); 0 if kp = k1 */
};

enum { normal_elastoplastic_traits = NORMAL_PER_PAIR | NORMAL_REMEMBERS_OVERLAP };

static inline void normal_elastoplastic_constants(const struct scene_material *m, double *constant)
{
    const bool linear = m->law == LAW_LINEAR, grows = m->law == LAW_ELASTOPLASTIC;
    const double k1 = linear ? m->kn_n_per_m : m->k1_n_per_m, kc = linear ? 0 : m->kc_n_per_m;
    const double kp = linear ? k1 : grows ? m->kp_n_per_m : m->k2_n_per_m;
    const double growth = grows && kp > k1 ? (kp - k1) * (kp - k1) / (2 * kp * m->phi_f) : 0;
    constant[ELASTOPLASTIC_K1] = k1;
    constant[ELASTOPLASTIC_KP] = kp;
    constant[ELASTOPLASTIC_KC] = kc;
    constant[ELASTOPLASTIC_START] = growth > 0 ? k1 : kp;
    constant[ELASTOPLASTIC_HEIGHT] = growth > 0 ? 0 : kp - k1;
    constant[ELASTOPLASTIC_GROWTH] = growth;
    constant[ELASTOPLASTIC_ROOT] = growth > 0 ? 4 * (k1 + kc) / growth : 0;
    constant[ELASTOPLASTIC_BRANCH] = kp > k1 ? (kp + kc) / (kp - k1) : 0;
}

static inline double normal_elastoplastic_stiffness(const double *constant, double radius_m, double force_n)
{
    (void)radius_m;
    (void)force_n;
    return constant[ELASTOPLASTIC_KP];
}
#endif

#ifdef NORMAL_LANES
struct NAME(normal_law) {
    scalar k1, kp, kc, start, height, highest, growth, root, branch, gamma, unit;
};

/* The dashpot is that of the stage, handed over as the last constant (contact_law.c). */
LANES_INLINE struct NAME(normal_law) NAME(normal_law_of)(const double *constant, const struct law_units *units)
{
    const double unit = units->length / units->force;
    return (struct NAME(normal_law)){
        .k1 = (scalar)(constant[ELASTOPLASTIC_K1] * unit),
        .kp = (scalar)(constant[ELASTOPLASTIC_KP] * unit),
        .kc = (scalar)(constant[ELASTOPLASTIC_KC] * unit),
        .start = (scalar)(constant[ELASTOPLASTIC_START] * unit),
        .height = (scalar)(constant[ELASTOPLASTIC_HEIGHT] * unit),
        .highest = (scalar)((constant[ELASTOPLASTIC_KP] - constant[ELASTOPLASTIC_K1]) * unit),
        .growth = (scalar)(constant[ELASTOPLASTIC_GROWTH] * unit),
        .root = (scalar)constant[ELASTOPLASTIC_ROOT],
        .branch = (scalar)constant[ELASTOPLASTIC_BRANCH],
        .gamma = (scalar)(constant[NORMAL_CONSTANTS_MAX - 1] * units->speed / units->force),
        .unit = (scalar)(units->length * units->force)};
}

struct NAME(normal_memory) {
    scalar *max_overlap;
};

/* Energies lost, in units of force times length. */
struct NAME(normal_sums) {
    real lost;
};

struct NAME(normal_totals) {
    struct NAME(doubles) lost;
};

struct NAME(pair) {
    real elastic, gamma_n, stored;
};

/* k2 and k2 - k1 at history h. */
struct NAME(normal_branch) {
    real k2, height;
};

LANES_INLINE struct NAME(normal_branch) NAME(normal_branch_at)(const struct NAME(normal_law) * law, real growth, real h)
{
    return (struct NAME(normal_branch)){
        .k2 = real_smaller(real_all(law->kp), real_fma(growth, h, real_all(law->start))),
        .height = real_smaller(real_all(law->highest), real_fma(growth, h, real_all(law->height)))};
}

/* What has been lost when the history has risen to h, and when it has fallen from h to nothing. */
LANES_INLINE real NAME(normal_lost_rising)(const struct NAME(normal_law) * law, struct NAME(normal_branch) at, real h)
{
    return real_all(law->k1) * h * (at.height * h) / (real_all(2.0) * at.k2);
}

LANES_INLINE real NAME(normal_lost_falling)(const struct NAME(normal_law) * law, struct NAME(normal_branch) at, real h)
{
    const real pull = at.height * h;
    return real_all(law->kc) * pull * pull / (real_all(2.0) * at.k2 * (at.k2 + real_all(law->kc)));
}

LANES_INLINE real NAME(root_of)(real x)
{
#if SINGLE
    return f32_sqrt(x);
#else
    return real_where(real_greater(x, real_all(0.0)), x * lanes_rsqrt(x, f64_rsqrt_seed(x)));
#endif
}

LANES_INLINE struct NAME(pair)
    NAME(pair_of)(const struct NAME(normal_law) * law, real delta, real root_mass, real radius,
                  const struct NAME(normal_memory) * memory, struct NAME(normal_sums) * sums)
{
    struct NAME(pair) pair;
    const real growth = real_all(law->growth) / radius, before = real_load(memory->max_overlap);
    const real root = NAME(root_of)(delta * real_fma(real_all(law->root), radius, delta));
    const real hq = real_where(real_greater(growth, real_all(0.0)), real_all(0.5) * (delta + root)),
               hl = real_all(law->branch) * delta;
    const real after = real_larger(delta, real_smaller(before, real_larger(hq, hl)));
    const struct NAME(normal_branch) now = NAME(normal_branch_at)(law, growth, after),
                                     then = NAME(normal_branch_at)(law, growth, before);
    const real rise = NAME(normal_lost_rising)(law, now, after) - NAME(normal_lost_rising)(law, then, before);
    const real fall = NAME(normal_lost_falling)(law, then, before) - NAME(normal_lost_falling)(law, now, after);
    (void)root_mass;
    sums->lost = sums->lost + real_larger(rise, real_all(0.0)) + real_larger(fall, real_all(0.0));
    real_store(memory->max_overlap, after);
    pair.elastic = real_fma(-now.height, after, now.k2 * delta);
    pair.gamma_n = real_all(law->gamma);
    pair.stored = real_all(law->unit) * pair.elastic * pair.elastic / (real_all(2.0) * now.k2);
    return pair;
}

/* Friction is limited by the normal force above the adhesion branch (docs/theory.md). */
LANES_INLINE real NAME(normal_friction_limit)(const struct NAME(normal_law) * law, real delta, real pressing)
{
    return real_fma(real_all(law->kc), delta, -pressing);
}

LANES_INLINE struct NAME(normal_memory) NAME(normal_memory_at)(void *const *history, size_t slot)
{
    return (struct NAME(normal_memory)){.max_overlap = (scalar *)history[HISTORY_MAX_OVERLAP] + slot};
}

LANES_INLINE void NAME(normal_sums_close)(struct NAME(normal_sums) * sums, struct NAME(normal_totals) * totals)
{
    NAME(close)(&sums->lost, &totals->lost);
}

LANES_INLINE double NAME(normal_hysteresis_j)(const struct NAME(normal_totals) * totals, const double *constant,
                                              const struct law_units *units)
{
    (void)constant;
    return units->length * units->force * NAME(doubles_sum)(totals->lost);
}
#endif
