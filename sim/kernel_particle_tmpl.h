/* Drift and kick: what a step does to the particles themselves, in double; and their records for the contacts.
 * Parameters as of kernel_law_tmpl.h. */

/* Asks for what `pack` will write a few turns from now: lines that are only written are not fetched ahead by
 * themselves. */
LANES_INLINE void NAME(pack_ahead)(const struct particles *p, int i)
{
    enum { AHEAD = 64, BYTES = RECORD_STRIDE(DIM, FRICTIONAL, SINGLE) * (int)sizeof(double) };
    const char *record = (const char *)p->record + (size_t)(i + AHEAD) * BYTES;
    for (int b = 0; b < F64_LANES * BYTES; b += 64)
        __builtin_prefetch(record + b, 1);
#if SINGLE
    for (int c = 0; c < DIM; c++) {
        __builtin_prefetch(p->view_u[c] + i + AHEAD, 1);
        __builtin_prefetch(p->view_v[c] + i + AHEAD, 1);
    }
#if FRICTIONAL
    for (int c = 0; c < SPRINGS; c++)
        __builtin_prefetch(p->view_omega[c] + i + AHEAD, 1);
#endif
#endif
}

/* Writes the records of F64_LANES particles from i on, which are `u` quanta from where they were listed; in single
 * precision also what stands side by side. */
LANES_INLINE void NAME(pack)(struct particles *p, int i, const f64 *x, const f64 *u, const f64 *v, const f64 *omega)
{
    enum { STRIDE = RECORD_STRIDE(DIM, FRICTIONAL, SINGLE) };
    const f64 zero = f64_all(0.0);
    double *to = (double *)p->record + (size_t)i * STRIDE;
    (void)omega;
    (void)zero;
    (void)x;
    (void)u;
#if SINGLE
    f32h record[8];
    for (int c = 0; c < DIM; c++) {
        record[c] = f64_fixed(u[c]);
        record[DIM + c] = f64_narrow(v[c]);
        f32h_store((float *)p->view_u[c] + i, record[c]);
        f32h_store(p->view_v[c] + i, record[DIM + c]);
    }
#if FRICTIONAL
    for (int c = 0; c < SPRINGS; c++) {
        f32h omega_f = f64_narrow(omega[c]);
        f32h_store(p->view_omega[c] + i, omega_f);
        if (c < 2 && DIM == 3)
            record[6 + c] = omega_f;
    }
#elif DIM == 3
    record[6] = record[7] = f64_narrow(zero);
#endif
#if DIM == 2
    f32h_store4((float *)to, record);
#else
    f32h_store8((float *)to, record);
#endif
#elif DIM == 2
    const f64 block[4] = {x[0], x[1], v[0], v[1]};
    f64_store4(to, STRIDE, block);
#if FRICTIONAL
    const f64 rotation[4] = {omega[0], zero, zero, zero};
    f64_store4(to + 4, STRIDE, rotation);
#endif
#else
    const f64 block[4] = {x[0], x[1], x[2], zero}, second[4] = {v[0], v[1], v[2], zero};
    f64_store4(to, STRIDE, block);
    f64_store4(to + 4, STRIDE, second);
#if FRICTIONAL
    const f64 rotation[4] = {omega[0], omega[1], omega[2], zero};
    f64_store4(to + 8, STRIDE, rotation);
#endif
#endif
}

/* Forces and moments of F64_LANES particles: their rows and columns, which start anew from zero. */
LANES_INLINE void NAME(take_sums)(struct particles *p, int i, f64 *force, f64 *moment)
{
    enum { STRIDE = ROW_BYTES(DIM, FRICTIONAL, SINGLE) / (int)sizeof(scalar) };
    scalar *rows = (scalar *)p->force + (size_t)i * STRIDE;
    scalar *own = (scalar *)((char *)p->force + PARTICLES_OWN_OFFSET(p->n_rows, DIM, FRICTIONAL, SINGLE)) + i;
    (void)moment;
#if SINGLE
    f32h row[8];
#if DIM == 2 && !FRICTIONAL
    f32h_load2(rows, row);
#elif DIM == 2 || !FRICTIONAL
    f32h_load4(rows, row);
#else
    f32h_load8(rows, row);
#endif
    for (int c = 0; c < DIM; c++) {
        force[c] = f32h_widen(row[c] + f32h_load(own));
        f32h_store(own, f64_narrow(f64_all(0.0)));
        own += p->n_rows;
    }
#if FRICTIONAL
    for (int c = 0; c < SPRINGS; c++) {
        moment[c] = f32h_widen(row[FORCE_MOMENT(DIM) + c] + f32h_load(own));
        f32h_store(own, f64_narrow(f64_all(0.0)));
        own += p->n_rows;
    }
#endif
#else
    f64 row[8];
#if DIM == 2 && !FRICTIONAL
    f64_load2(rows, row);
#else
    f64_load4(rows, STRIDE, row);
#endif
#if DIM == 3 && FRICTIONAL
    f64_load4(rows + FORCE_MOMENT(3), STRIDE, row + FORCE_MOMENT(3));
#endif
    for (int c = 0; c < DIM; c++) {
        force[c] = row[c] + f64_load(own);
        f64_store(own, f64_all(0.0));
        own += p->n_rows;
    }
#if FRICTIONAL
    for (int c = 0; c < SPRINGS; c++) {
        moment[c] = row[FORCE_MOMENT(DIM) + c] + f64_load(own);
        f64_store(own, f64_all(0.0));
        own += p->n_rows;
    }
#endif
#endif
    memset(rows, 0, F64_LANES * STRIDE * sizeof *rows);
}

