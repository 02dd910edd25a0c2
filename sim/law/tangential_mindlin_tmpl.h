/* Mindlin's friction (Thornton, Cummins & Cleary, Powder Technol. 233 (2013) 30): what a contact remembers is its
 * tangential force, which grows by k_t per way, k_t = 8 G* ac, and is scaled down with k_t where that falls, so that a
 * closed path in overlap and way makes no energy. What the changing k_t takes is a loss of its own. Stick and slide as
 * [D]; parameters as of contact_law_tmpl.h. `spring` stands for the force here. */

/* Test force [D] of contacts that friction holds up to `limit`. pull = T + gamma_t v_t is the test force reversed; a
 * sliding contact keeps `factor` of it. Contacts that are open slide without resistance, so that they lose what their
 * springs hold. */
LANES_INLINE void NAME(test)(const struct NAME(law) * law, const struct NAME(pair) * pair,
                             const struct NAME(meeting) * at, const struct NAME(travel) * t, real limit,
                             const struct NAME(memory) * memory, struct NAME(touch) * touch, struct NAME(sums) * sums)
{
    const real zero = real_all(0.0);
    touch->inv_kt = pair->inv_kt;
    const real gamma_t = pair->gamma_t * real_all(law->damped); /* 0 in a stage without friction */
    touch->gamma_t = pair->gamma_t;
    const real lever = gamma_t - pair->kt * real_all(law->half);
    real spring[SPRINGS], change[SPRINGS], kept2 = zero;
    for (int c = 0; c < SPRINGS; c++) {
        spring[c] = real_load(memory->spring[c]);
        kept2 = real_fma(spring[c], spring[c], kept2);
        change[c] = zero;
    }
    /* |T|^2/(2 k_t) of the step before, less what of it is left: both with the k_t of either side */
    touch->stiffness = real_where(touch->active, kept2 * pair->lost);
    sums->slip2 = real_fma(pair->kt, t->start2, sums->slip2);
#if DIM == 3 /* in 2D the force is a number along the tangent, so a rotating pair carries it along by itself */
    NAME(turn)(at, spring, change);
#endif
    for (int c = 0; c < SPRINGS; c++) {
        real more = real_fma(pair->kt, t->way[c], pair->fall * change[c]);
#if SINGLE
        touch->moved[c] = real_fma(pair->fall - real_all(1.0), spring[c], real_load(memory->rest[c]) + more);
#else
        touch->moved[c] = real_fma(pair->fall, spring[c], more);
#endif
    }
    for (int c = 0; c < SPRINGS; c++) {
        real middle = touch->moved[c];
#if SINGLE
        middle = spring[c] + middle;
#endif
        touch->pull[c] = real_fma(lever, at->vt[c], middle);
    }
    touch->viscous = gamma_t * NAME(dot)(at->vt, at->vt);
    touch->power = NAME(dot)(touch->pull, at->vt);
    touch->pull2 = NAME(dot)(touch->pull, touch->pull);
    real_mask slid = real_greater(real_load(memory->sliding), zero);
    real bound = limit * real_select(slid, real_all(law->mu_d), real_all(law->mu_s));
    touch->bound2 = bound * bound;
    touch->kinetic = real_all(law->mu_d) * limit;
}

/* Forces that are remembered, losses and forces of friction. A sliding contact slips by q pull, q = (1 - factor)/kt, so
 * that the law holds with the force that is left; q = 0: it sticks. With the mean of the spring over the step the
 * ledger closes in second order, jumps of the spring included. While a contact slides friction takes all, as in
 * tangential_spring_tmpl.h, what the changing kt takes included. */
LANES_INLINE void NAME(slip)(const struct NAME(law) * law, const struct NAME(touch) * touch,
                             const struct NAME(memory) * memory, struct NAME(contact_result) * result,
                             struct NAME(sums) * sums)
{
    const real gone = real_all(1.0) - touch->factor, q = gone * touch->inv_kt;
    const real slip = q * touch->pull2;
    (void)law;
    const real slides = real_load(memory->sliding);
    NAME(viscous_add)(slides, touch->viscous, &sums->stuck, &sums->slid);
    sums->stiffness = real_fma(real_all(1.0) - slides, touch->stiffness, sums->stiffness);
    sums->slip2 = real_fma(-slides, touch->stiffness, sums->slip2);
    sums->slip = sums->slip + slip;
    sums->slip2 = real_fma(gone, slip, sums->slip2);
    sums->power = real_fma(gone, touch->power, sums->power);
    sums->power_t = real_fma(q * touch->gamma_t, touch->power, sums->power_t);
    NAME(slip_by)(gone, touch, memory, result);
}

LANES_INLINE void NAME(friction_totals_add)(const struct NAME(totals) * totals, const struct contact_law_constants *law,
                                            double dt_s, const struct law_units *units, struct contact_losses *losses)
{
    const double force = units->force, power = units->speed * NAME(doubles_sum)(totals->power);
    (void)law;
    losses->viscous_tangential += force * dt_s * units->speed * NAME(doubles_sum)(totals->stuck);
    losses->friction +=
        force * (NAME(doubles_sum)(totals->slip) - 0.5 * (NAME(doubles_sum)(totals->slip2) + dt_s * power) +
                 dt_s * units->speed * NAME(doubles_sum)(totals->slid) - NAME(doubles_sum)(totals->power_t));
    losses->stiffness += 0.5 * force * NAME(doubles_sum)(totals->stiffness);
}
