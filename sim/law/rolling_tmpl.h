/* Rolling and torsion resistance (Luding, Granular Matter 10 (2008) 235) beside any friction; parameters as of
 * contact_law_tmpl.h. With a' = a_i a_j/(a_i + a_j) (against a wall a_i) and the relative rotation w = omega_i -
 * omega_j, torsion is that along n, v_o = a' n.w, and rolling the rest, v_r = a' (w - n (n.w)): Luding's -a' n x w
 * turned by a quarter about n, so that 2D and 3D are the same text. Both have a spring, a dashpot and a limit mu f_lim,
 * as friction has, in steps of the same scheme; the quasi-force f acts by torques -a' f on i and a' f on j alone. With
 * q and the slip s as of friction the losses are, of a limited force, s.f + (k s^2 - k dt s.v)/2, f what is left of it;
 * while it is limited, what its dashpot takes counts among them, as with friction. */

/* Velocities of rolling and torsion, and their lags, of contacts that touch. */
LANES_INLINE void NAME(rolls)(const struct NAME(sides) * of, real_mask active, struct NAME(meeting) * at)
{
    at->share = real_where(active, of->share);
    const real lever = of->radius * at->share;
    for (int c = 0; c < SPRINGS; c++) {
        at->rolling[c] = lever * of->turning[c];
        at->rolling_lag[c] = lever * of->lag_turning[c];
    }
#if DIM == 3
    const real torsion = NAME(dot)(at->rolling, at->n), torsion_lag = NAME(dot)(at->rolling_lag, at->n);
    for (int c = 0; c < 3; c++) {
        at->rolling[c] = real_fma(-torsion, at->n[c], at->rolling[c]);
        at->rolling_lag[c] = real_fma(-torsion_lag, at->n[c], at->rolling_lag[c]);
    }
#if TORSION
    at->torsion = torsion;
    at->torsion_lag = torsion_lag;
#endif
#endif
}

#if TORSION
struct NAME(twisted) {
    real pull, moved;
};

/* The test force, and the spring (mixed: its change) if nothing slides. */
LANES_INLINE struct NAME(twisted)
    NAME(twist_test)(const struct NAME(law) * law, real v, real way, const struct NAME(memory) * memory)
{
    const struct NAME(resistance) *r = &law->torsion;
    struct NAME(twisted) to = {.moved = real_all(r->on) * way};
    real middle;
#if SINGLE
    to.moved = real_load(memory->torsion_rest) + to.moved;
#endif
    middle = real_load(memory->torsion) + to.moved;
#if !SINGLE
    to.moved = middle;
#endif
    to.pull = real_fma(real_all(r->k), middle, real_all(r->lever) * v);
    return to;
}

/* Torsion, which is a number, so that its limit needs no root. Returns the quasi-force. */
LANES_INLINE real NAME(twist)(const struct NAME(law) * law, real v, real way, real limit, real_mask active,
                              const struct NAME(memory) * memory, struct NAME(sums) * sums)
{
    const struct NAME(resistance) *r = &law->torsion;
    const struct NAME(twisted) test = NAME(twist_test)(law, v, way, memory);
    const real bound = real_all(r->mu) * limit, left = real_smaller(real_larger(test.pull, -bound), bound);
    const real gone = test.pull - left, slip = gone * real_all(r->inv_k);
    const real mean = real_fma(real_all(-r->half_k_dt), v, real_fma(real_all(-0.5), gone, test.pull));
    const real viscous = v * real_fma(real_all(r->gamma_dt), v, real_all(-r->gamma) * slip);
    const real slides = real_where(real_greater(gone * test.pull, real_all(0.0)), real_all(1.0));
    sums->rolling = real_fma(slip, mean, sums->rolling);
    NAME(viscous_add)(slides, viscous, &sums->viscous_rolling, &sums->rolling);
    NAME(remember)(memory->torsion, memory->torsion_rest, active, test.moved - slip);
    return left;
}
#endif

