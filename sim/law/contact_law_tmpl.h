/* The law of one set of contacts, written once and compiled for each model, precision and instruction set. The
 * including file defines
 * - ISA: part of the names; lanes_<ISA>.h is included before;
 * - NORMAL, NORMAL_TEXT: the normal law; PER_PAIR: it differs from contact to contact; MINDLIN: so does
 *   friction (all as in for_each_model.h); DIM: 2 or 3; FRICTION, FRICTIONAL, ROLLING,
 *   TORSION;
 * - SINGLE: 1 for the law in float (docs/theory.md: mixed precision), else 0.
 * Every contact's arithmetic is the same in every lane and instruction set, so forces and histories are the same bits;
 * only the sums of the losses differ in their order. There are no branches: open candidates select zeros.
 *
 * Tangential law [D eq. 2-4], second order in time: the spring at the step's end, xi(k), is as far as the particles
 * have gone along each other, xi(k) = xi(k-1) + v_t(k-1/2) dt; the dashpot takes velocities predicted for the same time
 * as the positions. What is kept is xi(k) + v_t(k) dt/2, half a step ahead, for which v_t(k-1/2) = (v_t(k-1) + v_t(k) +
 * lag)/2 (particles.h) needs nothing of the step before (docs/theory.md: Time integration of friction). */
#include "sim/lanes/lanes_real.h"

#undef NAME_
#undef NAME__
#undef NAME
#undef SPRINGS
#define NAME_(stem, isa, dim, h, f, s)  stem##_##isa##_##dim##_##h##_##f##_##s
#define NAME__(stem, isa, dim, h, f, s) NAME_(stem, isa, dim, h, f, s)
#define NAME(stem)                      NAME__(stem, ISA, DIM, NORMAL, FRICTION, SINGLE)

/* Components of the tangential spring, of rotations and of moments. */
#define SPRINGS (2 * DIM - 3)

/* LANES doubles. */
struct NAME(doubles) {
    f64 part[PARTS];
};

LANES_INLINE struct NAME(doubles) NAME(doubles_load)(const double *from)
{
    struct NAME(doubles) to;
    for (int h = 0; h < PARTS; h++)
        to.part[h] = f64_load(from + h * F64_LANES);
    return to;
}

LANES_INLINE void NAME(doubles_store)(double *to, struct NAME(doubles) from)
{
    for (int h = 0; h < PARTS; h++)
        f64_store(to + h * F64_LANES, from.part[h]);
}

LANES_INLINE struct NAME(doubles) NAME(doubles_of)(real x)
{
    struct NAME(doubles) to;
    REAL(widen)(x, to.part);
    return to;
}

/* factor a + b */
LANES_INLINE struct NAME(doubles) NAME(doubles_fma)(f64 factor, struct NAME(doubles) a, struct NAME(doubles) b)
{
    for (int h = 0; h < PARTS; h++)
        b.part[h] = f64_fma(factor, a.part[h], b.part[h]);
    return b;
}

LANES_INLINE struct NAME(doubles) NAME(doubles_add)(struct NAME(doubles) a, struct NAME(doubles) b)
{
    for (int h = 0; h < PARTS; h++)
        a.part[h] = a.part[h] + b.part[h];
    return a;
}

LANES_INLINE double NAME(doubles_sum)(struct NAME(doubles) x)
{
    for (int h = 1; h < PARTS; h++)
        x.part[0] = x.part[0] + x.part[h];
    return f64_sum(x.part[0]);
}

LANES_INLINE void NAME(close)(real *sum, struct NAME(doubles) * total)
{
    *total = NAME(doubles_add)(*total, NAME(doubles_of)(*sum));
    *sum = real_all(0.0);
}

/* The text of a normal law gives, each for lanes of this model:
 * - normal_law, normal_law_of: its constants, from those of contact_law.h, in the units of the lanes;
 * - normal_memory, normal_memory_at: its columns of the history (contact_history.h);
 * - normal_elastic (not if PER_PAIR): the elastic force at overlap delta >= 0 (0: none), with the history moved on;
 * - normal_friction_limit: the force that limits friction, from the overlap and the force `pressing` along n on j;
 * - normal_energy (not if PER_PAIR): what the elastic force at delta holds;
 * - if PER_PAIR: struct pair, pair_of: of each contact the elastic force, the damping gamma_n [kg/s] and what it holds
 * [J];
 * - normal_sums, normal_totals, normal_sums_close, normal_hysteresis_j: what it loses by itself.
 * A law that remembers or loses nothing includes normal_memoryless_tmpl.h, normal_lossless_tmpl.h. */
