/* Friction of a spring of constant stiffness [D eq. 2-4]; parameters as of contact_law_tmpl.h. */

/* Test force [D] of contacts that friction holds up to `limit`. pull = kt xi + gamma_t v_t is the test force reversed;
 * a sliding contact keeps `factor` of it. Contacts that are open slide without resistance, so that they lose what their
 * springs hold. */
LANES_INLINE void NAME(test)(const struct NAME(law) * law, const struct NAME(meeting) * at,
                             const struct NAME(travel) * t, real limit, const struct NAME(memory) * memory,
                             struct NAME(touch) * touch, struct NAME(sums) * sums)
{
    const real zero = real_all(0.0);
    real spring[SPRINGS], change[SPRINGS];
    for (int c = 0; c < SPRINGS; c++) {
        spring[c] = real_load(memory->spring[c]);
        change[c] = zero;
    }
    sums->slip2 = sums->slip2 + t->start2;
#if DIM == 3 /* in 2D the spring is a number along the tangent, so a rotating pair carries it along by itself */
    NAME(turn)(at, spring, change);
#endif
    for (int c = 0; c < SPRINGS; c++) {
        real more = change[c] + t->way[c];
        touch->moved[c] = (SINGLE ? real_load(memory->rest[c]) : spring[c]) + more;
    }
    for (int c = 0; c < SPRINGS; c++) {
        real middle = touch->moved[c];
#if SINGLE
        middle = spring[c] + middle;
#endif
        touch->pull[c] = real_fma(real_all(law->kt), middle, real_all(law->lever) * at->vt[c]);
    }
    touch->viscous = NAME(dot)(at->vt, at->vt);
    touch->power = NAME(dot)(touch->pull, at->vt);
    touch->pull2 = NAME(dot)(touch->pull, touch->pull);
    real_mask slid = real_greater(real_load(memory->sliding), zero);
    real bound = limit * real_select(slid, real_all(law->mu_d), real_all(law->mu_s));
    touch->bound2 = bound * bound;
    touch->kinetic = real_all(law->mu_d) * limit;
}

/* Springs, losses and forces of friction. A sliding spring slips by q pull, q = (1 - factor)/kt, so that the law holds
 * with the spring that is left; q = 0: it sticks. With the mean of the spring over the step the ledger closes in second
 * order, jumps of the spring included. While a contact slides friction takes all, its dashpot's part included: the
 * slider may go further than the contact, so that parts by themselves would be of either sign. */
LANES_INLINE void NAME(slip)(const struct NAME(law) * law, const struct NAME(touch) * touch,
                             const struct NAME(memory) * memory, struct NAME(contact_result) * result,
                             struct NAME(sums) * sums)
{
    const real q = (real_all(1.0) - touch->factor) * real_all(law->inv_kt), slip = q * touch->pull2;
    NAME(viscous_add)(real_load(memory->sliding), touch->viscous, &sums->stuck, &sums->slid);
    sums->slip = sums->slip + slip;
    sums->slip2 = real_fma(q, slip, sums->slip2);
    sums->power = real_fma(q, touch->power, sums->power);
    NAME(slip_by)(q, touch, memory, result);
}

LANES_INLINE void NAME(friction_totals_add)(const struct NAME(totals) * totals, const struct contact_law_constants *law,
                                            double dt_s, const struct law_units *units, struct contact_losses *losses)
{
    const double power = units->speed * NAME(doubles_sum)(totals->power), speed2 = units->speed * units->speed;
    losses->viscous_tangential += law->gamma_t * dt_s * speed2 * NAME(doubles_sum)(totals->stuck);
    losses->friction += units->force * NAME(doubles_sum)(totals->slip) -
                        0.5 * law->kt * (NAME(doubles_sum)(totals->slip2) + dt_s * power) +
                        law->gamma_t * (dt_s * speed2 * NAME(doubles_sum)(totals->slid) - power);
}
