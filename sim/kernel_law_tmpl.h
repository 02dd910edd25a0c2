/* The law of one set of contacts, written once and compiled for each model, precision and instruction set. The
 * including file defines ISA         part of the names; lanes_<ISA>.h is included before DIM         2 | 3 HYSTERETIC
 * 0 | 1 FRICTIONAL  0 | 1 SINGLE      0 | 1: the law in float (docs/theory.md: mixed precision) Every contact's
 * arithmetic is the same in every lane and instruction set, so forces and histories are the same bits; only the sums of
 * the losses differ in their order. There are no branches: open candidates select zeros.
 *
 * Tangential law [D eq. 2-4], second order in time: the spring is kept at the middle of the step, xi(k+1/2) =
 * xi(k-1/2) + v_t(k) dt, and brought to the step's end by xi(k) = xi(k-1/2) + v_t(k) dt/2, with v_t from velocities
 * predicted for the same time as the positions (no half-step lag). */
#include "sim/lanes_real.h"

#undef NAME_
#undef NAME__
#undef NAME
#undef SPRINGS
#define NAME_(stem, isa, dim, h, f, s)  stem##_##isa##_##dim##_##h##_##f##_##s
#define NAME__(stem, isa, dim, h, f, s) NAME_(stem, isa, dim, h, f, s)
#define NAME(stem)                      NAME__(stem, ISA, DIM, HYSTERETIC, FRICTIONAL, SINGLE)

/* Components of the tangential spring, of rotations and of moments. */
#define SPRINGS (2 * DIM - 3)

struct NAME(law) {
    scalar k1, k2, kc, gamma_n, mu_s, mu_d, kt, inv_kt, gamma_t, dt, k2_minus_k1, branch_ratio;
};

LANES_INLINE struct NAME(law) NAME(law_of)(const struct contact_law_constants *law)
{
    return (struct NAME(law)){.k1 = (scalar)law->k1,
                              .k2 = (scalar)law->k2,
                              .kc = (scalar)law->kc,
                              .gamma_n = (scalar)law->gamma_n,
                              .mu_s = (scalar)law->mu_s,
                              .mu_d = (scalar)law->mu_d,
                              .kt = (scalar)law->kt,
                              .inv_kt = (scalar)law->inv_kt,
                              .gamma_t = (scalar)law->gamma_t,
                              .dt = (scalar)law->dt,
                              .k2_minus_k1 = (scalar)law->k2_minus_k1,
                              .branch_ratio = (scalar)law->branch_ratio};
}

/* What the contacts of a list remember, LANES of them from here on; changed in place. rest: what rounding left out of
 * the spring, so that slow motion, less than a unit of its last place in a step, is not lost (Kahan's sum); float only.
 */
struct NAME(memory) {
    scalar *history, *spring[3], *rest[3], *sliding; /* sliding: 1 or 0 */
};

/* The first half of the law: what acts along the normal, and the test force of friction. */
struct NAME(touch) {
    real_mask active;
    real n[DIM], pressing; /* force along n on j */
#if FRICTIONAL
    real limit, length2, pull2;
    real vt[SPRINGS], pull[SPRINGS], turned[SPRINGS]; /* the spring today; single: its change */
#endif
};

/* Force on j (reversed: on i), and moment n x f_t, alike for both. */
struct NAME(contact_result) {
    real force[DIM], moment[3];
};

/* Sums over contacts, one per lane: of u^2, of the rises and the falls of history^2, of what the dashpot (over gamma_t)
 * and sliding take. */
struct NAME(sums) {
    real normal, rise, fall, tangential, friction;
};

#if FRICTIONAL
/* a.b, and component c of a x b, for components 0 ... 2 */
LANES_INLINE real NAME(dot)(const real *a, const real *b)
{
    real sum = a[0] * b[0];
    for (int c = 1; c < SPRINGS; c++)
        sum = real_fma(a[c], b[c], sum);
    return sum;
}