#define NORMAL_LANES
#include NORMAL_TEXT
#undef NORMAL_LANES

#if ROLLING
/* Of rolling or torsion: mu, spring, dashpot, gamma - k dt/2, 1 if there is any, and for the losses gamma dt, k dt/2;
 * forces in their unit. */
struct NAME(resistance) {
    scalar mu, k, inv_k, gamma, lever, on, gamma_dt, half_k_dt;
};

LANES_INLINE struct NAME(resistance)
    NAME(resistance_of)(const struct contact_resistance *r, double dt_s, double lever_s, const struct law_units *units)
{
    const double damped = units->speed / units->force, dt = dt_s * units->speed;
    return (struct NAME(resistance)){.mu = (scalar)r->mu,
                                     .k = (scalar)(r->k / units->force),
                                     .inv_k = (scalar)(r->inv_k * units->force),
                                     .gamma = (scalar)(r->gamma * damped),
                                     .lever = (scalar)((r->gamma - 0.5 * r->k * lever_s) * damped),
                                     .on = r->k > 0,
                                     .gamma_dt = (scalar)(r->gamma * damped * dt),
                                     .half_k_dt = (scalar)(0.5 * r->k / units->force * dt)};
}
#endif

struct NAME(law) {
    struct NAME(normal_law) normal;
#if ROLLING
    struct NAME(resistance) rolling;
#if TORSION
    struct NAME(resistance) torsion;
#endif
#endif
    scalar gamma_n, mu_s, mu_d, kt, inv_kt, gamma_t, dt;
    scalar inv_gamma_n;                   /* 0 without a dashpot; laws that are not PER_PAIR */
    scalar lever;                         /* gamma_t - kt dt/2 */
    scalar per_force;                     /* 1/(a small force of the scene), a power of 2 */
    scalar half, damped;                  /* Mindlin: dt/2 of that, and the part of gamma_t */
    scalar unit, dt_units, half_per_unit; /* of lengths [m]; dt and dt/2 over that */
    bool no_pull, elastic_limit;
};

/* dt_s: by which the contacts go on; lever_s: the time step that springs are half of ahead */
LANES_INLINE struct NAME(law)
    NAME(law_of)(const struct contact_law_constants *law, double dt_s, double lever_s, const struct law_units *units)
{
    const double unit = units->length, force = units->force, damped = units->speed / force;
    const double dt = law->springs ? dt_s * units->speed : 0; /* springs are in m */
    return (struct NAME(law))
    {
        .normal = NAME(normal_law_of)(law->normal, units),
#if ROLLING
        .rolling = NAME(resistance_of)(&law->rolling, dt_s, lever_s, units),
#if TORSION
        .torsion = NAME(resistance_of)(&law->torsion, dt_s, lever_s, units),
#endif
#endif
        .gamma_n = (scalar)(law->gamma_n * damped), .mu_s = (scalar)law->mu_s, .mu_d = (scalar)law->mu_d,
        .kt = (scalar)(law->kt / force), .inv_kt = (scalar)(law->inv_kt * force),
        .gamma_t = (scalar)(law->gamma_t * damped), .dt = (scalar)dt,
        .lever = (scalar)((law->gamma_t - 0.5 * law->kt * lever_s) * damped),
        .half = (scalar)(law->springs ? 0.5 * lever_s * units->speed : 0), .damped = law->springs, .unit = (scalar)unit,
        .dt_units = (scalar)(dt / unit), .half_per_unit = (scalar)(0.5 * dt / unit),
        .per_force = (scalar)(law->per_force * force),
        .inv_gamma_n = (scalar)(law->gamma_n > 0 ? 1 / (law->gamma_n * damped) : 0), .no_pull = law->no_pull,
        .elastic_limit = law->elastic_limit
    };
}

/* What the contacts of a list remember, LANES of them from here on; changed in place. rest: what rounding left out of
 * the spring, so that slow motion, less than a unit of its last place in a step, is not lost (Kahan's sum); float only.
 */
struct NAME(memory) {
    struct NAME(normal_memory) normal;
#if PER_PAIR
    const scalar *root_mass, *radius; /* PAIR_ROOT_MASS, PAIR_RADIUS */
#endif
#if FRICTIONAL
    scalar *spring[SPRINGS], *rest[SPRINGS], *sliding; /* sliding: 1 or 0 */
#endif
#if ROLLING
    scalar *rolling[SPRINGS], *rolling_rest[SPRINGS];
#endif
#if TORSION
    scalar *torsion, *torsion_rest;
#endif
};

