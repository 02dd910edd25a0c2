/* The kernels of a step, written once and compiled for each model and instruction set. The including file defines
 *   ISA         part of the names; lanes_<ISA>.h is included before: `real` holds LANES contacts
 *   DIM         2 | 3
 *   HYSTERETIC  0 | 1
 *   FRICTIONAL  0 | 1
 * Every contact's arithmetic is the same in every lane and instruction set, so forces and histories are the same bits;
 * only the sums of the losses differ in their order. There are no branches: open candidates select zeros.
 *
 * Tangential law [D eq. 2-4], second order in time: the spring is kept at the middle of the step, xi(k+1/2) =
 * xi(k-1/2) + v_t(k) dt, and brought to the step's end by xi(k) = xi(k-1/2) + v_t(k) dt/2, with v_t from velocities
 * predicted for the same time as the positions (no half-step lag). */

#undef NAME_
#undef NAME__
#undef NAME
#undef SPRINGS
#define NAME_(stem, isa, dim, h, f)  stem##_##isa##_##dim##_##h##_##f
#define NAME__(stem, isa, dim, h, f) NAME_(stem, isa, dim, h, f)
#define NAME(stem)                   NAME__(stem, ISA, DIM, HYSTERETIC, FRICTIONAL)

/* Components of the tangential spring, of rotations and of moments. */
#define SPRINGS (2 * DIM - 3)

#ifndef LANES_RSQRT
#define LANES_RSQRT
/* 1/sqrt(x) to about one unit in the last place: the seed is right to 1e-7, and the step's error is of third order.
 * The same bits in every instruction set, and much cheaper than square root and division in double. */
LANES_INLINE real lanes_rsqrt(real x, real seed)
{
    real y = seed;
    real e = real_fma(-x, y * y, real_all(1.0)); /* y = (1 - e)^(1/2) / sqrt(x) */
    return real_fma(real_fma(real_all(0.375), e, real_all(0.5)), e * y, y);
}
#endif

/* What one set of contacts needs beyond geometry; history, spring and sliding change in place. */
struct NAME(contact_state) {
    real history, spring[3], sliding; /* sliding: 1 or 0 */
};

