/* Hertz: f = (4/3) E* sqrt(R) delta^(3/2) (Johnson 1985), with the dashpot of Tsuji et al. (1992) that gives the
 * restitution asked for at any speed (Antypov & Elliott 2011): gamma_n = 2 sqrt(5/6) beta sqrt(S_n m_ij), S_n = 2 E*
 * ac, with the contact radius ac = sqrt(R delta) and beta as damping_ratio.h. Friction: Mindlin
 * (tangential_mindlin_tmpl.h), k_t = 8 G* ac. */
#ifndef SHAKEDOWN_SIM_LAW_NORMAL_HERTZ_H
#define SHAKEDOWN_SIM_LAW_NORMAL_HERTZ_H

#include <math.h>

#include "sim/law/contact_law.h"
#include "sim/law/contact_model.h"
#include "sim/law/damping_ratio.h"

enum {
    HERTZ_E,            /* E* [Pa] */
    HERTZ_8G,           /* 8 G* [Pa] */
    HERTZ_DAMPING,      /* gamma_n/(sqrt(m_ij) sqrt(ac)) */
    HERTZ_TANGENT_RATIO /* gamma_t/gamma_n = sqrt(S_t/S_n) */
};

enum { normal_hertz_traits = NORMAL_PER_PAIR | NORMAL_MINDLIN };

static inline void normal_hertz_constants(const struct scene_material *material, double *constant)
{
    const double e = material->youngs_modulus_pa, nu = material->poisson_ratio;
    constant[HERTZ_E] = e / (2 * (1 - nu * nu));
    constant[HERTZ_8G] = 8 * e / (4 * (2 - nu) * (1 + nu));
    constant[HERTZ_DAMPING] = 2 * sqrt(5.0 / 6) * damping_ratio_of(material) * sqrt(2 * constant[HERTZ_E]);
    constant[HERTZ_TANGENT_RATIO] = sqrt(constant[HERTZ_8G] / (2 * constant[HERTZ_E]));
}

/* 2 E* ac of two particles of that radius under that force; without a force at an overlap of 0.1 % of the radius. */
static inline double normal_hertz_stiffness(const double *constant, double radius_m, double force_n)
{
    const double reduced = 0.5 * radius_m, loaded = cbrt(0.75 * force_n * reduced / constant[HERTZ_E]);
    return 2 * constant[HERTZ_E] * (force_n > 0 ? loaded : sqrt(1e-3 * reduced * radius_m));
}
#endif

#ifdef NORMAL_LANES
struct NAME(normal_law) {
    scalar e43, g8, inv_g8, damping, tangent_ratio, two_fifths_unit; /* for lengths in units; k_t is per m */
};

LANES_INLINE struct NAME(normal_law) NAME(normal_law_of)(const double *constant, const struct law_units *units)
{
    const double unit = units->length, force = units->force;
    return (struct NAME(normal_law)){.e43 = (scalar)(4.0 / 3 * constant[HERTZ_E] * unit * unit / force),
                                     .g8 = (scalar)(constant[HERTZ_8G] * unit / force),
                                     .inv_g8 = (scalar)(force / (constant[HERTZ_8G] * unit)),
                                     .damping = (scalar)(constant[HERTZ_DAMPING] * sqrt(unit) * units->speed / force),
                                     .tangent_ratio = (scalar)constant[HERTZ_TANGENT_RATIO],
                                     .two_fifths_unit = (scalar)(0.4 * unit * force)};
}

struct NAME(normal_memory) {
    scalar *contact_radius; /* of the step before; with friction */
};

#include "sim/law/normal_lossless_tmpl.h"

/* What differs from contact to contact. Open ones go on with the contact radius that they had, or with that of an
 * overlap of the whole radius, so that their lanes stay finite. */
struct NAME(pair) {
    real elastic, gamma_n, stored;
#if FRICTIONAL
    real kt, inv_kt, gamma_t;
    real fall;  /* k_t over that of the step before, at most 1 */
    real ratio; /* the same or its inverse, whichever is less: what the tangential energy keeps of itself */
    real held;  /* 1/k_t of the step before */
#endif
};

LANES_INLINE real NAME(inverse_root)(real x)
{
#if SINGLE
    return real_all(1.0) / f32_sqrt(x);
#else
    return lanes_rsqrt(x, f64_rsqrt_seed(x));
#endif
}

LANES_INLINE real NAME(positive_root)(real x)
{
#if SINGLE
    return f32_sqrt(x);
#else
    return x * NAME(inverse_root)(x);
#endif
}

LANES_INLINE struct NAME(pair)
    NAME(pair_of)(const struct NAME(normal_law) * law, real delta, real root_mass, real radius,
                  const struct NAME(normal_memory) * memory, struct NAME(normal_sums) * sums)
{
    struct NAME(pair) pair;
    (void)sums;
    const real zero = real_all(0.0);
    const real_mask active = real_greater(delta, zero);
#if FRICTIONAL
    const real before = real_load(memory->contact_radius);
    const real idle = real_select(real_greater(before, zero), before * before, radius * radius);
#else
    const real idle = radius * radius;
    (void)memory;
#endif
    const real ac2 = real_select(active, radius * delta, idle), inverse = NAME(inverse_root)(ac2);
    real ac = ac2 * inverse, inv_ac = inverse; /* of which the last is for friction */
    (void)inv_ac;
#if FRICTIONAL && SINGLE
    /* a contact radius that moves by less than its noise stays: else each fall would take a little of the force */
    const real moved = ac - before, band = real_all(0x1p-18) * before;
    const real_mask moves = real_greater(moved * moved, band * band);
    ac = real_select(moves, ac, real_select(active, before, ac));
    inv_ac = inverse * (real_all(2.0) - ac * inverse); /* a step of Newton's, from at most 2^-18 off */
#endif
    pair.elastic = real_all(law->e43) * (ac2 * inverse) * delta;
    pair.stored = real_all(law->two_fifths_unit) * pair.elastic * delta;
    pair.gamma_n = real_all(law->damping) * root_mass * NAME(positive_root)(ac);
#if FRICTIONAL
    const real one = real_all(1.0), up = ac / before, down = before * inv_ac;
    pair.kt = real_all(law->g8) * ac;
    pair.inv_kt = real_all(law->inv_g8) * inv_ac;
    pair.gamma_t = pair.gamma_n * real_all(law->tangent_ratio);
    pair.fall = real_smaller(up, one); /* new contacts: inf, or 0/0, which becomes 1 */
    pair.ratio = real_smaller(up, real_smaller(down, one));
#if SINGLE
    pair.ratio = real_select(moves, pair.ratio, one); /* where nothing moves, nothing is lost by rounding */
#endif
    pair.held = real_select(real_greater(before, zero), pair.inv_kt * up, zero);
    real_store(memory->contact_radius, real_where(active, ac));
#endif
    return pair;
}

LANES_INLINE real NAME(normal_friction_limit)(const struct NAME(normal_law) * law, real delta, real pressing)
{
    (void)law;
    (void)delta;
    return -pressing;
}

LANES_INLINE struct NAME(normal_memory) NAME(normal_memory_at)(void *const *history, size_t slot)
{
    struct NAME(normal_memory) memory = {NULL};
    (void)history;
    (void)slot;
#if FRICTIONAL
    memory.contact_radius = (scalar *)history[HISTORY_CONTACT_RADIUS] + slot;
#endif
    return memory;
}
#endif