/* What F64_LANES particles are between kick and drift. */
struct NAME(motion) {
    f64 v[DIM], a[DIM], omega[3], alpha[3];
};

/* Constants of a kick in all lanes, and what it sums: v^2, and a^2 omega^2. */
struct NAME(kick) {
    f64 half, minus_gamma_b, gravity[3], minus_slowing;
    f64 v2, spin2;
};

LANES_INLINE struct NAME(kick) NAME(kick_of)(const struct kick_constants *k)
{
    return (struct NAME(kick)){
        .half = f64_all(0.5 * k->dt),
        .minus_gamma_b = f64_all(-k->gamma_b),
        .gravity = {f64_all(k->gravity[0]), f64_all(k->gravity[1]), f64_all(k->gravity[2])},
        .minus_slowing = f64_all(-2.5 * k->gamma_br), /* a^2/I = 2.5/m */
        .v2 = f64_all(0.0),
        .spin2 = f64_all(0.0),
    };
}

/* What the background takes [W]. */
LANES_INLINE double NAME(power)(const struct NAME(kick) * kick, const struct kick_constants *k)
{
    return k->gamma_b * f64_sum(kick->v2) + k->gamma_br * f64_sum(kick->spin2);
}

/* Accelerations from forces, background damping and gravity; corrects v and omega by the change of acceleration. */
LANES_INLINE struct NAME(motion) NAME(kicked)(struct particles *p, int i, struct NAME(kick) * kick, bool gravity)
{
    struct NAME(motion) to;
    f64 force[DIM], moment[3], inv_mass = f64_load(p->inv_mass + i);
    NAME(take_sums)(p, i, force, moment);
    for (int c = 0; c < DIM; c++) {
        f64 v = f64_load(p->v[c] + i), before = f64_load(p->a[c] + i);
        if (gravity)
            force[c] = f64_fma(kick->gravity[c], f64_load(p->mass + i), force[c]);
        to.a[c] = f64_fma(kick->minus_gamma_b, v, force[c]) * inv_mass;
        to.v[c] = f64_fma(kick->half, to.a[c] - before, v);
        kick->v2 = f64_fma(v, v, kick->v2);
    }
#if FRICTIONAL
    f64 radius = f64_load(p->radius + i), minus_lever = -radius * f64_load(p->inv_inertia + i);
    f64 minus_slowing = kick->minus_slowing * inv_mass, omega2 = f64_all(0.0);
    for (int c = 0; c < SPRINGS; c++) {
        f64 omega = f64_load(p->omega[c] + i), before = f64_load(p->alpha[c] + i);
        to.alpha[c] = f64_fma(minus_lever, moment[c], minus_slowing * omega);
        to.omega[c] = f64_fma(kick->half, to.alpha[c] - before, omega);
        omega2 = f64_fma(omega, omega, omega2);
    }
    kick->spin2 = f64_fma(radius * radius, omega2, kick->spin2);
#endif
    return to;
}

LANES_INLINE void NAME(motion_store)(struct particles *p, int i, const struct NAME(motion) * motion)
{
    for (int c = 0; c < DIM; c++) {
        f64_store(p->v[c] + i, motion->v[c]);
        f64_store(p->a[c] + i, motion->a[c]);
    }
#if FRICTIONAL
    for (int c = 0; c < SPRINGS; c++) {
        f64_store(p->omega[c] + i, motion->omega[c]);
        f64_store(p->alpha[c] + i, motion->alpha[c]);
    }
#endif
}

/* Constants of a drift in all lanes, and whether all particles so far are near: no further than sqrt(limit2) from where
 * the lists were built, and not NaN. */
struct NAME(drift) {
    f64 dt, half, limit2, per_quantum;
    f64_mask near;
};

