/* Rolling and torsion resistance (Luding, Granular Matter 10 (2008) 235) beside any friction; parameters as of
 * contact_law_tmpl.h. With a' = a_i a_j/(a_i + a_j) (against a wall a_i) and the relative rotation w = omega_i -
 * omega_j, torsion is that along n, v_o = a' n.w, and rolling the rest, v_r = a' (w - n (n.w)): Luding's -a' n x w
 * turned by a quarter about n, so that 2D and 3D are the same text. Both have a spring, a dashpot and a limit mu f_lim,
 * as friction has, in steps of the same scheme; the quasi-force f acts by torques -a' f on i and a' f on j alone. */

/* Spring, test force and power of n components. spring: of the step before, fresh contacts 0; change: by turning. */
LANES_INLINE void NAME(resist)(const struct NAME(law) * law, const struct NAME(resistance) * r, int n, const real *v,
                               const real *way, const real *spring, const real *change, scalar *const *rest,
                               real_mask old, real limit, struct NAME(resisted) * to)
{
    const real zero = real_all(0.0), per = real_all(law->per_force), bound = real_all(r->mu) * limit;
    to->power = to->pull2 = to->viscous = zero;
    (void)rest;
    (void)old;
    for (int c = 0; c < n; c++) {
        const real more = real_fma(real_all(r->on), way[c], change[c]);
#if SINGLE
        to->moved[c] = real_where(old, real_load(rest[c])) + more;
        const real middle = spring[c] + to->moved[c];
#else
        to->moved[c] = spring[c] + more;
        const real middle = to->moved[c];
#endif
        to->pull[c] = real_fma(real_all(r->k), middle, real_all(r->lever) * v[c]);
        to->power = real_fma(to->pull[c], v[c], to->power);
        to->pull2 = real_fma(to->pull[c], to->pull[c], to->pull2);
        to->viscous = real_fma(v[c], v[c], to->viscous);
    }
    const real reduced = NAME(ratio)(bound * per, real_larger(to->pull2 * (per * per), real_all(0x1p-120)));
    to->factor = real_select(real_greater(to->pull2, bound * bound), reduced, real_all(1.0));
}

/* First half. */
LANES_INLINE void NAME(roll)(const struct NAME(law) * law, const struct NAME(meeting) * at, real u, real delta,
                             real limit, const struct NAME(memory) * memory, struct NAME(touch) * touch,
                             struct NAME(sums) * sums)
{
    const real zero = real_all(0.0), dt = real_all(law->dt), half = real_all((scalar)0.5 * law->dt);
    const real_mask old = real_at_least(delta, -u * real_all(law->dt_units));
    real v[SPRINGS], lag[SPRINGS], way[SPRINGS], spring[SPRINGS], change[SPRINGS], step = dt, ahead2 = zero;
    touch->share = real_where(touch->active, at->share);
    const real lever = at->radius * touch->share;
    if (!REAL(mask_all)(old)) { /* as friction: since they touched */
        const real since = delta * real_all(law->unit) / -u, ahead = since - half;
        step = real_select(old, dt, since + half);
        ahead2 = real_select(old, zero, ahead * ahead);
    }
    for (int c = 0; c < SPRINGS; c++) {
        v[c] = real_where(touch->active, lever * at->turning[c]);
        lag[c] = real_where(touch->active, lever * at->lag_turning[c]);
        spring[c] = real_where(old, real_load(memory->rolling[c]));
        change[c] = zero;
    }
#if DIM == 3
    const real *n = touch->n, vo = NAME(dot)(v, n), lag_o = NAME(dot)(lag, n);
    real gt[3];
    for (int c = 0; c < 3; c++) {
        v[c] = real_fma(-vo, n[c], v[c]);
        lag[c] = real_fma(-lag_o, n[c], lag[c]);
        gt[c] = real_fma(-u, n[c], at->g[c]);
    }
    NAME(turn)(law, at, n, gt, spring, change);
    const real twist = real_where(touch->active, vo), way_o = real_fma(step, twist, half * lag_o);
    const real twisted = real_where(old, real_load(memory->torsion));
    NAME(resist)
    (law, &law->torsion, 1, &twist, &way_o, &twisted, &zero, &memory->torsion_rest, old, limit, &touch->torsion);
    sums->torsion.slip2 = real_fma(ahead2 * twist, twist, sums->torsion.slip2);
    real_store(memory->torsion, twisted);
#endif
    for (int c = 0; c < SPRINGS; c++) {
        v[c] = real_where(touch->active, v[c]);
        way[c] = real_fma(step, v[c], half * lag[c]);
        real_store(memory->rolling[c], spring[c]);
    }
    NAME(resist)
    (law, &law->rolling, SPRINGS, v, way, spring, change, memory->rolling_rest, old, limit, &touch->rolling);
    sums->rolling.slip2 = real_fma(ahead2, NAME(dot)(v, v), sums->rolling.slip2);
}

