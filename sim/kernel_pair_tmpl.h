/* Pairs and walls: from the particles' records to forces and their sums; parameters as of kernel_law_tmpl.h. */

/* What of a pair comes from the records and the list. */
struct NAME(approach) {
    real d[DIM], g[DIM], w[3], spin[3]; /* the last three as the law wants them */
#if SINGLE
    real gap, reach; /* reach^2 - d^2, from double; reach */
#else
    real d2; /* squared distance */
#endif
};

/* The same with normal and overlap. */
struct NAME(meeting) {
    real n[DIM], g[DIM], w[3], spin[3], delta;
};

/* Records of LANES particles: position against `from`, [DIM][PARTS], velocity and rotation. */
struct NAME(other) {
    f64 d[DIM][PARTS];
    real v[DIM], omega[3];
};

/* `from`[DIM]: arrays of LANES coordinates, of which those of the records are taken off. */
LANES_INLINE struct NAME(other) NAME(other)(const double *record, const uint32_t *row, const double *const *from)
{
    struct NAME(other) to;
#if SINGLE
    f64 first[PARTS], second[PARTS];
    for (int h = 0; h < PARTS; h++) {
        f64 block[4];
        f64_gather4(record, row + h * F64_LANES, block);
        for (int c = 0; c < DIM; c++)
            to.d[c][h] = f64_load(from[c] + h * F64_LANES) - block[c];
        first[h] = block[DIM];
        second[h] = block[3];
    }
    f32_split(first, &to.v[0], &to.v[1]);
    (void)second;
#if DIM == 2 && FRICTIONAL
    real air;
    f32_split(second, &to.omega[0], &air);
#elif DIM == 3
    f32 block[4];
    f32_gather4(record + 4, row, block);
    to.v[2] = block[0];
    for (int c = 0; c < 3; c++)
        to.omega[c] = block[1 + c];
#endif
#else
    f64 block[4];
    f64_gather4(record, row, block);
    for (int c = 0; c < DIM; c++)
        to.d[c][0] = f64_load(from[c]) - block[c];
#if DIM == 2
    to.v[0] = block[2];
    to.v[1] = block[3];
#if FRICTIONAL
    f64_gather4(record + 4, row, block);
    to.omega[0] = block[0];
#endif
#else
    f64_gather4(record + 4, row, block);
    for (int c = 0; c < 3; c++)
        to.v[c] = block[c];
#if FRICTIONAL
    f64_gather4(record + 8, row, block);
    for (int c = 0; c < 3; c++)
        to.omega[c] = block[c];
#endif
#endif
#endif
    return to;
}

/* First part of a set of pairs: the particles i from `first` on, side by side, and the records of j. */
LANES_INLINE struct NAME(approach)
    NAME(approach)(const struct particles *p, const struct contact_slots *slots, size_t k)
{
    struct NAME(approach) to = {0};
    const size_t i = (size_t)slots->first[k / SET_WIDTH] + k % SET_WIDTH;
    const double *from[DIM];
    for (int c = 0; c < DIM; c++)
        from[c] = p->x[c] + i;
    struct NAME(other) j = NAME(other)(p->record, slots->row + k, from);
#if SINGLE
    f64 gap[PARTS];
    for (int h = 0; h < PARTS; h++) {
        gap[h] = f64_load(slots->reach2 + k + (size_t)h * F64_LANES);
        for (int c = 0; c < DIM; c++)
            gap[h] = f64_fma(-j.d[c][h], j.d[c][h], gap[h]);
    }
    to.gap = f32_of(gap);
    for (int c = 0; c < DIM; c++) {
        to.d[c] = f32_of(j.d[c]);
        to.g[c] = f32_load(p->view_v[c] + i) - j.v[c];
    }
    to.reach = real_load((const scalar *)slots->reach + k);
#else
    for (int c = 0; c < DIM; c++) {
        to.d[c] = j.d[c][0];
        to.g[c] = f64_load(p->v[c] + i) - j.v[c];
    }
    to.d2 = f64_fma(to.d[1], to.d[1], to.d[0] * to.d[0]);
#if DIM == 3
    to.d2 = f64_fma(to.d[2], to.d[2], to.d2);
#endif
#endif
#if FRICTIONAL
#if SINGLE
    real a_i = f32_load(p->view_radius + i), a_j = to.reach - a_i;
#else
    real a_i = f64_load(p->radius + i), a_j = real_load((const scalar *)slots->reach + k) - a_i;
#endif
    for (int c = 0; c < SPRINGS; c++) {
#if SINGLE
        real omega_i = f32_load(p->view_omega[c] + i);
#else
        real omega_i = f64_load(p->omega[c] + i);
#endif
        to.w[c] = real_fma(a_i, omega_i, a_j * j.omega[c]);
        to.spin[c] = omega_i + j.omega[c];
    }
#endif
    return to;
}