/* pair, history: the columns of the slots. */
LANES_INLINE struct NAME(memory) NAME(memory_at)(void *const *pair, void *const *history, size_t slot)
{
    struct NAME(memory) memory = {.normal = NAME(normal_memory_at)(history, slot)};
    (void)pair;
#if PER_PAIR
    memory.root_mass = (const scalar *)pair[PAIR_ROOT_MASS] + slot;
    memory.radius = (const scalar *)pair[PAIR_RADIUS] + slot;
#endif
#if FRICTIONAL
    memory.sliding = (scalar *)history[HISTORY_SLIDING] + slot;
    for (int c = 0; c < SPRINGS; c++) {
        memory.spring[c] = (scalar *)history[(MINDLIN ? HISTORY_FORCE : HISTORY_SPRING) + c] + slot;
        memory.rest[c] =
            SINGLE ? (scalar *)history[(MINDLIN ? HISTORY_FORCE_REST : HISTORY_SPRING_REST) + c] + slot : NULL;
    }
#endif
#if ROLLING
    for (int c = 0; c < SPRINGS; c++) {
        memory.rolling[c] = (scalar *)history[HISTORY_ROLLING + c] + slot;
        memory.rolling_rest[c] = SINGLE ? (scalar *)history[HISTORY_ROLLING_REST + c] + slot : NULL;
    }
#endif
#if TORSION
    memory.torsion = (scalar *)history[HISTORY_TORSION] + slot;
    memory.torsion_rest = SINGLE ? (scalar *)history[HISTORY_TORSION_REST] + slot : NULL;
#endif
    return memory;
}

/* Both sides of a set of contacts, i's against j's: centres, velocities of the centres, w = a_i omega_i + a_j omega_j
 * and spin = omega_i + omega_j; and the lags of velocities and of w. */
struct NAME(sides) {
    real d[DIM], g[DIM];
    real inverse, delta; /* inverse of |d|; overlap, up to 0 if they do not touch; mixed: then both 0 */
#if FRICTIONAL
    real w[SPRINGS], lag[DIM], lag_w[SPRINGS];
    real arm; /* lever arms over the radii */
#if ROLLING
    real turning[SPRINGS], lag_turning[SPRINGS]; /* omega_i - omega_j */
    real radius, share;                          /* a_i; a_j/(a_i + a_j), 1 against a wall */
#endif
#if DIM == 3
    real spin[3];
#endif
#endif
};

/* What the law wants to know of them: along and across the contact. Open contacts: velocities are 0. */
struct NAME(meeting) {
    real n[DIM], u, delta; /* u: velocity along n; overlap, 0 if they do not touch */
#if FRICTIONAL
    real arm, vt[SPRINGS], lag[SPRINGS]; /* velocity along the tangent plane, and its lag */
#if DIM == 3
    real ahead[3], twist; /* how the contact turns in a step (struct of `turn`) */
#endif
#if ROLLING
    real share, rolling[SPRINGS], rolling_lag[SPRINGS]; /* likewise; share: 0 if they do not touch */
#endif
#if TORSION
    real torsion, torsion_lag;
#endif
#endif
};

#if ROLLING
/* Rolling when what resists it is known, but for how much of it slides; as of struct touch. */
struct NAME(rolled) {
    real pull[SPRINGS], moved[SPRINGS], pull2, power, v2;
    real factor; /* until it is known: what limits the quasi-force */
};
#endif

/* The same when all roots are drawn: what is left is to move springs and to find the force. */
struct NAME(touch) {
    real n[DIM], pressing; /* force along n on j */
#if FRICTIONAL
    real_mask active;
#if MINDLIN
    real inv_kt, gamma_t;
    real stiffness; /* twice what the changing kt takes */
#endif
    real arm, pull[SPRINGS], pull2, power, viscous, bound2, kinetic, factor;
    real moved[SPRINGS]; /* the spring half a step on if nothing slides; mixed: its change */
#endif
#if ROLLING
    real share;
    struct NAME(rolled) rolling;
#if TORSION
    real torsion; /* the quasi-force along n */
#endif
#endif
};

/* Force on j (reversed: on i), and moment n x f_t, alike for both but for rolling and torsion: `own` is that on i. */
struct NAME(contact_result) {
    real force[DIM];
#if FRICTIONAL
    real moment[SPRINGS];
#endif
#if ROLLING
    real own[SPRINGS];
#endif
};

/* Sums over contacts, one per lane: of u^2; of v_t^2 of those that stick and of those that slide, q pull^2, q^2 pull^2
 * and q pull.v_t for what the dashpot and sliding take. */
