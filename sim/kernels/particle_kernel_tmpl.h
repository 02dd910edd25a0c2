/* Drift and kick: what a step does to the particles themselves; and their records for the contacts. Positions and
 * velocities are summed up in double, or, mixed, in the integers and floats that contacts have and a rest of each
 * (particles.h); forces and accelerations are `real`. Parameters as of contact_law_tmpl.h. */

/* Asks for what `pack` will write a few turns from now: lines that are only written are not fetched ahead by
 * themselves. */
LANES_INLINE void NAME(pack_ahead)(const struct particles *p, int i)
{
    enum { AHEAD = 64, BYTES = RECORD_STRIDE(DIM, FRICTIONAL, SINGLE) * (int)sizeof(double) };
    const char *record = (const char *)p->record + (size_t)(i + AHEAD) * BYTES;
    for (int b = 0; b < LANES * BYTES; b += 64)
        __builtin_prefetch(record + b, 1);
}

/* How LANES particles move, as contacts want to know it: positions (mixed: u), predicted velocities, and with friction
 * their lag (particles.h). */
struct NAME(motion) {
    real x[DIM], v[DIM];
#if FRICTIONAL
    real omega[SPRINGS], lag[LAG_COLUMNS(DIM, SINGLE)];
#endif
};

/* Writes views and records of LANES particles from i on. */
LANES_INLINE void NAME(pack)(struct particles *p, int i, const struct NAME(motion) * m)
{
    enum { STRIDE = RECORD_STRIDE(DIM, FRICTIONAL, SINGLE) };
    const real zero = real_all(0.0), *x = m->x, *v = m->v;
    const size_t at = NAME(view_at)((size_t)i);
    double *to = (double *)p->record + (size_t)i * STRIDE;
    (void)zero;
    for (int c = 0; c < DIM; c++) {
#if SINGLE
        real_store((float *)p->view_u[c] + at, x[c]);
#endif
        real_store((scalar *)p->view_v[c] + at, v[c]);
    }
#if FRICTIONAL
    const real *omega = m->omega, *lag = m->lag;
    for (int c = 0; c < LAG_COLUMNS(DIM, SINGLE); c++)
        real_store((scalar *)p->view_lag[c] + at, lag[c]);
    for (int c = 0; c < SPRINGS; c++)
        real_store((scalar *)p->view_omega[c] + at, omega[c]);
#endif
#if SINGLE && DIM == 2 && FRICTIONAL
    const real record[8] = {x[0], x[1], v[0], v[1], omega[0], lag[0], lag[1], lag[2]};
    f32_store8((float *)to, record);
#elif SINGLE && DIM == 2
    const real record[4] = {x[0], x[1], v[0], v[1]};
    f32_store4((float *)to, record);
#elif SINGLE && FRICTIONAL
    const real record[16] = {x[0],     x[1],   x[2],   v[0],   v[1], v[2], omega[0], omega[1],
                             omega[2], lag[0], lag[1], lag[2], zero, zero, zero,     zero};
    f32_store16((float *)to, record);
#elif SINGLE
    const real record[8] = {x[0], x[1], x[2], v[0], v[1], v[2], zero, zero};
    f32_store8((float *)to, record);
#elif DIM == 2
    const real block[4] = {x[0], x[1], v[0], v[1]};
    f64_store4(to, STRIDE, block);
#if FRICTIONAL
    const real rotation[4] = {omega[0], lag[0], lag[1], lag[2]};
    f64_store4(to + 4, STRIDE, rotation);
#endif
#else
#if FRICTIONAL
    const real lag0 = lag[0], lag1 = lag[1];
    const real rotation[4] = {omega[0], omega[1], omega[2], lag[2]}, last[4] = {lag[3], lag[4], lag[5], zero};
    f64_store4(to + 8, STRIDE, rotation);
    f64_store4(to + 12, STRIDE, last);
#else
    const real lag0 = zero, lag1 = zero;
#endif
    const real block[4] = {x[0], x[1], x[2], lag0}, second[4] = {v[0], v[1], v[2], lag1};
    f64_store4(to, STRIDE, block);
    f64_store4(to + 4, STRIDE, second);
#endif
}