LANES_INLINE struct NAME(memory) NAME(memory_at)(const struct contact_slots *slots, size_t k)
{
    struct NAME(memory) memory = {0};
    (void)slots;
    (void)k;
#if HYSTERETIC
    memory.history = (scalar *)slots->history + k;
#endif
#if FRICTIONAL
    memory.sliding = (scalar *)slots->sliding + k;
    for (int c = 0; c < SPRINGS; c++) {
        memory.spring[c] = (scalar *)slots->spring[c] + k;
        memory.rest[c] = (scalar *)slots->rest[c] + k;
    }
#endif
    return memory;
}

/* Second part: roots and divisions. */
LANES_INLINE struct NAME(meeting)
    NAME(meet)(const struct NAME(approach) * from, const struct contact_slots *slots, size_t k)
{
    struct NAME(meeting) to;
#if SINGLE
    /* delta = (reach^2 - d^2)/(reach + d): only the difference needs double */
    real d2 = real_fma(from->reach, from->reach, -from->gap), distance = f32_sqrt(d2), sum = from->reach + distance;
    real both = real_all(1.0) / (distance * sum), inverse = both * sum;
    to.delta = from->gap * (both * distance);
    (void)slots;
    (void)k;
#else
    real inverse = lanes_rsqrt(from->d2, f64_rsqrt_seed(from->d2)), distance = from->d2 * inverse;
    to.delta = real_load((const scalar *)slots->reach + k) - distance;
#endif
    for (int c = 0; c < DIM; c++) {
        to.n[c] = from->d[c] * inverse;
        to.g[c] = from->g[c];
    }
    for (int c = 0; c < 3; c++) {
        to.w[c] = from->w[c];
        to.spin[c] = from->spin[c];
    }
    return to;
}

/* Third part: the law's first half. */
LANES_INLINE struct NAME(touch) NAME(touch_at)(const struct NAME(law) * law, const struct NAME(meeting) * at,
                                               const struct contact_slots *slots, size_t k, struct NAME(sums) * sums)
{
    struct NAME(memory) memory = NAME(memory_at)(slots, k);
    return NAME(touch)(law, at->delta, at->n, at->g, at->w, at->spin, &memory, sums);
}

/* Adds forces and moments to the rows of j, one lane after the other. Padding slots add zeros to the padding particle.
 */
LANES_INLINE void NAME(add_rows)(void *force, const uint32_t *row, const struct NAME(contact_result) * result)
{
    const real zero = real_all(0.0);
    (void)zero;
#if DIM == 2 && !FRICTIONAL
    REAL(add2)(force, row, result->force);
#elif DIM == 2
    real column[4] = {result->force[0], result->force[1], result->moment[0], zero};
    REAL(add4)(force, row, column);
#elif !FRICTIONAL
    real column[4] = {result->force[0], result->force[1], result->force[2], zero};
    REAL(add4)(force, row, column);
#elif SINGLE
    real column[8] = {result->force[0],  result->force[1],  result->force[2],  zero,
                      result->moment[0], result->moment[1], result->moment[2], zero};
    f32_add8(force, row, column);
#else
    real column[4] = {result->force[0], result->force[1], result->force[2], zero};
    real moment[4] = {result->moment[0], result->moment[1], result->moment[2], zero};
    f64_add4(force, row, column);
    f64_add4((double *)force + FORCE_MOMENT(3), row, moment);
#endif
}

/* Last part: sums of the particles j, and of i, which are side by side. own: column of force 0, `rows` from one to the
 * next. */
LANES_INLINE void NAME(add_pair)(void *force, scalar *own, int rows, const struct contact_slots *slots, size_t k,
                                 const struct NAME(contact_result) * result)
{
    scalar *to = own + (size_t)slots->first[k / SET_WIDTH] + k % SET_WIDTH;
    NAME(add_rows)(force, slots->row + k, result);
    for (int c = 0; c < DIM; c++, to += rows)
        real_store(to, real_load(to) - result->force[c]);
#if FRICTIONAL
    for (int c = 0; c < SPRINGS; c++, to += rows)
        real_store(to, real_load(to) + result->moment[c]);
#endif
}

/* The sets of contacts are independent but for the sums, and each is one long chain of operations. The chain is cut in
 * parts that run at a time. With friction: set k + 3 is approached, roots are drawn for set k + 2, the law's first half
 * is done for set k + 1 and its second for set k, and set k - 1 is added up; without, the halves are one part. What is
 * read behind the last set is room for more, and is not used. */