struct NAME(sums) {
    struct NAME(normal_sums) own; /* of the normal law */
    real normal, stuck, slid, slip, slip2, power;
#if MINDLIN
    real power_t, stiffness;
#endif
#if ROLLING
    real rolling, viscous_rolling; /* energies, those of torsion among them */
#endif
};

/* What they have come to, so that sums in float stay short. */
struct NAME(totals) {
    struct NAME(normal_totals) own;
    struct NAME(doubles) normal, stuck, slid, slip, slip2, power;
#if MINDLIN
    struct NAME(doubles) power_t, stiffness;
#endif
#if ROLLING
    struct NAME(doubles) rolling, viscous_rolling;
#endif
};

LANES_INLINE real NAME(inner)(const real *a, const real *b)
{
    real sum = a[0] * b[0];
    for (int c = 1; c < DIM; c++)
        sum = real_fma(a[c], b[c], sum);
    return sum;
}

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

/* How a contact turns in a step: `ahead`, n - tan(theta/2) e, e the direction in which n moves; and the pair's mean
 * spin about n. gt: velocity of the centres along the tangent plane. */
LANES_INLINE void NAME(turning)(const struct NAME(law) * law, const struct NAME(sides) * of, const real *gt,
                                struct NAME(meeting) * at)
{
    const real half_turn = real_all(law->half_per_unit) * of->inverse;
    for (int c = 0; c < 3; c++)
        at->ahead[c] = real_fma(-half_turn, gt[c], at->n[c]);
    at->twist = real_all((scalar)0.5 * law->dt) * NAME(dot)(of->spin, at->n);
}

/* Adds to `change` what turning with the contact changes s by: by the smallest rotation that takes the normal of the
 * step before to n, R s = s - (s.n) ahead, and with the spin about n. The length is kept to the fourth order of the
 * turn in a step. */
LANES_INLINE void NAME(turn)(const struct NAME(meeting) * at, const real *s, real *change)
{
    const real along = NAME(dot)(s, at->n), twist = at->twist, shrink = real_all(-0.5) * twist * twist;
    for (int c = 0; c < 3; c++) {
        const real spun = real_fma(twist, NAME(cross)(at->n, s, c), real_fma(shrink, s[c], change[c]));
        change[c] = real_fma(-along, at->ahead[c], spun);
    }
}
#endif

/* What a contact remembers goes on by `change` (double: becomes that). */
LANES_INLINE void NAME(remember)(scalar *value, scalar *rest, real_mask active, real change)
{
    real after = change;
#if SINGLE
    const real before = real_load(value);
    after = before + change;
    real_store(rest, real_where(active, change - (after - before)));
#else
    (void)rest;
#endif
    real_store(value, real_where(active, after));
}

/* What is remembered becomes 0 but for contacts that are `old`. */
LANES_INLINE void NAME(forget)(scalar *value, scalar *rest, real_mask old)
{
    real_store(value, real_where(old, real_load(value)));
    if (SINGLE)
        real_store(rest, real_where(old, real_load(rest)));
}

#include "sim/law/friction_tmpl.h"
#include TANGENTIAL_TEXT

#if ROLLING
#include "sim/law/rolling_tmpl.h"
#endif
#endif

/* No pull: takes from `pressing` what the dashpot draws beyond the law's own attraction, and what it then dissipates
 * less from the sum. */
LANES_INLINE real NAME(without_pull)(const struct NAME(law) * law, real u, real delta, real pressing,
                                     struct NAME(sums) * sums)
{
    const real cut = real_smaller(NAME(normal_friction_limit)(&law->normal, delta, pressing), real_all(0.0));
    const real per = real_all(PER_PAIR ? (scalar)1 : law->inv_gamma_n);
    sums->normal = real_fma(cut * per, u, sums->normal);
    return pressing + cut;
}

/* From both sides to what the law wants to know. */
LANES_INLINE struct NAME(meeting) NAME(meet)(const struct NAME(law) * law, const struct NAME(sides) * of)
{
    const real zero = real_all(0.0), delta = SINGLE ? of->delta : real_larger(of->delta, zero);
    const real_mask active = real_greater(delta, zero);
    struct NAME(meeting) at = {.delta = delta};
    (void)law;
    (void)active;
    for (int c = 0; c < DIM; c++)
        at.n[c] = of->d[c] * of->inverse;
    const real along = NAME(inner)(of->g, at.n); /* mixed: open ones have no normal */
    at.u = SINGLE ? along : real_where(active, along);
#if FRICTIONAL
    real gt[DIM], none[DIM];
    (void)none;
    at.arm = of->arm;
    NAME(tangent)(&at, active, of->g, at.u, of->w, gt, at.vt);
    NAME(tangent)(&at, active, of->lag, NAME(inner)(of->lag, at.n), of->lag_w, none, at.lag);
#if DIM == 3
    NAME(turning)(law, of, gt, &at);
#endif
#if ROLLING
    NAME(rolls)(of, active, &at);
#endif
#endif
    return at;
}