/* Forces and moments of LANES particles: their rows and columns; the rows start anew from zero. */
LANES_INLINE void NAME(take_sums)(struct particles *p, int i, real *force, real *moment)
{
    enum { STRIDE = SUMS_BYTES(DIM, FRICTIONAL, SINGLE) / (int)sizeof(scalar) };
    scalar *rows = (scalar *)p->force + (size_t)i * STRIDE;
    scalar *own = (scalar *)((char *)p->force + PARTICLES_COLUMNS_OFFSET(p->n_rows, DIM, FRICTIONAL, SINGLE)) +
                  NAME(sum_at)((size_t)i);
    real row[8];
    (void)moment;
#if DIM == 2 && !FRICTIONAL
    REAL(load2)(rows, row);
#elif SINGLE && DIM == 3 && FRICTIONAL
    f32_load8(rows, row);
#elif SINGLE
    f32_load4(rows, row);
#else
    f64_load4(rows, STRIDE, row);
#if DIM == 3 && FRICTIONAL
    f64_load4(rows + FORCE_MOMENT(3), STRIDE, row + FORCE_MOMENT(3));
#endif
#endif
    for (int c = 0; c < DIM; c++, own += PARTICLES_BLOCK)
        force[c] = row[c] + real_load(own);
#if FRICTIONAL
    for (int c = 0; c < SPRINGS; c++, own += PARTICLES_BLOCK)
        moment[c] = row[FORCE_MOMENT(DIM) + c] + real_load(own);
#endif
    memset(rows, 0, LANES * STRIDE * sizeof *rows);
}

/* What LANES particles have been pushed with. */
struct NAME(push) {
    real a[DIM], alpha[3];
};

/* Constants of a kick in all lanes, and what it sums: v^2, and a^2 omega^2. */
struct NAME(kick) {
    f64 half;
    real minus_gamma_b, gravity[3], minus_slowing;
    f64 speed_unit; /* mixed; particles.h */
    struct NAME(doubles) v2, spin2;
};

LANES_INLINE struct NAME(kick) NAME(kick_of)(const struct particles *p, const struct kick_constants *k)
{
    const double unit = p->speed_unit, damped = unit / p->force_unit;
    return (struct NAME(kick)){
        .half = f64_all(0.5 * k->dt),
        .minus_gamma_b = real_all(-k->gamma_b * damped),
        .gravity = {real_all(k->gravity[0] / unit), real_all(k->gravity[1] / unit), real_all(k->gravity[2] / unit)},
        .minus_slowing = real_all(-2.5 * k->gamma_br * damped), /* a^2/I = 2.5/m */
        .speed_unit = f64_all(unit),
        .v2 = NAME(doubles_of)(real_all(0.0)),
        .spin2 = NAME(doubles_of)(real_all(0.0)),
    };
}

/* What the background takes [W]. */
LANES_INLINE double NAME(power)(const struct NAME(kick) * kick, const struct particles *p,
                                const struct kick_constants *k)
{
    const double unit2 = p->speed_unit * p->speed_unit;
    return unit2 * (k->gamma_b * NAME(doubles_sum)(kick->v2) + k->gamma_br * NAME(doubles_sum)(kick->spin2));
}

/* Accelerations from forces, background damping and gravity. */
LANES_INLINE struct NAME(push) NAME(pushed)(struct particles *p, int i, struct NAME(kick) * kick)
{
    const size_t at = NAME(view_at)((size_t)i);
    struct NAME(push) to;
    real force[DIM], moment[3], inv_mass = real_load((const scalar *)p->view_inv_mass + i), v2 = real_all(0.0);
    NAME(take_sums)(p, i, force, moment);
    for (int c = 0; c < DIM; c++) {
        real v = real_load((const scalar *)p->view_v[c] + at);
        to.a[c] = real_fma(real_fma(kick->minus_gamma_b, v, force[c]), inv_mass, kick->gravity[c]);
        v2 = real_fma(v, v, v2);
    }
    kick->v2 = NAME(doubles_add)(kick->v2, NAME(doubles_of)(v2));
#if FRICTIONAL
    const real minus_lever = real_load((const scalar *)p->view_minus_lever + i);
    const real minus_slowing = kick->minus_slowing * inv_mass, radius = real_load((const scalar *)p->view_radius + at);
    real omega2 = real_all(0.0);
    for (int c = 0; c < SPRINGS; c++) {
        real omega = real_load((const scalar *)p->view_omega[c] + at);
        to.alpha[c] = real_fma(minus_lever, moment[c], minus_slowing * omega);
        omega2 = real_fma(omega, omega, omega2);
    }
    kick->spin2 = NAME(doubles_add)(kick->spin2, NAME(doubles_of)(radius * radius * omega2));
#endif
    return to;
}

