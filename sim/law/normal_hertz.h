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
    real fall; /* k_t over that of the step before, at most 1 */
    real lost; /* T^2 times half of this is what the change of k_t takes */
#endif
};

/* The contact radius ac from its square, 1/ac and sqrt(ac). */
struct NAME(contact_radius) {
    real radius, inverse, root;
};

LANES_INLINE struct NAME(contact_radius) NAME(contact_radius_of)(real square)
{
    struct NAME(contact_radius) to;
#if SINGLE
    to.radius = f32_sqrt(square);
    to.inverse = real_all(1.0) / to.radius;
    to.root = f32_sqrt(to.radius);
#else
    const real root = lanes_fourth_root_inverse(square, f64_fourth_root_seed(square));
    to.inverse = root * root;
    to.radius = square * to.inverse;
    to.root = to.radius * root;
#endif
    return to;
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
    const real_mask touched = real_greater(before, zero);
    const real idle = real_select(touched, before * before, radius * radius);
#else
    const real idle = radius * radius;
    (void)memory;
#endif
    const struct NAME(contact_radius) now = NAME(contact_radius_of)(real_select(active, radius * delta, idle));
    pair.elastic = real_all(law->e43) * now.radius * delta;
    pair.stored = real_all(law->two_fifths_unit) * pair.elastic * delta;
    pair.gamma_n = real_all(law->damping) * root_mass * now.root;
#if FRICTIONAL
    const real one = real_all(1.0);
    real ac = now.radius, inverse = now.inverse, ratio = ac / before;
#if SINGLE
    /* a contact radius that moves by less than its noise stays: else each fall would take a little of the force */
    const real more = ratio - one;
    const real_mask moves = real_greater(more * more, real_all(0x1p-36));
    ac = real_select(moves, ac, before);
    ratio = real_select(moves, ratio, one);
    inverse = inverse * (real_all(2.0) - ac * inverse); /* a step of Newton's, from at most 2^-18 off */
#endif
    ratio = real_select(touched, ratio, one);
    pair.kt = real_all(law->g8) * ac;
    pair.inv_kt = real_all(law->inv_g8) * inverse;
    pair.gamma_t = pair.gamma_n * real_all(law->tangent_ratio);
    pair.fall = real_smaller(ratio, one);
    const real held = pair.inv_kt * ratio; /* 1/k_t of the step before */
    pair.lost = held - real_smaller(held * ratio, pair.inv_kt);
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