#if DIM == 3
LANES_INLINE real NAME(cross)(const real *a, const real *b, int c)
{
    int d = (c + 1) % 3, e = (c + 2) % 3;
    return real_fma(a[d], b[e], -a[e] * b[d]);
}

#if SINGLE
/* How much the spring changes when it is brought into the tangent plane of today [D] and turned with the pair's mean
 * spin about n, its length kept: small numbers only, as for the same thing in double below. `twist`: angle. */
LANES_INLINE void NAME(turn)(const real *n, real twist, const real *spring, real length2, real *turn)
{
    real along = NAME(dot)(spring, n), twist_n[3];
    real share = along * along / real_larger(length2, real_all(1e-30)); /* of the square that the projection takes */
    real e = real_fma(-twist, twist, real_smaller(share, real_all(0.5)));
    real stretch = e * real_fma(e, real_all(0.375), real_all(0.5)); /* (1 - e)^(-1/2) - 1 */
    for (int c = 0; c < 3; c++)
        twist_n[c] = twist * n[c];
    for (int c = 0; c < 3; c++) {
        int d = (c + 1) % 3, f = (c + 2) % 3;
        turn[c] = real_fma(stretch, spring[c], -along * n[c]);
        turn[c] = real_fma(twist_n[d], spring[f], real_fma(-twist_n[f], spring[d], turn[c]));
    }
}
#else
/* The spring brought into the tangent plane of today [D], turned with the pair's mean spin about n, its length kept. */
LANES_INLINE void NAME(turn)(const real *n, real twist, const real *spring, real length2, real *turned)
{
    real along = NAME(dot)(spring, n), p[3];
    for (int c = 0; c < 3; c++)
        p[c] = real_fma(-along, n[c], spring[c]);
    for (int c = 0; c < 3; c++)
        turned[c] = real_fma(twist, NAME(cross)(n, p, c), p[c]);
    /* sqrt(1 + e) by its series: e is the square of the turn in a step, so that e^4 is below rounding; bounded for
     * springs that stood almost along n */
    real turned2 = NAME(dot)(turned, turned);
    real e = real_smaller(length2 / turned2, real_all(1.5)) - real_all(1.0);
    real root = real_fma(e, real_fma(e, real_fma(e, real_all(0.0625), real_all(-0.125)), real_all(0.5)), real_all(1.0));
    real scale = real_select(real_greater(turned2, real_all(0.0)), root, real_all(0.0));
    for (int c = 0; c < 3; c++)
        turned[c] = turned[c] * scale;
}
#endif
#endif

/* Factor to bring a force of square `square` > 0 down to `to`. */
LANES_INLINE real NAME(ratio)(real to, real square)
{
#if SINGLE
    return to / f32_sqrt(square);
#else
    return to * lanes_rsqrt(square, f64_rsqrt_seed(square));
#endif
}

/* Test force. n: normal, g: relative velocity of the centres, u = g.n, w: a_i omega_i + a_j omega_j, spin: omega_i +
 * omega_j. pull = kt xi + gamma_t v_t is the reversed test force. */
LANES_INLINE void NAME(test_force)(const struct NAME(law) * law, const real *n, const real *g, real u, const real *w,
                                   const real *spin, const struct NAME(memory) * memory, struct NAME(touch) * touch)
{
    const real half = real_all(0.5) * real_all(law->dt), kt = real_all(law->kt), gamma_t = real_all(law->gamma_t);
    real spring[SPRINGS], now[SPRINGS];
    for (int c = 0; c < SPRINGS; c++)
        spring[c] = real_load(memory->spring[c]);
    touch->length2 = NAME(dot)(spring, spring);
#if DIM == 2
    /* tangent (-n1, n0); the spring is a number along it, so a rotating pair carries it along by itself */
    (void)u;
    (void)spin;
    touch->vt[0] = real_fma(g[1], n[0], real_fma(-g[0], n[1], -w[0]));
    touch->turned[0] = now[0] = spring[0];
#else
    for (int c = 0; c < 3; c++) { /* g + n x w - u n */
        int d = (c + 1) % 3, e = (c + 2) % 3;
        touch->vt[c] = real_fma(n[d], w[e], real_fma(-n[e], w[d], real_fma(-u, n[c], g[c])));
    }
    NAME(turn)(n, half * NAME(dot)(spin, n), spring, touch->length2, touch->turned);
    for (int c = 0; c < 3; c++) {
        now[c] = touch->turned[c];
#if SINGLE
        now[c] = now[c] + spring[c];
#endif
    }
#endif
    for (int c = 0; c < SPRINGS; c++)
        touch->pull[c] = real_fma(kt, real_fma(half, touch->vt[c], now[c]), gamma_t * touch->vt[c]);
    touch->pull2 = NAME(dot)(touch->pull, touch->pull);
}

