/* What the tangential laws share: the way of a contact along itself, whether it sticks or slides, and what one that
 * slides keeps of its spring and force. Parameters as of contact_law_tmpl.h. */

/* Factor to bring a force of square `square` > 0 down to `to`. */
LANES_INLINE real NAME(ratio)(real to, real square)
{
#if SINGLE
    return to / f32_sqrt(square);
#else
    return to * lanes_rsqrt(square, f64_rsqrt_seed(square));
#endif
}

/* The part along the tangent plane of a velocity g of the centres, of which `along` is along n, and of w; gt: that of
 * the centres alone (3D). Open contacts: 0. */
LANES_INLINE void NAME(tangent)(const struct NAME(meeting) * at, real_mask active, const real *g, real along,
                                const real *w, real *gt, real *vt)
{
    const real *n = at->n, arm = at->arm;
#if DIM == 2
    /* tangent (-n1, n0) */
    (void)along;
    (void)gt;
    vt[0] = real_where(active, real_fma(g[1], n[0], real_fma(-g[0], n[1], -arm * w[0])));
#else
    for (int c = 0; c < 3; c++) { /* g + n x w - along n */
        int d = (c + 1) % 3, e = (c + 2) % 3;
        gt[c] = real_fma(-along, n[c], g[c]);
        vt[c] = real_where(active, real_fma(n[d], arm * w[e], real_fma(-n[e], arm * w[d], gt[c])));
    }
#endif
}

/* How contacts go along themselves in a step: the way [m], to half a step ahead of the end
 * from half a step ahead of its start; the time that goes by; and, of those that were open at its start, the squares of
 * how long and how far they are ahead of where they start. */
struct NAME(travel) {
    real way[SPRINGS], step, ahead2, start2;
    bool fresh; /* some were open */
};

/* Contacts that were open a step ago, as far as their speed tells, have moved along themselves from the moment on at
 * which they touched: delta/(-u) ago. What they kept from before is nothing. Few sets have such a contact. */
LANES_INLINE void NAME(start)(const struct NAME(law) * law, real_mask old, const struct NAME(meeting) * at,
                              const struct NAME(memory) * memory, struct NAME(travel) * t)
{
    const real half = real_all((scalar)0.5 * law->dt);
    const real since = at->delta * real_all(law->unit) / -at->u, ahead = since - half;
    for (int c = 0; c < SPRINGS; c++)
        NAME(forget)(memory->spring[c], memory->rest[c], old);
#if ROLLING
    for (int c = 0; c < SPRINGS; c++)
        NAME(forget)(memory->rolling[c], memory->rolling_rest[c], old);
#endif
#if TORSION
    NAME(forget)(memory->torsion, memory->torsion_rest, old);
#endif
    t->step = real_select(old, t->step, since + half);
    t->ahead2 = real_select(old, real_all(0.0), ahead * ahead);
    t->start2 = real_select(old, real_all(0.0), ahead * ahead * NAME(dot)(at->vt, at->vt));
}

LANES_INLINE void NAME(travel)(const struct NAME(law) * law, const struct NAME(meeting) * at,
                               const struct NAME(memory) * memory, struct NAME(travel) * t)
{
    const real half = real_all((scalar)0.5 * law->dt);
    const real_mask old = real_at_least(at->delta, -at->u * real_all(law->dt_units));
    t->step = real_all(law->dt);
    t->ahead2 = t->start2 = real_all(0.0);
    t->fresh = !REAL(mask_all)(old);
    if (t->fresh)
        NAME(start)(law, old, at, memory, t);
    for (int c = 0; c < SPRINGS; c++)
        t->way[c] = real_fma(t->step, at->vt[c], half * at->lag[c]);
}

#if ROLLING
struct NAME(two) {
    real first, second;
};

/* Two factors at once: mixed, with one division for both. */
LANES_INLINE struct NAME(two) NAME(ratios)(real to, real square, real and_to, real and_square)
{
#if SINGLE
    const real root = f32_sqrt(square), and_root = f32_sqrt(and_square), inverse = real_all(1.0) / (root * and_root);
    return (struct NAME(two)){to * (inverse * and_root), and_to * (inverse * root)};
#else
    return (struct NAME(two)){NAME(ratio)(to, square), NAME(ratio)(and_to, and_square)};
#endif
}
#endif

/* What a contact keeps of its test force. */
LANES_INLINE void NAME(keep)(const struct NAME(law) * law, struct NAME(touch) * touch,
                             const struct NAME(memory) * memory)
{
    const real one = real_all(1.0), least = real_all(0x1p-120);
    real_mask slides = real_greater(touch->pull2, touch->bound2);
    /* in units of force of the scene, so that the root, of which only contacts that slide take notice, is finite */
    const real per = real_all(law->per_force), pull2 = real_larger(touch->pull2 * (per * per), least);
#if ROLLING
    struct NAME(rolled) *rolled = &touch->rolling;
    const real rolled2 = real_larger(rolled->pull2 * (per * per), least), bound = rolled->factor;
    const struct NAME(two) both = NAME(ratios)(touch->kinetic * per, pull2, bound * per, rolled2);
    const real reduced = both.first;
    rolled->factor = real_select(real_greater(rolled->pull2, bound * bound), both.second, one);
#else
    const real reduced = NAME(ratio)(touch->kinetic * per, pull2);
#endif
    touch->factor = real_select(slides, reduced, one);
    real_store(memory->sliding, real_where(real_and(slides, touch->active), one));
}

/* A contact slips: what it remembers goes back by `back` of the test force (0: it sticks). Forces, with what it keeps
 * of the test force, and moment. */
LANES_INLINE void NAME(slip_by)(real back, const struct NAME(touch) * touch, const struct NAME(memory) * memory,
                                struct NAME(contact_result) * result)
{
    const real *n = touch->n;
    real pull[SPRINGS];
    for (int c = 0; c < SPRINGS; c++) {
        const real after = real_fma(-back, touch->pull[c], touch->moved[c]);
        NAME(remember)(memory->spring[c], memory->rest[c], touch->active, after);
        pull[c] = touch->factor * touch->pull[c]; /* the tangential force on j */
    }
#if DIM == 2
    result->force[0] = real_fma(touch->pressing, n[0], -pull[0] * n[1]);
    result->force[1] = real_fma(touch->pressing, n[1], pull[0] * n[0]);
    result->moment[0] = -touch->arm * pull[0];
#else
    for (int c = 0; c < 3; c++) {
        result->force[c] = real_fma(touch->pressing, n[c], pull[c]);
        result->moment[c] = touch->arm * NAME(cross)(pull, n, c);
    }
#endif
}

/* What the dashpots of contacts that stick (slides = 0) or slide (1) would take, as sums apart. */
LANES_INLINE void NAME(viscous_add)(real slides, real viscous, real *stuck, real *slid)
{
    *stuck = real_fma(real_all(1.0) - slides, viscous, *stuck);
    *slid = real_fma(slides, viscous, *slid);
}

LANES_INLINE void NAME(friction_sums_close)(struct NAME(sums) * sums, struct NAME(totals) * totals)
{
    NAME(close)(&sums->stuck, &totals->stuck);
    NAME(close)(&sums->slid, &totals->slid);
    NAME(close)(&sums->slip, &totals->slip);
    NAME(close)(&sums->slip2, &totals->slip2);
    NAME(close)(&sums->power, &totals->power);
#if MINDLIN
    NAME(close)(&sums->power_t, &totals->power_t);
    NAME(close)(&sums->stiffness, &totals->stiffness);
#endif
}