/* Constants of a drift in all lanes, and whether all particles so far are near: no further than sqrt(limit2) from where
 * the lists were built (mixed: quanta), and not NaN. */
struct NAME(drift) {
    real_mask near;
    real half, limit2;
    real since;       /* 1; 0 at the start of a stage, whose springs are those of now and not of half a step ahead */
    real twice_since; /* 2 - since */
    real made_up;     /* part of what pairs leave out of lags that goes over to what is predicted: 1, or 0 */
#if SINGLE
    real push;                /* from the middle of the step before to that of the one to come */
    real quanta, quanta_rest; /* dt, in quanta per unit of speed; and what rounding left out */
#else
    f64 dt, before_half;
#endif
};

LANES_INLINE struct NAME(drift) NAME(drift_of)(const struct particles *p, double dt_s, double before_s, double reach_m)
{
    const real zero = real_all(0.0);
    const double reach = SINGLE ? reach_m / p->quantum : reach_m;
    struct NAME(drift) to = {.near = real_at_least(zero, zero), .half = real_all(0.5 * dt_s)};
    to.limit2 = real_all(reach * reach);
    to.since = real_all(before_s > 0 ? 1.0 : 0.0);
    to.twice_since = real_all(before_s > 0 ? 1.0 : 2.0);
    to.made_up = real_all(before_s > 0 && p->springs ? 1.0 : 0.0);
#if SINGLE
    const double quanta = dt_s / p->quantum * p->speed_unit;
    to.push = real_all(0.5 * (before_s + dt_s));
    to.quanta = real_all(quanta);
    to.quanta_rest = real_all(quanta - (double)(float)quanta);
#else
    to.dt = f64_all(dt_s);
    to.before_half = f64_all(0.5 * before_s);
#endif
    return to;
}

/* One component of velocity or rotation: the predicted one of the step before and of this one, and that of the middle
 * (mixed: how much more it is than the one before). */
struct NAME(pace) {
    real before, now, middle;
};

/* view: what was predicted; kept: the velocity of the middle of the step before, or settled; mixed: what it is more
 * than the predicted one, and sums of what is small go first, so that little is lost. */
LANES_INLINE struct NAME(pace)
    NAME(pace)(const struct NAME(drift) * drift, const void *view, scalar *kept, real a, bool settled)
{
    struct NAME(pace) to = {.before = real_load((const scalar *)view), .middle = real_load(kept)};
#if SINGLE
    (void)settled;
    to.middle = real_fma(drift->push, a, to.middle);
    to.now = to.before + real_fma(drift->half, a, to.middle);
#else
    if (!settled)
        to.middle = real_fma(drift->before_half, a, to.middle);
    to.middle = real_fma(drift->half, a, to.middle);
    to.now = real_fma(drift->half, a, to.middle);
#endif
    return to;
}

/* For the step to come; returns what is kept. */
LANES_INLINE real NAME(pace_keep)(const struct NAME(pace) * pace, scalar *kept)
{
#if SINGLE
    const real keep = (pace->before - pace->now) + pace->middle;
#else
    const real keep = pace->middle;
#endif
    real_store(kept, keep);
    return keep;
}

#if SINGLE
/* One component of the position, in whole quanta, which it returns, and the rest. */
LANES_INLINE real NAME(place)(const struct NAME(drift) * drift, const int32_t *u, float *rest, real v, real v_rest)
{
    const real small = real_fma(drift->quanta, v_rest, real_fma(drift->quanta_rest, v, real_load(rest)));
    const real whole = f32_round(real_fma(drift->quanta, v, small));
    real_store(rest, real_fma(drift->quanta, v, -whole) + small);
    return f32_sum_of_integers(real_load((const float *)u), f32_to_integers(whole));
}
#endif

