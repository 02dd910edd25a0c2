/* What one contact does at a complete step, from the state alone: the law's own text for one lane in double, with no
 * time passing. Parameters as of contact_law_tmpl.h; SINGLE 0. */

/* lever_s: the time step that springs are half of ahead. */
LANES_INLINE struct NAME(law) NAME(law_of_look)(const struct contact_law_constants *constants, double lever_s)
{
    const struct law_units si = {1, 1, 1};
    return NAME(law_of)(constants, 0, lever_s, &si);
}

/* history: columns of this one contact, changed to no purpose. */
LANES_INLINE void NAME(contact_look)(const struct NAME(law) * law, const struct NAME(sides) * of, void *const *pair,
                                     void *const *history, struct contact_forces *f)
{
    const struct NAME(memory) memory = NAME(memory_at)(pair, history, 0);
    struct NAME(sums) sums = {0};
    const struct NAME(meeting) at = NAME(meet)(law, of);
#if TORSION /* before it slides */
    const double torsion = NAME(twist_test)(law, at.torsion, 0, &memory).pull - law->torsion.gamma * at.torsion;
#endif
    const struct NAME(touch) touch = NAME(touch)(law, &at, &memory, &sums);
#if PER_PAIR
    const struct NAME(pair) own =
        NAME(pair_of)(&law->normal, at.delta, *memory.root_mass, *memory.radius, &memory.normal, &sums.own);
    const double held = own.stored;
#else
    const double elastic = NAME(normal_elastic)(&law->normal, at.delta, &memory.normal, &sums.own);
    const double held = NAME(normal_energy)(&law->normal, at.delta, elastic);
#endif
    *f = (struct contact_forces){.normal = -touch.pressing, .elastic_j = held};
#if FRICTIONAL
    struct NAME(law) undamped = *law;
    undamped.lever -= law->gamma_t;
    undamped.damped = 0;
#if ROLLING
    undamped.rolling.lever -= law->rolling.gamma;
#endif
    const struct NAME(touch) springs = NAME(touch)(&undamped, &at, &memory, &sums);
#if MINDLIN
    f->spring_j = 0.5 * own.inv_kt * springs.pull2;
#else
    f->spring_j = 0.5 * law->inv_kt * springs.pull2;
#endif
#if ROLLING
    f->spring_j += 0.5 * law->rolling.inv_k * springs.rolling.pull2;
    for (int c = 0; c < SPRINGS; c++)
        f->rolling[c] = springs.rolling.pull[c];
#if TORSION
    f->torsion = torsion;
    f->spring_j += 0.5 * law->torsion.inv_k * torsion * torsion;
#endif
#endif
#if DIM == 2
    f->spring[0] = springs.pull[0];
    f->tangential[0] = touch.pull[0] * touch.n[1];
    f->tangential[1] = -touch.pull[0] * touch.n[0];
#else
    for (int c = 0; c < 3; c++) {
        f->spring[c] = springs.pull[c];
        f->tangential[c] = -touch.pull[c];
    }
#endif
#endif
    for (int c = 0; c < DIM; c++)
        f->total[c] = f->normal * touch.n[c] + f->tangential[c];
}