/* Contacts that were open a step ago, as friction has them (struct travel): what their springs start with. */
LANES_INLINE void NAME(roll_start)(const struct NAME(law) * law, const struct NAME(travel) * t,
                                   const struct NAME(meeting) * at, struct NAME(sums) * sums)
{
    const real half = real_all(-0.5) * t->ahead2, *v = at->rolling;
    sums->rolling = real_fma(half * real_all(law->rolling.k), NAME(dot)(v, v), sums->rolling);
#if TORSION
    sums->rolling = real_fma(half * real_all(law->torsion.k) * at->torsion, at->torsion, sums->rolling);
#endif
}

/* First half. */
LANES_INLINE void NAME(roll)(const struct NAME(law) * law, const struct NAME(meeting) * at,
                             const struct NAME(travel) * t, real limit, const struct NAME(memory) * memory,
                             struct NAME(touch) * touch, struct NAME(sums) * sums)
{
    const struct NAME(resistance) *r = &law->rolling;
    struct NAME(rolled) *to = &touch->rolling;
    const real half = real_all((scalar)0.5 * law->dt), *v = at->rolling;
    real spring[SPRINGS], v2 = real_all(0.0);
    touch->share = at->share;
#if TORSION
    const real way = real_fma(t->step, at->torsion, half * at->torsion_lag);
    touch->torsion = NAME(twist)(law, at->torsion, way, limit, touch->active, memory, sums);
#endif
    if (t->fresh)
        NAME(roll_start)(law, t, at, sums);
    for (int c = 0; c < SPRINGS; c++) {
        spring[c] = real_load(memory->rolling[c]);
        to->moved[c] = real_all(r->on) * real_fma(t->step, v[c], half * at->rolling_lag[c]);
#if SINGLE
        to->moved[c] = real_load(memory->rolling_rest[c]) + to->moved[c];
#endif
    }
#if DIM == 3
    NAME(turn)(at, spring, to->moved);
#endif
    for (int c = 0; c < SPRINGS; c++) {
        const real middle = spring[c] + to->moved[c];
        if (!SINGLE)
            to->moved[c] = middle;
        to->pull[c] = real_fma(real_all(r->k), middle, real_all(r->lever) * v[c]);
        v2 = real_fma(v[c], v[c], v2);
    }
    to->power = NAME(dot)(to->pull, v);
    to->pull2 = NAME(dot)(to->pull, to->pull);
    to->factor = real_all(r->mu) * limit;
    to->v2 = v2;
}

/* Second half: adds to the moments. Torque = -a moment, and a' = a_i share = a_j (1 - share). */
LANES_INLINE void NAME(roll_slip)(const struct NAME(law) * law, const struct NAME(touch) * touch,
                                  const struct NAME(memory) * memory, struct NAME(contact_result) * result,
                                  struct NAME(sums) * sums)
{
    const struct NAME(resistance) *r = &law->rolling;
    const struct NAME(rolled) *from = &touch->rolling;
    const real gone = real_all(1.0) - from->factor, q = gone * real_all(r->inv_k);
    const real mean = real_fma(real_all(-0.5) * gone, from->pull2, from->pull2);
    sums->rolling = real_fma(q, real_fma(real_all(-r->half_k_dt), from->power, mean), sums->rolling);
    const real viscous = real_fma(real_all(r->gamma_dt), from->v2, real_all(-r->gamma) * q * from->power);
    const real slides = real_where(real_greater(gone, real_all(0.0)), real_all(1.0));
    NAME(viscous_add)(slides, viscous, &sums->viscous_rolling, &sums->rolling);
    for (int c = 0; c < SPRINGS; c++) {
        real force = from->factor * from->pull[c];
#if TORSION
        force = real_fma(touch->torsion, touch->n[c], force);
#endif
        NAME(remember)
        (memory->rolling[c], memory->rolling_rest[c], touch->active, real_fma(-q, from->pull[c], from->moved[c]));
        result->own[c] = real_fma(touch->share, force, result->moment[c]);
        result->moment[c] = result->own[c] - force;
    }
}