#if FRICTIONAL
/* 2 v(k+1/2) - v*(k) - v*(k+1) */
LANES_INLINE real NAME(lag)(const struct NAME(drift) * drift, const struct NAME(pace) * pace)
{
#if SINGLE
    return real_fma(real_all(2.0), pace->middle, real_fma(drift->twice_since, pace->before, -pace->now));
#else
    return real_fma(real_all(2.0), pace->middle - pace->now, real_fma(-drift->since, pace->before, pace->now));
#endif
}

/* Component c of the rotations, and of the lags as contacts get them; of pairs, and then what is predicted makes up for
 * what pairs leave out. */
LANES_INLINE void NAME(turned)(struct particles *p, int i, const struct NAME(drift) * drift,
                               const struct NAME(push) * push, bool settled, int c, struct NAME(pace) * v,
                               struct NAME(motion) * to)
{
    const real lag = NAME(lag)(drift, v);
    to->lag[c] = lag;
    if (c >= SPRINGS)
        return;
    scalar *kept = SINGLE ? (scalar *)p->omega_rest[c] + i : (scalar *)p->omega[c] + i;
    struct NAME(pace) omega =
        NAME(pace)(drift, (const scalar *)p->view_omega[c] + NAME(view_at)((size_t)i), kept, push->alpha[c], settled);
    const real spin = NAME(lag)(drift, &omega);
#if SINGLE && DIM == 3
    to->lag[c] = f32_pair(lag, spin);
    v->now = real_fma(drift->made_up, lag - f32_first(to->lag[c]), v->now);
    omega.now = real_fma(drift->made_up, spin - f32_second(to->lag[c]), omega.now);
#else
    to->lag[DIM + c] = spin;
#endif
    to->omega[c] = omega.now;
    (void)NAME(pace_keep)(&omega, kept);
}
#endif

/* Drift: velocities at the middle of the step to come, positions and predicted velocities at its end. `settled`: the
 * velocities of p are those of now, not of the middle of the step before. */
LANES_INLINE void NAME(drifted)(struct particles *p, int i, struct NAME(drift) * drift, const struct NAME(push) * push,
                                bool settled)
{
    const size_t at = NAME(view_at)((size_t)i);
    struct NAME(motion) to;
    real moved2 = real_all(0.0);
    for (int c = 0; c < DIM; c++) {
        scalar *kept = SINGLE ? (scalar *)p->v_rest[c] + i : (scalar *)p->v[c] + i;
        struct NAME(pace) v = NAME(pace)(drift, (const scalar *)p->view_v[c] + at, kept, push->a[c], settled);
#if FRICTIONAL
        NAME(turned)(p, i, drift, push, settled, c, &v, &to);
#endif
        const real keep = NAME(pace_keep)(&v, kept);
        to.v[c] = v.now;
#if SINGLE
        to.x[c] = NAME(place)(drift, p->view_u[c] + at, p->u_rest[c] + i, v.now, keep);
        real moved = f32_of_integers(to.x[c]);
#else
        to.x[c] = f64_fma(drift->dt, keep, f64_load(p->x[c] + i));
        f64_store(p->x[c] + i, to.x[c]);
        real moved = to.x[c] - f64_load(p->x_list[c] + i);
#endif
        moved2 = real_fma(moved, moved, moved2);
    }
    drift->near = real_and(drift->near, real_at_least(drift->limit2, moved2));
    NAME(pack_ahead)(p, i);
    NAME(pack)(p, i, &to);
}

/* What stands behind the last particle, up to a whole block, does not fall: its places are in no list. */
static void NAME(hold_padding)(struct particles *p, const struct kick_constants *k)
{
    const size_t count = (size_t)p->count, rest = (size_t)(-p->count & (SET_WIDTH - 1));
    if (k->gravity[0] == 0 && k->gravity[1] == 0 && k->gravity[2] == 0)
        return;
    for (int c = 0; c < DIM; c++) {
#if SINGLE
        memset(p->view_u[c] + NAME(view_at)(count), 0, rest * sizeof(int32_t));
        memset(p->u_rest[c] + count, 0, rest * sizeof(float));
        memset(p->v_rest[c] + count, 0, rest * sizeof(float));
#else
        memcpy(p->x[c] + count, p->x_list[c] + count, rest * sizeof(double));
#endif
        memset(p->v[c] + count, 0, rest * sizeof(double));
        memset(p->a[c] + count, 0, rest * sizeof(double));
        memset((scalar *)p->view_v[c] + NAME(view_at)(count), 0, rest * sizeof(scalar));
    }
}