struct NAME(contact_result) {
    real force[DIM], moment[3];
    real hysteresis, viscous_normal, viscous_tangential, friction; /* energy lost in this step */
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

/* The spring brought into the tangent plane of today [D], turned with the pair's mean spin about n, its length kept. */
LANES_INLINE void NAME(turn)(const real *n, const real *spin, real dt, const real *spring, real length2, real *turned)
{
    real along = NAME(dot)(spring, n), twist = dt * NAME(dot)(spin, n), p[3];
    for (int c = 0; c < 3; c++)
        p[c] = real_fma(-along, n[c], spring[c]);
    for (int c = 0; c < 3; c++)
        turned[c] = real_fma(twist, NAME(cross)(n, p, c), p[c]);
    /* sqrt(1 + e) by its series: e is the square of the turn in a step, so that e^4 is below rounding; bounded for
     * springs that stood almost along n */
    real turned2 = NAME(dot)(turned, turned);
    real e = real_smaller(length2 / turned2, real_all(1.5)) - real_all(1.0);
    real root = real_fma(e, real_fma(e, real_fma(e, real_all(0.0625), real_all(-0.125)), real_all(0.5)), real_all(1.0));
    real scale = real_select(mask_greater(turned2, real_all(0.0)), root, real_all(0.0));
    for (int c = 0; c < 3; c++)
        turned[c] = turned[c] * scale;
}
#endif

/* Tangential part. n: normal, g: relative velocity of the centres, u = g.n, w: a_i omega_i + a_j omega_j, spin:
 * (omega_i + omega_j)/2, normal_force and delta set the limit. Adds to the force, sets moment and losses.
 * pull = kt xi + gamma_t v_t is the reversed test force; a sliding contact keeps `factor` of it, and its spring slips
 * by q pull, q = (1 - factor)/kt, so that the law holds with the spring that is left. q = 0: it sticks. */
LANES_INLINE void NAME(tangential)(const struct contact_law_constants *law, mask active, real delta, real normal_force,
                                   const real *n, const real *g, real u, const real *w, const real *spin,
                                   struct NAME(contact_state) * state, struct NAME(contact_result) * result)
{
    const real zero = real_all(0.0), one = real_all(1.0), dt = real_all(law->dt), half = real_all(0.5 * law->dt);
    const real kt = real_all(law->kt), gamma_t = real_all(law->gamma_t);
    real vt[SPRINGS], before[SPRINGS], pull[SPRINGS], length2 = NAME(dot)(state->spring, state->spring);
#if DIM == 2
    /* tangent (-n1, n0); the spring is a number along it, so a rotating pair carries it along by itself */
    (void)u;
    (void)spin;
    vt[0] = real_fma(g[1], n[0], real_fma(-g[0], n[1], -w[0]));
    before[0] = state->spring[0];
#else
    for (int c = 0; c < 3; c++) /* g + n x w - u n */
        vt[c] = NAME(cross)(n, w, c) + real_fma(-u, n[c], g[c]);
    NAME(turn)(n, spin, dt, state->spring, length2, before);
#endif
    for (int c = 0; c < SPRINGS; c++)
        pull[c] = real_fma(kt, real_fma(half, vt[c], before[c]), gamma_t * vt[c]);
    real pull2 = NAME(dot)(pull, pull), power = NAME(dot)(pull, vt), vt2 = NAME(dot)(vt, vt);
    /* friction is limited by the normal force above the adhesion branch, never below 0 (docs/theory.md) */
    real limit = real_larger(zero, real_fma(real_all(law->kc), delta, normal_force));
    real bound = limit * real_select(mask_greater(state->sliding, zero), real_all(law->mu_d), real_all(law->mu_s));
    real square = real_larger(pull2, real_all(1e-30)); /* N^2; keeps the root's seed finite */
    real inverse = lanes_rsqrt(square, real_rsqrt_seed(square));
    mask slides = mask_and(active, mask_greater(pull2, bound * bound));
    real factor = real_select(slides, real_all(law->mu_d) * limit * inverse, one);
    real q = (one - factor) * real_all(law->inv_kt), kept = real_select(active, -factor, zero);
    state->sliding = real_select(slides, one, zero);
    real viscous = gamma_t * real_fma(dt, vt2, -q * power);
    /* with the mean of the spring over the step, the ledger closes in second order, jumps of the spring included */
    real friction = q * real_fma(pull2, real_fma(real_all(-0.5) * kt, q, one), -kt * half * power);
    result->viscous_tangential = real_select(active, viscous, zero);
    /* an opening contact loses what its spring held */
    result->friction = real_select(active, friction, real_all(0.5) * kt * length2);
    for (int c = 0; c < SPRINGS; c++) {
        state->spring[c] = real_select(active, real_fma(-q, pull[c], real_fma(dt, vt[c], before[c])), zero);
        pull[c] = kept * pull[c]; /* now the tangential force */
    }
#if DIM == 2
    result->force[0] = real_fma(-pull[0], n[1], result->force[0]);
    result->force[1] = real_fma(pull[0], n[0], result->force[1]);
    result->moment[0] = pull[0];
#else
    for (int c = 0; c < 3; c++) {
        result->force[c] = result->force[c] + pull[c];
        result->moment[c] = NAME(cross)(n, pull, c);
    }
#endif
}
#endif

/* One set of contacts: geometry and velocities in, forces out. Arguments as of `tangential`. */
LANES_INLINE struct NAME(contact_result)
    NAME(contact)(const struct contact_law_constants *law, real delta, const real *n, const real *g, const real *w,
                  const real *spin, struct NAME(contact_state) * state)
{
    struct NAME(contact_result) result;
    const real zero = real_all(0.0), gamma_n = real_all(law->gamma_n);
    mask active = mask_greater(delta, zero);
    real u = real_fma(g[1], n[1], g[0] * n[0]);
#if DIM == 3
    u = real_fma(g[2], n[2], u);
#endif
    real loading = real_all(law->k1) * delta;
#if HYSTERETIC
    /* [LH eq. 1.6]: loading k1 delta, un- and reloading k2 (delta - delta_0), adhesion branch -kc delta */
    real unloading = real_fma(real_all(law->k2), delta, -real_all(law->k2_minus_k1) * state->history);
    real adhesion = -real_all(law->kc) * delta;
    real elastic = real_larger(adhesion, real_smaller(loading, unloading));
    real moved = real_select(mask_at_least(adhesion, unloading), real_all(law->branch_ratio) * delta, state->history);
    real after = real_select(mask_at_least(unloading, loading), delta, moved);
    after = real_select(active, after, zero);
    real change = (after - state->history) * (after + state->history);
    result.hysteresis = real_select(mask_greater(change, zero), real_all(law->loading_loss) * change,
                                    -real_all(law->adhesion_loss) * change);
    state->history = after;
#else
    real elastic = loading;
    result.hysteresis = zero;
#endif
    real normal_force = real_fma(-gamma_n, u, elastic);
    result.viscous_normal = real_select(active, gamma_n * u * u * real_all(law->dt), zero);
    result.viscous_tangential = result.friction = zero;
    real acting = real_select(active, normal_force, zero);
    for (int c = 0; c < DIM; c++)
        result.force[c] = acting * n[c];
#if FRICTIONAL
    NAME(tangential)(law, active, delta, normal_force, n, g, u, w, spin, state, &result);
#else
    (void)w;
    (void)spin;
    (void)state;
#endif
    return result;
}

LANES_INLINE struct NAME(contact_state) NAME(state_load)(const struct contact_list *list, int k)
{
    struct NAME(contact_state) state = {0};
    (void)list;
    (void)k;
#if HYSTERETIC
    state.history = real_load(list->history + k);
#endif
#if FRICTIONAL
    state.sliding = real_load(list->sliding + k);
    for (int c = 0; c < SPRINGS; c++)
        state.spring[c] = real_load(list->spring[c] + k);
#endif
    return state;
}

LANES_INLINE void NAME(store)(struct contact_list *list, int k, const struct NAME(contact_state) * state,
                              const struct NAME(contact_result) * result)
{
    (void)state;
#if HYSTERETIC
    real_store(list->history + k, state->history);
#endif
#if FRICTIONAL
    real_store(list->sliding + k, state->sliding);
    for (int c = 0; c < SPRINGS; c++)
        real_store(list->spring[c] + k, state->spring[c]);
#endif
    if (!list->keep_forces)
        return;
    for (int c = 0; c < DIM; c++)
        real_store(list->force[c] + k, result->force[c]);
#if FRICTIONAL
    for (int c = 0; c < SPRINGS; c++)
        real_store(list->moment[c] + k, result->moment[c]);
#endif
}

/* Sums of the losses, one per lane. */
struct NAME(sums) {
    real hysteresis, viscous_normal, viscous_tangential, friction;
};

LANES_INLINE void NAME(sums_add)(struct NAME(sums) * sums, const struct NAME(contact_result) * result)
{
    sums->hysteresis = sums->hysteresis + result->hysteresis;
    sums->viscous_normal = sums->viscous_normal + result->viscous_normal;
    sums->viscous_tangential = sums->viscous_tangential + result->viscous_tangential;
    sums->friction = sums->friction + result->friction;
}

LANES_INLINE void NAME(sums_close)(const struct NAME(sums) * sums, struct contact_losses *losses)
{
    losses->hysteresis += real_sum(sums->hysteresis);
    losses->viscous_normal += real_sum(sums->viscous_normal);
    losses->viscous_tangential += real_sum(sums->viscous_tangential);
    losses->friction += real_sum(sums->friction);
}

struct NAME(packed) {
    real x[DIM], v[DIM];
#if FRICTIONAL
    real omega[SPRINGS], radius;
#endif
};

/* Position, velocity, rotation of LANES particles from their records (particles.h). */
LANES_INLINE struct NAME(packed) NAME(unpack)(const double *record, const uint32_t *row)
{
    struct NAME(packed) to;
    real block[4];
    lanes_gather4(record, row, block);
#if DIM == 2
    to.x[0] = block[0];
    to.x[1] = block[1];
    to.v[0] = block[2];
    to.v[1] = block[3];
#if FRICTIONAL
    lanes_gather4(record + RECORD_ROTATION(2), row, block);
    to.omega[0] = block[0];
    to.radius = block[1];
#endif
#else
    for (int c = 0; c < 3; c++)
        to.x[c] = block[c];
#if FRICTIONAL
    to.radius = block[3];
#endif
    lanes_gather4(record + 4, row, block);
    for (int c = 0; c < 3; c++)
        to.v[c] = block[c];
#if FRICTIONAL
    lanes_gather4(record + RECORD_ROTATION(3), row, block);
    for (int c = 0; c < 3; c++)
        to.omega[c] = block[c];
#endif
#endif
    return to;
}

/* Adds forces and moments to the sums of i and, reversed, of j, one contact after the other. Lanes of padding pairs add
 * zeros to the padding particles. */
LANES_INLINE void NAME(add_pair)(double *force, const uint32_t *i, const uint32_t *j,
                                 const struct NAME(contact_result) * result)
{
#if DIM == 2 && !FRICTIONAL
    lanes_add2(force, i, j, result->force);
#elif DIM == 2
    static const double sign[4] = {-1, -1, 1, 1};
    real column[4] = {result->force[0], result->force[1], result->moment[0], real_all(0.0)};
    lanes_add4(force, i, j, column, sign);
#else
    static const double opposite[4] = {-1, -1, -1, 1};
    real column[4] = {result->force[0], result->force[1], result->force[2], real_all(0.0)};
    lanes_add4(force, i, j, column, opposite);
#if FRICTIONAL
    static const double alike[4] = {1, 1, 1, 1};
    real moment[4] = {result->moment[0], result->moment[1], result->moment[2], real_all(0.0)};
    lanes_add4(force + FORCE_MOMENT(3), i, j, moment, alike);
#endif
#endif
}

/* First half of a set of pairs: all that comes from the records. */
struct NAME(approach) {
    real d[DIM], g[DIM], w[3], spin[3];
    real d2, seed; /* squared distance, first guess of its inverse root */
};

LANES_INLINE struct NAME(approach) NAME(approach)(const double *record, const struct contact_list *pairs, int k)
{
    struct NAME(approach) to = {0};
    struct NAME(packed) i = NAME(unpack)(record, pairs->row_i + k), j = NAME(unpack)(record, pairs->row_j + k);
    for (int c = 0; c < DIM; c++) {
        to.d[c] = i.x[c] - j.x[c];
        to.g[c] = i.v[c] - j.v[c];
    }
    to.d2 = real_fma(to.d[1], to.d[1], to.d[0] * to.d[0]);
#if DIM == 3
    to.d2 = real_fma(to.d[2], to.d[2], to.d2);
#endif
    to.seed = real_rsqrt_seed(to.d2);
#if FRICTIONAL
    for (int c = 0; c < SPRINGS; c++) {
        to.w[c] = real_fma(i.radius, i.omega[c], j.radius * j.omega[c]);
        to.spin[c] = real_all(0.5) * (i.omega[c] + j.omega[c]);
    }
#endif
    return to;
}

/* Second half: the law. Changes and stores the contacts' state. */
LANES_INLINE struct NAME(contact_result)
    NAME(act)(const struct NAME(approach) * from, const struct contact_law_constants *law, struct contact_list *pairs,
              int k)
{
    real n[DIM], inverse = lanes_rsqrt(from->d2, from->seed), distance = from->d2 * inverse;
    for (int c = 0; c < DIM; c++)
        n[c] = from->d[c] * inverse;
    struct NAME(contact_state) state = NAME(state_load)(pairs, k);
    struct NAME(contact_result) result =
        NAME(contact)(law, real_load(pairs->reach + k) - distance, n, from->g, from->w, from->spin, &state);
    NAME(store)(pairs, k, &state, &result);
    return result;
}

/* The sets of contacts are independent but for the sums, and each is one long chain of operations. The chain is cut in
 * three that run at a time: while set k is acted on, set k + 1 is approached and set k - 1 added up. The approach
 * behind the last set reads what padding there is (ARRAY_PADDING) and is not used. */
static void NAME(pair)(const struct particles *p, struct contact_list *pairs, int first, int last,
                       const struct contact_law_constants *law_in, void *force, struct contact_losses *losses)
{
    const struct contact_law_constants law = *law_in;
    struct NAME(sums) sums = {real_all(0.0), real_all(0.0), real_all(0.0), real_all(0.0)};
    const int start = first * SET_WIDTH, end = last * SET_WIDTH;
    if (start >= end)
        return;
    struct NAME(approach) next = NAME(approach)(p->record, pairs, start);
    struct NAME(contact_result) done = {0};
    for (int k = start; k < end; k += LANES) {
        struct NAME(approach) now = next;
        next = NAME(approach)(p->record, pairs, k + LANES);
        struct NAME(contact_result) result = NAME(act)(&now, &law, pairs, k);
        if (k > start)
            NAME(add_pair)(force, pairs->row_i + k - LANES, pairs->row_j + k - LANES, &done);
        NAME(sums_add)(&sums, &result);
        done = result;
    }
    NAME(add_pair)(force, pairs->row_i + end - LANES, pairs->row_j + end - LANES, &done);
    NAME(sums_close)(&sums, losses);
}

/* Adds the forces and moments of a wall's contacts to its particles, and its own force up. */
static void NAME(add_wall)(struct particles *p, struct wall *wall)
{
    const struct contact_list *list = &wall->contacts;
    double sum = 0;
    for (int k = 0; k < list->count; k++) {
        double *to = lanes_half(p->force, list->row_i[k]);
        for (int c = 0; c < DIM; c++)
            to[c] += list->force[c][k];
#if FRICTIONAL
        for (int c = 0; c < SPRINGS; c++)
            to[FORCE_MOMENT(DIM) + c] += list->moment[c][k];
#endif
        sum += list->force[wall->axis][k];
    }
    wall->force = sum * wall->inward;
}

/* The same law against one flat wall: delta = a - distance; the wall moves along its normal and does not rotate. */
static void NAME(wall)(struct particles *p, struct wall *wall, const struct contact_law_constants *law_in,
                       struct contact_losses *losses)
{
    struct contact_list *contacts = &wall->contacts;
    const struct contact_law_constants law = *law_in;
    struct NAME(sums) sums = {real_all(0.0), real_all(0.0), real_all(0.0), real_all(0.0)};
    real n[DIM], inward = real_all(wall->inward);
    for (int c = 0; c < DIM; c++)
        n[c] = real_all(c == wall->axis ? wall->inward : 0.0);
    for (int k = 0; k < contacts->count; k += LANES) {
        indices i = indices_load(contacts->i + k);
        real g[DIM], w[3] = {0}, spin[3] = {0};
        for (int c = 0; c < DIM; c++)
            g[c] = real_gather(p->v[c], i) - real_all(c == wall->axis ? wall->v : 0.0);
        real a_i = real_gather(p->radius, i);
        real distance = inward * (real_gather(p->x[wall->axis], i) - real_all(wall->x));
#if FRICTIONAL
        for (int c = 0; c < SPRINGS; c++) {
            real o_i = real_gather(p->omega[c], i);
            w[c] = a_i * o_i;
            spin[c] = real_all(0.5) * o_i;
        }
#endif
        struct NAME(contact_state) state = NAME(state_load)(contacts, k);
        struct NAME(contact_result) result = NAME(contact)(&law, a_i - distance, n, g, w, spin, &state);
        NAME(store)(contacts, k, &state, &result);
        NAME(sums_add)(&sums, &result);
    }
    NAME(sums_close)(&sums, losses);
    NAME(add_wall)(p, wall);
}

/* Writes the records of LANES particles from i on. */
LANES_INLINE void NAME(pack)(struct particles *p, int i, const real *x, const real *v, const real *omega)
{
    enum { STRIDE = RECORD_STRIDE(DIM, FRICTIONAL) };
    double *to = p->record + (size_t)i * STRIDE;
    (void)omega;
#if DIM == 2
    const real block[4] = {x[0], x[1], v[0], v[1]};
    lanes_store4(to, STRIDE, block);
#if FRICTIONAL
    const real rotation[4] = {omega[0], real_load(p->radius + i), real_all(0.0), real_all(0.0)};
    lanes_store4(to + RECORD_ROTATION(2), STRIDE, rotation);
#endif
#else
    const real block[4] = {x[0], x[1], x[2], real_load(p->radius + i)}, second[4] = {v[0], v[1], v[2], real_all(0.0)};
    lanes_store4(to, STRIDE, block);
    lanes_store4(to + 4, STRIDE, second);
#if FRICTIONAL
    const real rotation[4] = {omega[0], omega[1], omega[2], real_all(0.0)};
    lanes_store4(to + RECORD_ROTATION(3), STRIDE, rotation);
#endif
#endif
}

/* x += v dt + a dt^2/2, v and omega predicted for the end of the step; packs the records. */
static bool NAME(drift)(struct particles *p, double dt_s, double reach_m)
{
    const real dt = real_all(dt_s), half = real_all(0.5 * dt_s), limit2 = real_all(reach_m * reach_m);
    bool near = true;
    memset(p->force, 0, (size_t)p->count * FORCE_STRIDE(DIM, FRICTIONAL) * sizeof(double));
    for (int i = 0; i < p->count; i += LANES) {
        real x[DIM], v[DIM], omega[3] = {0}, moved2 = real_all(0.0);
        for (int c = 0; c < DIM; c++) {
            real a = real_load(p->a[c] + i), before = real_load(p->v[c] + i);
            x[c] = real_load(p->x[c] + i) + dt * (before + half * a);
            v[c] = before + dt * a;
            real moved = x[c] - real_load(p->x_list[c] + i);
            moved2 = moved2 + moved * moved;
            real_store(p->x[c] + i, x[c]);
            real_store(p->v[c] + i, v[c]);
        }
#if FRICTIONAL
        for (int c = 0; c < SPRINGS; c++) {
            omega[c] = real_load(p->omega[c] + i) + dt * real_load(p->alpha[c] + i);
            real_store(p->omega[c] + i, omega[c]);
        }
#endif
        NAME(pack)(p, i, x, v, omega);
        near = near && mask_all(mask_at_least(limit2, moved2)); /* false for NaN too */
    }
    return !near;
}

/* Accelerations from the summed forces, background damping and gravity; corrects v and omega by the change of
 * acceleration. Returns the power that the background takes [W]. */
static double NAME(kick)(struct particles *p, const struct kick_constants *constants)
{
    const real half = real_all(0.5 * constants->dt), gamma_b = real_all(constants->gamma_b);
    enum { STRIDE = FORCE_STRIDE(DIM, FRICTIONAL) };
    real power = real_all(0.0);
    for (int i = 0; i < p->count; i += LANES) {
        const double *sums = (const double *)p->force + (size_t)i * STRIDE;
        real force[4], inv_mass = real_load(p->inv_mass + i), mass = real_load(p->mass + i), v2 = real_all(0.0);
#if DIM == 2 && !FRICTIONAL
        lanes_load2(sums, force);
#else
        lanes_load4(sums, STRIDE, force);
#endif
        for (int c = 0; c < DIM; c++) {
            real v = real_load(p->v[c] + i), before = real_load(p->a[c] + i);
            real a = (force[c] - gamma_b * v + real_all(constants->gravity[c]) * mass) * inv_mass;
            v2 = v2 + v * v;
            real_store(p->v[c] + i, v + half * (a - before));
            real_store(p->a[c] + i, a);
        }
        power = power + gamma_b * v2;
#if FRICTIONAL
        real radius = real_load(p->radius + i), inv_inertia = real_load(p->inv_inertia + i);
        real damping = real_all(constants->gamma_br) * radius * radius, omega2 = real_all(0.0);
#if DIM == 2
        real torque[1] = {force[2]};
#else
        real torque[4];
        lanes_load4(sums + FORCE_MOMENT(3), STRIDE, torque);
#endif
        for (int c = 0; c < SPRINGS; c++) {
            real omega = real_load(p->omega[c] + i), before = real_load(p->alpha[c] + i);
            real alpha = (-radius * torque[c] - damping * omega) * inv_inertia;
            omega2 = omega2 + omega * omega;
            real_store(p->omega[c] + i, omega + half * (alpha - before));
            real_store(p->alpha[c] + i, alpha);
        }
        power = power + damping * omega2;
#endif
    }
    return real_sum(power);
}