static void NAME(pair)(const struct particles *p, struct contact_list *pairs, int first, int last,
                       const struct contact_law_constants *constants, void *force, struct contact_losses *losses)
{
    enum { CLOSE_EVERY = 1024 }; /* slots: sums in float stay short */
    const struct NAME(law) law = NAME(law_of)(constants);
    const struct contact_slots slots = pairs->slots;
    struct NAME(sums) sums = {0};
    const size_t start = (size_t)first * SET_WIDTH, end = (size_t)last * SET_WIDTH;
    const int rows = p->n_rows;
    scalar *own = (scalar *)((char *)force + PARTICLES_OWN_OFFSET(rows, DIM, FRICTIONAL, SINGLE));
    if (start >= end)
        return;
    enum { AHEAD = FRICTIONAL ? LANES : 0 }; /* of the law's first half */
    struct NAME(contact_result) done = {0};
    struct NAME(approach) near = NAME(approach)(p, &slots, start);
    struct NAME(meeting) met = NAME(meet)(&near, &slots, start);
    near = NAME(approach)(p, &slots, start + LANES);
#if FRICTIONAL
    struct NAME(touch) next = NAME(touch_at)(&law, &met, &slots, start, &sums);
    met = NAME(meet)(&near, &slots, start + LANES);
    near = NAME(approach)(p, &slots, start + 2 * LANES);
#endif
    for (size_t k = start; k < end; k += LANES) {
        struct NAME(meeting) at = met;
        met = NAME(meet)(&near, &slots, k + LANES + AHEAD);
        near = NAME(approach)(p, &slots, k + 2 * LANES + AHEAD);
#if FRICTIONAL
        struct NAME(touch) now = next;
        if (k + LANES < end)
            next = NAME(touch_at)(&law, &at, &slots, k + LANES, &sums);
#else
        struct NAME(touch) now = NAME(touch_at)(&law, &at, &slots, k, &sums);
#endif
        struct NAME(memory) memory = NAME(memory_at)(&slots, k);
        struct NAME(contact_result) result = NAME(force)(&law, &now, &memory, &sums);
        if (k > start)
            NAME(add_pair)(force, own, rows, &slots, k - LANES, &done);
        if (SINGLE && k % CLOSE_EVERY == 0)
            NAME(sums_close)(&sums, constants, losses);
        done = result;
    }
    NAME(add_pair)(force, own, rows, &slots, end - LANES, &done);
    NAME(sums_close)(&sums, constants, losses);
}

/* The same law against one flat wall: delta = a - distance; the wall moves along its normal and does not rotate. Its
 * force is summed in SET_WIDTH columns, for the same bits in every instruction set. */
static void NAME(wall)(struct particles *p, struct wall *wall, const struct contact_law_constants *constants,
                       struct contact_losses *losses)
{
    static const double origin[LANES] = {0};
    const struct contact_slots slots = wall->contacts.slots;
    const struct NAME(law) law = NAME(law_of)(constants);
    const double *from[DIM];
    double columns[SET_WIDTH] = {0}, total = 0;
    struct NAME(sums) sums = {0};
    real n[DIM];
    for (int c = 0; c < DIM; c++) {
        from[c] = origin;
        n[c] = real_all(c == wall->axis ? wall->inward : 0.0);
    }
    for (size_t k = 0; k < (size_t)wall->contacts.n_sets * SET_WIDTH; k += LANES) {
        struct NAME(other) i = NAME(other)(p->record, slots.row + k, from); /* d = -x */
        real g[DIM], w[3] = {0}, spin[3] = {0};
        f64 delta[PARTS];
        for (int h = 0; h < PARTS; h++) {
            f64 x = i.d[0][h];
            for (int c = 1; c < DIM; c++)
                x = c == wall->axis ? i.d[c][h] : x;
            delta[h] = f64_load(slots.reach2 + k + h * F64_LANES) + f64_all(wall->inward) * (x + f64_all(wall->x));
        }
        for (int c = 0; c < DIM; c++)
            g[c] = i.v[c] - real_all(c == wall->axis ? wall->v : 0.0);
#if FRICTIONAL
        real a_i = real_load((const scalar *)slots.reach + k);
        for (int c = 0; c < SPRINGS; c++) {
            w[c] = a_i * i.omega[c];
            spin[c] = i.omega[c];
        }
#endif
        struct NAME(memory) memory = NAME(memory_at)(&slots, k);
#if SINGLE
        real overlap = f32_of(delta);
#else
        real overlap = delta[0];
#endif
        struct NAME(touch) touch = NAME(touch)(&law, overlap, n, g, w, spin, &memory, &sums);
        struct NAME(contact_result) result = NAME(force)(&law, &touch, &memory, &sums);
        for (int c = 0; c < DIM; c++)
            result.force[c] = -result.force[c];
        NAME(add_rows)(p->force, slots.row + k, &result);
        real onto = result.force[0];
        for (int c = 1; c < DIM; c++)
            onto = c == wall->axis ? result.force[c] : onto;
        f64 part[PARTS];
#if SINGLE
        f32_widen(onto, part);
#else
        part[0] = onto;
#endif
        for (int h = 0; h < PARTS; h++) {
            double *column = columns + k % SET_WIDTH + h * F64_LANES;
            f64_store(column, f64_load(column) + part[h]);
        }
    }
    NAME(sums_close)(&sums, constants, losses);
    for (int c = 0; c < SET_WIDTH; c++)
        total += columns[c];
    wall->force = total * wall->inward;
}