/* First half of the law for one set of contacts. Open ones have the overlap 0, for which the law gives no force and no
 * history. */
LANES_INLINE struct NAME(touch) NAME(touch)(const struct NAME(law) * law, const struct NAME(meeting) * at,
                                            const struct NAME(memory) * memory, struct NAME(sums) * sums)
{
    struct NAME(touch) touch;
    const real zero = real_all(0.0), delta = at->delta, u = at->u;
    (void)zero;
    for (int c = 0; c < DIM; c++)
        touch.n[c] = at->n[c];
#if PER_PAIR
    const struct NAME(pair) pair = NAME(pair_of)(&law->normal, delta, real_load(memory->root_mass),
                                                 real_load(memory->radius), &memory->normal, &sums->own);
    const real gamma_n = pair.gamma_n;
    sums->normal = real_fma(u * gamma_n, u, sums->normal);
    real elastic = pair.elastic;
#else
    const real gamma_n = real_all(law->gamma_n);
    sums->normal = real_fma(u, u, sums->normal);
    real elastic = NAME(normal_elastic)(&law->normal, delta, &memory->normal, &sums->own);
#endif
    touch.pressing = real_fma(gamma_n, u, -elastic);
    if (law->no_pull)
        touch.pressing = NAME(without_pull)(law, u, delta, touch.pressing, sums);
#if FRICTIONAL
    const real limiting = law->elastic_limit ? -elastic : touch.pressing;
    real limit = real_larger(NAME(normal_friction_limit)(&law->normal, delta, limiting), zero);
    touch.active = real_greater(delta, zero);
    touch.arm = at->arm;
    struct NAME(travel) travel;
    NAME(travel)(law, at, memory, &travel);
#if MINDLIN
    NAME(test)(law, &pair, at, &travel, limit, memory, &touch, sums);
#else
    NAME(test)(law, at, &travel, limit, memory, &touch, sums);
#endif
#if ROLLING
    NAME(roll)(law, at, &travel, limit, memory, &touch, sums);
#endif
#endif
    return touch;
}

/* Second half. */
LANES_INLINE struct NAME(contact_result) NAME(force)(const struct NAME(law) * law, const struct NAME(touch) * touch,
                                                     const struct NAME(memory) * memory, struct NAME(sums) * sums)
{
    struct NAME(contact_result) result;
#if FRICTIONAL
    NAME(slip)(law, touch, memory, &result, sums);
#if ROLLING
    NAME(roll_slip)(law, touch, memory, &result, sums);
#endif
#else
    for (int c = 0; c < DIM; c++)
        result.force[c] = touch->pressing * touch->n[c];
    (void)law;
    (void)memory;
    (void)sums;
#endif
    return result;
}

/* Adds the sums to the totals; they start anew. */
LANES_INLINE void NAME(sums_close)(struct NAME(sums) * sums, struct NAME(totals) * totals)
{
    NAME(close)(&sums->normal, &totals->normal);
    NAME(normal_sums_close)(&sums->own, &totals->own);
#if FRICTIONAL
    NAME(friction_sums_close)(sums, totals);
#endif
#if ROLLING
    NAME(close)(&sums->rolling, &totals->rolling);
    NAME(close)(&sums->viscous_rolling, &totals->viscous_rolling);
#endif
}

/* Adds the totals as energies [J]. */
LANES_INLINE void NAME(totals_add)(const struct NAME(totals) * totals, const struct contact_law_constants *law,
                                   double dt_s, const struct law_units *units, struct contact_losses *losses)
{
    const double normal = PER_PAIR ? units->force * units->speed : law->gamma_n * units->speed * units->speed;
    losses->viscous_normal += normal * dt_s * NAME(doubles_sum)(totals->normal);
    losses->hysteresis += NAME(normal_hysteresis_j)(&totals->own, law->normal, units);
#if FRICTIONAL
    NAME(friction_totals_add)(totals, law, dt_s, units, losses);
#endif
#if ROLLING
    losses->rolling += units->force * NAME(doubles_sum)(totals->rolling);
    losses->viscous_rolling += units->force * NAME(doubles_sum)(totals->viscous_rolling);
#endif
}