/* Friction, with the limit of `touch`: adds to the force, sets moment, spring and losses. A sliding contact keeps
 * `factor` of the test force, and its spring slips by q pull, q = (1 - factor)/kt, so that the law holds with the
 * spring that is left. q = 0: it sticks. */
LANES_INLINE void NAME(friction)(const struct NAME(law) * law, const struct NAME(touch) * touch,
                                 const struct NAME(memory) * memory, struct NAME(contact_result) * result,
                                 struct NAME(sums) * sums)
{
    const real zero = real_all(0.0), one = real_all(1.0), dt = real_all(law->dt), half = real_all(0.5) * dt;
    const real kt = real_all(law->kt), limit = touch->limit, pull2 = touch->pull2, *n = touch->n;
    const real_mask active = touch->active;
    real power = NAME(dot)(touch->pull, touch->vt), vt2 = NAME(dot)(touch->vt, touch->vt), pull[SPRINGS];
    real slid = real_load(memory->sliding);
    real bound = limit * real_select(real_greater(slid, zero), real_all(law->mu_d), real_all(law->mu_s));
    /* N^2; keeps the root finite */
    real reduced = NAME(ratio)(real_all(law->mu_d) * limit, real_larger(pull2, real_all(1e-30)));
    real_mask slides = real_and(active, real_greater(pull2, bound * bound));
    real factor = real_select(slides, reduced, one);
    real q = (one - factor) * real_all(law->inv_kt), kept = real_select(active, factor, zero);
    real_store(memory->sliding, real_select(slides, one, zero));
    sums->tangential = sums->tangential + real_select(active, real_fma(dt, vt2, -q * power), zero);
    /* with the mean of the spring over the step, the ledger closes in second order, jumps of the spring included; an
     * opening contact loses what its spring held */
    real friction = q * real_fma(pull2, real_fma(real_all(-0.5) * kt, q, one), -kt * half * power);
    sums->friction = sums->friction + real_select(active, friction, real_all(0.5) * kt * touch->length2);
    for (int c = 0; c < SPRINGS; c++) {
#if SINGLE
        real spring = real_load(memory->spring[c]);
        real change = real_fma(-q, touch->pull[c], real_fma(dt, touch->vt[c], real_load(memory->rest[c])));
#if DIM == 3
        change = change + touch->turned[c];
#endif
        real after = spring + change;
        real_store(memory->rest[c], real_select(active, change - (after - spring), zero));
#else
        real after = real_fma(-q, touch->pull[c], real_fma(dt, touch->vt[c], touch->turned[c]));
#endif
        real_store(memory->spring[c], real_select(active, after, zero));
        pull[c] = kept * touch->pull[c]; /* the tangential force on j */
    }
#if DIM == 2
    result->force[0] = real_fma(-pull[0], n[1], result->force[0]);
    result->force[1] = real_fma(pull[0], n[0], result->force[1]);
    result->moment[0] = -pull[0];
#else
    for (int c = 0; c < 3; c++) {
        result->force[c] = result->force[c] + pull[c];
        result->moment[c] = NAME(cross)(pull, n, c);
    }
#endif
}
#endif

