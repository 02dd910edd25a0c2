/* Mindlin's friction (Thornton, Cummins & Cleary, Powder Technol. 233 (2013) 30): what a contact remembers is its
 * tangential force, which grows by k_t per way, k_t = 8 G* ac, and is scaled down with k_t where that falls, so that a
 * closed path in overlap and way makes no energy. What the changing k_t takes is a loss of its own. Stick and slide as
 * [D]; parameters as of contact_law_tmpl.h. `spring` stands for the force here. */

/* Test force [D] of contacts that friction holds up to `limit`. pull = T + gamma_t v_t is the test force reversed; a
 * sliding contact keeps `factor` of it. Contacts that are open slide without resistance, so that they lose what their
 * springs hold. */
LANES_INLINE void NAME(test)(const struct NAME(law) * law, const struct NAME(meeting) * at, real u, real limit,
                             const struct NAME(memory) * memory, struct NAME(touch) * touch, struct NAME(sums) * sums)
{
    const real zero = real_all(0.0), dt = real_all(law->dt), *n = touch->n, *g = at->g, *w = at->w;
    real spring[SPRINGS], vt[SPRINGS];
    const struct NAME(pair) *pair = &touch->pair;
    const real gamma_t = pair->gamma_t * real_all(law->damped); /* 0 in a stage without friction */
    const real way = pair->kt * dt, lever = gamma_t - pair->kt * real_all(law->half);
    real start[SPRINGS], kept2 = zero;
    for (int c = 0; c < SPRINGS; c++) {
        spring[c] = real_load(memory->spring[c]);
        kept2 = real_fma(spring[c], spring[c], kept2);
#if SINGLE
        start[c] = real_fma(pair->fall - real_all(1.0), spring[c], real_load(memory->rest[c]));
#else
        spring[c] = pair->fall * spring[c];
        start[c] = spring[c];
#endif
    }
    /* |T|^2/(2 k_t) of the step before, less what of it is left: both with the k_t of either side */
    sums->stiffness = sums->stiffness + real_where(touch->active, kept2 * (real_all(1.0) - pair->ratio) * pair->held);
    (void)start;
#if DIM == 2
    /* tangent (-n1, n0); the spring is a number along it, so a rotating pair carries it along by itself */
    (void)u;
    vt[0] = real_where(touch->active, real_fma(g[1], n[0], real_fma(-g[0], n[1], -w[0])));
    touch->moved[0] = real_fma(way, vt[0], start[0]);
#else
    real more[3];
    for (int c = 0; c < 3; c++) { /* g + n x w - u n */
        int d = (c + 1) % 3, e = (c + 2) % 3;
        vt[c] = real_fma(n[d], w[e], real_fma(-n[e], w[d], real_fma(-u, n[c], g[c])));
        vt[c] = real_where(touch->active, vt[c]);
#if SINGLE
        more[c] = real_fma(way, vt[c], start[c]);
#else
        more[c] = way * vt[c];
#endif
    }
    NAME(turn)(n, real_all(0.5) * dt * NAME(dot)(at->spin, n), spring, more, touch->moved);
#endif
    for (int c = 0; c < SPRINGS; c++) {
        real middle = touch->moved[c];
#if SINGLE
        middle = spring[c] + middle;
#endif
        touch->pull[c] = real_fma(lever, vt[c], middle);
        sums->vt2 = real_fma(gamma_t * vt[c], vt[c], sums->vt2);
    }
    touch->power = NAME(dot)(touch->pull, vt);
    touch->pull2 = NAME(dot)(touch->pull, touch->pull);
    real_mask slid = real_greater(real_load(memory->sliding), zero);
    real bound = limit * real_select(slid, real_all(law->mu_d), real_all(law->mu_s));
    touch->bound2 = bound * bound;
    touch->kinetic = real_all(law->mu_d) * limit;
}

/* Forces that are remembered, losses and forces of friction. A sliding contact slips by q pull, q = (1 - factor)/kt, so
 * that the law holds with the force that is left; q = 0: it sticks. With the mean of the spring over the step the
 * ledger closes in second order, jumps of the spring included. */
LANES_INLINE void NAME(slip)(const struct NAME(law) * law, const struct NAME(touch) * touch,
                             const struct NAME(memory) * memory, struct NAME(contact_result) * result,
                             struct NAME(sums) * sums)
{
    const real *n = touch->n;
    const real gone = real_all(1.0) - touch->factor, q = gone * touch->pair.inv_kt;
    real slip = q * touch->pull2, pull[SPRINGS];
    (void)law;
    sums->slip = sums->slip + slip;
    sums->slip2 = real_fma(gone, slip, sums->slip2);
    sums->power = real_fma(gone, touch->power, sums->power);
    sums->power_t = real_fma(q * touch->pair.gamma_t, touch->power, sums->power_t);
    for (int c = 0; c < SPRINGS; c++) {
        real after = real_fma(-gone, touch->pull[c], touch->moved[c]);
#if SINGLE
        real spring = real_load(memory->spring[c]), change = after;
        after = spring + change;
        real_store(memory->rest[c], real_where(touch->active, change - (after - spring)));
#endif
        real_store(memory->spring[c], real_where(touch->active, after));
        pull[c] = touch->factor * touch->pull[c]; /* the tangential force on j */
    }
#if DIM == 2
    result->force[0] = real_fma(touch->pressing, n[0], -pull[0] * n[1]);
    result->force[1] = real_fma(touch->pressing, n[1], pull[0] * n[0]);
    result->moment[0] = -pull[0];
#else
    for (int c = 0; c < 3; c++) {
        result->force[c] = real_fma(touch->pressing, n[c], pull[c]);
        result->moment[c] = NAME(cross)(pull, n, c);
    }
#endif
}

LANES_INLINE void NAME(friction_sums_close)(struct NAME(sums) * sums, struct NAME(totals) * totals)
{
    NAME(close)(&sums->vt2, &totals->vt2);
    NAME(close)(&sums->slip, &totals->slip);
    NAME(close)(&sums->slip2, &totals->slip2);
    NAME(close)(&sums->power, &totals->power);
    NAME(close)(&sums->power_t, &totals->power_t);
    NAME(close)(&sums->stiffness, &totals->stiffness);
}

LANES_INLINE void NAME(friction_totals_add)(const struct NAME(totals) * totals, const struct contact_law_constants *law,
                                            double dt_s, struct contact_losses *losses)
{
    (void)law;
    losses->viscous_tangential += dt_s * NAME(doubles_sum)(totals->vt2) - NAME(doubles_sum)(totals->power_t);
    losses->friction += NAME(doubles_sum)(totals->slip) -
                        0.5 * (NAME(doubles_sum)(totals->slip2) + dt_s * NAME(doubles_sum)(totals->power));
    losses->stiffness += 0.5 * NAME(doubles_sum)(totals->stiffness);
}