/* What is left of n components of the quasi-force, springs and losses, as of friction. */
LANES_INLINE void NAME(resisted_slip)(const struct NAME(resistance) * r, const struct NAME(resisted) * from, int n,
                                      scalar *const *spring, scalar *const *rest, real_mask active, real *force,
                                      struct NAME(resisted_sums) * sums)
{
    const real q = (real_all(1.0) - from->factor) * real_all(r->inv_k), slip = q * from->pull2;
    (void)rest;
    const real slides = real_where(real_greater(real_all(1.0), from->factor), real_all(1.0));
    NAME(viscous_add)(slides, from->viscous, &sums->stuck, &sums->slid);
    sums->slip = sums->slip + slip;
    sums->slip2 = real_fma(q, slip, sums->slip2);
    sums->power = real_fma(q, from->power, sums->power);
    for (int c = 0; c < n; c++) {
        real after = real_fma(-q, from->pull[c], from->moved[c]);
#if SINGLE
        const real before = real_load(spring[c]), change = after;
        after = before + change;
        real_store(rest[c], real_where(active, change - (after - before)));
#endif
        real_store(spring[c], real_where(active, after));
        force[c] = from->factor * from->pull[c];
    }
}

/* Second half: adds to the moments. Torque = -a moment, and a' = a_i share = a_j (1 - share). */
LANES_INLINE void NAME(roll_slip)(const struct NAME(law) * law, const struct NAME(touch) * touch,
                                  const struct NAME(memory) * memory, struct NAME(contact_result) * result,
                                  struct NAME(sums) * sums)
{
    real force[SPRINGS];
    const real others = real_all(1.0) - touch->share;
    NAME(resisted_slip)
    (&law->rolling, &touch->rolling, SPRINGS, memory->rolling, memory->rolling_rest, touch->active, force,
     &sums->rolling);
#if DIM == 3
    real twist;
    NAME(resisted_slip)
    (&law->torsion, &touch->torsion, 1, &memory->torsion, &memory->torsion_rest, touch->active, &twist, &sums->torsion);
    for (int c = 0; c < 3; c++)
        force[c] = real_fma(twist, touch->n[c], force[c]);
#endif
    for (int c = 0; c < SPRINGS; c++) {
        result->own[c] = real_fma(touch->share, force[c], result->moment[c]);
        result->moment[c] = real_fma(-others, force[c], result->moment[c]);
    }
}

LANES_INLINE void NAME(resisted_close)(struct NAME(resisted_sums) * sums, struct NAME(resisted_totals) * totals)
{
    NAME(close)(&sums->stuck, &totals->stuck);
    NAME(close)(&sums->slid, &totals->slid);
    NAME(close)(&sums->slip, &totals->slip);
    NAME(close)(&sums->slip2, &totals->slip2);
    NAME(close)(&sums->power, &totals->power);
}

LANES_INLINE void NAME(resisted_add)(const struct NAME(resisted_totals) * totals, const struct contact_resistance *r,
                                     double dt_s, const struct law_units *units, struct contact_losses *losses)
{
    const double power = units->speed * NAME(doubles_sum)(totals->power), speed2 = units->speed * units->speed;
    losses->viscous_rolling += r->gamma * dt_s * speed2 * NAME(doubles_sum)(totals->stuck);
    losses->rolling += units->force * NAME(doubles_sum)(totals->slip) -
                       0.5 * r->k * (NAME(doubles_sum)(totals->slip2) + dt_s * power) +
                       r->gamma * (dt_s * speed2 * NAME(doubles_sum)(totals->slid) - power);
}