/* First half of the law for one set of contacts: overlap, normal and velocities in. Arguments as of `test_force`. */
LANES_INLINE struct NAME(touch)
    NAME(touch)(const struct NAME(law) * law, real delta, const real *n, const real *g, const real *w, const real *spin,
                const struct NAME(memory) * memory, struct NAME(sums) * sums)
{
    struct NAME(touch) touch;
    const real zero = real_all(0.0), gamma_n = real_all(law->gamma_n);
    touch.active = real_greater(delta, zero);
    real u = real_fma(g[1], n[1], g[0] * n[0]);
#if DIM == 3
    u = real_fma(g[2], n[2], u);
#endif
    real loading = real_all(law->k1) * delta;
#if HYSTERETIC
    /* [LH eq. 1.6]: loading k1 delta, un- and reloading k2 (delta - delta_0), adhesion branch -kc delta */
    real history = real_load(memory->history);
    real unloading = real_fma(real_all(law->k2), delta, -real_all(law->k2_minus_k1) * history);
    real adhesion = -real_all(law->kc) * delta;
    real elastic = real_larger(adhesion, real_smaller(loading, unloading));
    real moved = real_select(real_at_least(adhesion, unloading), real_all(law->branch_ratio) * delta, history);
    real after = real_select(real_at_least(unloading, loading), delta, moved);
    after = real_select(touch.active, after, zero);
    real change = (after - history) * (after + history);
    sums->rise = sums->rise + real_larger(change, zero);
    sums->fall = sums->fall + real_smaller(change, zero);
    real_store(memory->history, after);
#else
    real elastic = loading;
#endif
    real pressing = real_fma(gamma_n, u, -elastic);
    sums->normal = sums->normal + real_select(touch.active, u * u, zero);
    touch.pressing = real_select(touch.active, pressing, zero);
    for (int c = 0; c < DIM; c++)
        touch.n[c] = n[c];
#if FRICTIONAL
    /* friction is limited by the normal force above the adhesion branch, never below 0 (docs/theory.md) */
    touch.limit = real_larger(zero, real_fma(real_all(law->kc), delta, -pressing));
    NAME(test_force)(law, n, g, u, w, spin, memory, &touch);
#else
    (void)w;
    (void)spin;
    (void)memory;
#endif
    return touch;
}

/* Second half: forces. */
LANES_INLINE struct NAME(contact_result) NAME(force)(const struct NAME(law) * law, const struct NAME(touch) * touch,
                                                     const struct NAME(memory) * memory, struct NAME(sums) * sums)
{
    struct NAME(contact_result) result;
    for (int c = 0; c < DIM; c++)
        result.force[c] = touch->pressing * touch->n[c];
#if FRICTIONAL
    NAME(friction)(law, touch, memory, &result, sums);
#else
    (void)law;
    (void)memory;
    (void)sums;
#endif
    return result;
}

LANES_INLINE double NAME(sum)(real x)
{
#if SINGLE
    f64 part[PARTS];
    double sum = 0;
    f32_widen(x, part);
    for (int h = 0; h < PARTS; h++)
        sum += f64_sum(part[h]);
    return sum;
#else
    return f64_sum(x);
#endif
}

/* Adds the sums as energies [J]. Not inlined: it is not for every set. */
static void __attribute__((noinline))
NAME(sums_add)(const struct NAME(sums) * sums, const struct contact_law_constants *law, struct contact_losses *losses)
{
    losses->viscous_normal += law->gamma_n * law->dt * NAME(sum)(sums->normal);
#if HYSTERETIC
    losses->hysteresis += law->loading_loss * NAME(sum)(sums->rise) - law->adhesion_loss * NAME(sum)(sums->fall);
#endif
#if FRICTIONAL
    losses->viscous_tangential += law->gamma_t * NAME(sum)(sums->tangential);
    losses->friction += NAME(sum)(sums->friction);
#endif
}

/* The same, and the sums start anew. */
LANES_INLINE void NAME(sums_close)(struct NAME(sums) * sums, const struct contact_law_constants *law,
                                   struct contact_losses *losses)
{
    const struct NAME(sums) closed = *sums, none = {0};
    NAME(sums_add)(&closed, law, losses);
    *sums = none;
}