LANES_INLINE struct NAME(drift) NAME(drift_of)(const struct particles *p, double dt_s, double reach_m)
{
    const f64 zero = f64_all(0.0);
    return (struct NAME(drift)){.dt = f64_all(dt_s),
                                .half = f64_all(0.5 * dt_s),
                                .limit2 = f64_all(reach_m * reach_m),
                                .per_quantum = f64_all(1 / p->quantum),
                                .near = f64_at_least(zero, zero)};
}

/* x += v dt + a dt^2/2; v and omega of `motion` become those predicted for the end of the step. */
LANES_INLINE void NAME(drifted)(struct particles *p, int i, struct NAME(drift) * drift, struct NAME(motion) * motion)
{
    f64 x[DIM], u[DIM], moved2 = f64_all(0.0);
    for (int c = 0; c < DIM; c++) {
        f64 before = f64_load(p->x[c] + i);
        x[c] = f64_fma(drift->dt, f64_fma(drift->half, motion->a[c], motion->v[c]), before);
        motion->v[c] = f64_fma(drift->dt, motion->a[c], motion->v[c]);
        u[c] = x[c] - f64_load(p->x_list[c] + i);
        moved2 = f64_fma(u[c], u[c], moved2);
        f64_store(p->x[c] + i, x[c]);
        u[c] = u[c] * drift->per_quantum;
    }
#if FRICTIONAL
    for (int c = 0; c < SPRINGS; c++)
        motion->omega[c] = f64_fma(drift->dt, motion->alpha[c], motion->omega[c]);
#endif
    drift->near = f64_and(drift->near, f64_at_least(drift->limit2, moved2));
    NAME(pack_ahead)(p, i);
    NAME(pack)(p, i, x, u, motion->v, motion->omega);
}

/* The loops here go over a copy of the particles' pointers, which no store can change. */
static bool NAME(drift)(struct particles *p, double dt_s, double reach_m)
{
    struct particles of = *p;
    struct NAME(drift) drift = NAME(drift_of)(p, dt_s, reach_m);
    for (int i = of.from; i < of.count; i += F64_LANES) {
        struct NAME(motion) motion;
        for (int c = 0; c < DIM; c++) {
            motion.v[c] = f64_load(of.v[c] + i);
            motion.a[c] = f64_load(of.a[c] + i);
        }
#if FRICTIONAL
        for (int c = 0; c < SPRINGS; c++) {
            motion.omega[c] = f64_load(of.omega[c] + i);
            motion.alpha[c] = f64_load(of.alpha[c] + i);
        }
#endif
        NAME(drifted)(&of, i, &drift, &motion);
        NAME(motion_store)(&of, i, &motion);
    }
    return !f64_mask_all(drift.near);
}

LANES_INLINE double NAME(kick_all)(struct particles of, const struct kick_constants *constants, bool gravity)
{
    struct NAME(kick) kick = NAME(kick_of)(constants);
    for (int i = of.from; i < of.count; i += F64_LANES) {
        struct NAME(motion) motion = NAME(kicked)(&of, i, &kick, gravity);
        NAME(motion_store)(&of, i, &motion);
    }
    return NAME(power)(&kick, constants);
}

LANES_INLINE bool NAME(advance_all)(struct particles of, const struct kick_constants *constants, bool gravity,
                                    double dt_s, double reach_m, double *background_w)
{
    struct NAME(kick) kick = NAME(kick_of)(constants);
    struct NAME(drift) drift = NAME(drift_of)(&of, dt_s, reach_m);
    for (int i = of.from; i < of.count; i += F64_LANES) {
        struct NAME(motion) motion = NAME(kicked)(&of, i, &kick, gravity);
        NAME(drifted)(&of, i, &drift, &motion);
        NAME(motion_store)(&of, i, &motion);
    }
    *background_w = NAME(power)(&kick, constants);
    return !f64_mask_all(drift.near);
}

LANES_INLINE bool NAME(pulls)(const struct kick_constants *constants)
{
    return constants->gravity[0] != 0 || constants->gravity[1] != 0 || constants->gravity[2] != 0;
}

static double NAME(kick)(struct particles *p, const struct kick_constants *constants)
{
    return NAME(pulls)(constants) ? NAME(kick_all)(*p, constants, true) : NAME(kick_all)(*p, constants, false);
}

/* Both in one pass: the kick of a step and the drift of the next. */
static bool NAME(advance)(struct particles *p, const struct kick_constants *constants, double dt_s, double reach_m,
                          double *background_w)
{
    return NAME(pulls)(constants) ? NAME(advance_all)(*p, constants, true, dt_s, reach_m, background_w)
                                  : NAME(advance_all)(*p, constants, false, dt_s, reach_m, background_w);
}