/* Accelerations in units of speed over s. */
LANES_INLINE real NAME(in_units)(const struct particles *p, const double *a)
{
    struct NAME(doubles) from = NAME(doubles_load)(a);
    for (int h = 0; SINGLE && h < PARTS; h++)
        from.part[h] = f64_all(1 / p->speed_unit) * from.part[h];
    return REAL(narrow)(from.part);
}

/* The loops here go over a copy of the particles' pointers, which no store can change. */
static bool NAME(drift)(struct particles *p, double dt_s, double before_s, double reach_m)
{
    struct particles of = *p;
    struct NAME(drift) drift = NAME(drift_of)(p, dt_s, before_s, reach_m);
    for (int i = of.from; i < of.count; i += LANES) {
        struct NAME(push) push;
        for (int c = 0; c < DIM; c++)
            push.a[c] = NAME(in_units)(&of, of.a[c] + i);
#if FRICTIONAL
        for (int c = 0; c < SPRINGS; c++)
            push.alpha[c] = NAME(in_units)(&of, of.alpha[c] + i);
#endif
        NAME(drifted)(&of, i, &drift, &push, true);
    }
    return !REAL(mask_all)(drift.near);
}

/* One component of velocity or rotation at the end of a step. */
LANES_INLINE void NAME(settle)(const struct NAME(kick) * kick, int i, const void *view, const float *rest, real a,
                               double *acceleration, double *velocity)
{
    struct NAME(doubles) more = NAME(doubles_of)(a), middle;
#if SINGLE
    middle = NAME(doubles_add)(NAME(doubles_of)(real_load((const float *)view + NAME(view_at)((size_t)i))),
                               NAME(doubles_of)(real_load(rest + i)));
    for (int h = 0; h < PARTS; h++) {
        middle.part[h] = kick->speed_unit * middle.part[h];
        more.part[h] = kick->speed_unit * more.part[h];
    }
#else
    (void)view;
    (void)rest;
    middle = NAME(doubles_load)(velocity + i);
#endif
    NAME(doubles_store)(velocity + i, NAME(doubles_fma)(kick->half, more, middle));
    NAME(doubles_store)(acceleration + i, more);
}

static double NAME(kick)(struct particles *p, const struct kick_constants *constants)
{
    struct particles of = *p;
    struct NAME(kick) kick = NAME(kick_of)(p, constants);
    for (int i = of.from; i < of.count; i += LANES) {
        struct NAME(push) push = NAME(pushed)(&of, i, &kick);
        for (int c = 0; c < DIM; c++)
            NAME(settle)(&kick, i, of.view_v[c], of.v_rest[c], push.a[c], of.a[c], of.v[c]);
#if FRICTIONAL
        for (int c = 0; c < SPRINGS; c++)
            NAME(settle)(&kick, i, of.view_omega[c], of.omega_rest[c], push.alpha[c], of.alpha[c], of.omega[c]);
#endif
    }
    NAME(hold_padding)(&of, constants);
    return NAME(power)(&kick, p, constants);
}

/* Both in one pass: the kick of a step and the drift of the next. */
static bool NAME(advance)(struct particles *p, const struct kick_constants *constants, double dt_s, double reach_m,
                          double *background_w)
{
    struct particles of = *p;
    struct NAME(kick) kick = NAME(kick_of)(p, constants);
    struct NAME(drift) drift = NAME(drift_of)(p, dt_s, constants->dt, reach_m);
    for (int i = of.from; i < of.count; i += LANES) {
        struct NAME(push) push = NAME(pushed)(&of, i, &kick);
        NAME(drifted)(&of, i, &drift, &push, false);
    }
    NAME(hold_padding)(&of, constants);
    *background_w = NAME(power)(&kick, p, constants);
    return !REAL(mask_all)(drift.near);
}
