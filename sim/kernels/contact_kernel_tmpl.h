/* Pairs and walls: from the particles' records to forces and their sums; parameters as of contact_law_tmpl.h. */

/* Where particle i stands in a column of the views, and of the sums. */
LANES_INLINE size_t NAME(view_at)(size_t i)
{
    return COLUMN_AT(VIEW_COLUMNS(DIM, FRICTIONAL, SINGLE), i);
}
LANES_INLINE size_t NAME(sum_at)(size_t i)
{
    return COLUMN_AT(SUMS_COLUMNS(DIM, FRICTIONAL), i);
}

/* Records of LANES particles: position, velocity, rotation, and lags (particles.h). Single: positions are those of the
 * lists plus so many quanta, integers in a float's place. */
struct NAME(other) {
    real x[DIM], v[DIM], omega[3], lag[DIM], lag_omega[3];
};

#if FRICTIONAL
/* Lags as views and records have them. */
LANES_INLINE void NAME(lags_of)(const real *kept, struct NAME(other) * to)
{
#if SINGLE && DIM == 3
    for (int c = 0; c < 3; c++) {
        to->lag[c] = f32_first(kept[c]);
        to->lag_omega[c] = f32_second(kept[c]);
    }
#else
    for (int c = 0; c < DIM; c++)
        to->lag[c] = kept[c];
    for (int c = 0; c < SPRINGS; c++)
        to->lag_omega[c] = kept[DIM + c];
#endif
}
#endif

LANES_INLINE struct NAME(other) NAME(other)(const struct particles *p, const uint32_t *row)
{
    struct NAME(other) to = {0};
    real block[16];
#if SINGLE
#if FRICTIONAL
    f32_gather8(p->record, row, block);
    if (DIM == 3)
        f32_gather4((const double *)p->record + 4, row, block + 8);
#elif DIM == 2
    f32_gather4(p->record, row, block);
#else
    f32_gather8(p->record, row, block);
#endif
    for (int c = 0; c < DIM; c++) {
        to.x[c] = block[c];
        to.v[c] = block[DIM + c];
    }
#if FRICTIONAL
    for (int c = 0; c < SPRINGS; c++)
        to.omega[c] = block[2 * DIM + c];
    NAME(lags_of)(block + 2 * DIM + SPRINGS, &to);
#endif
#else
    const double *record = p->record;
    f64_gather4(record, row, block);
#if DIM == 2
    for (int c = 0; c < 2; c++) {
        to.x[c] = block[c];
        to.v[c] = block[2 + c];
    }
#else
    f64_gather4(record + 4, row, block + 4);
    for (int c = 0; c < 3; c++) {
        to.x[c] = block[c];
        to.v[c] = block[4 + c];
    }
#endif
#if FRICTIONAL && DIM == 2
    f64_gather4(record + 4, row, block + 4);
    to.omega[0] = block[4];
    NAME(lags_of)(block + 5, &to);
#elif FRICTIONAL
    f64_gather4(record + 8, row, block + 8);
    f64_gather4(record + 12, row, block + 12);
    const real lags[6] = {block[3], block[7], block[11], block[12], block[13], block[14]};
    for (int c = 0; c < 3; c++)
        to.omega[c] = block[8 + c];
    NAME(lags_of)(lags, &to);
#endif
#endif
    return to;
}

/* LANES particles that stand side by side, or in two halves if that is more than a half has. */
struct NAME(seats) {
    size_t first, second; /* the first of each half */
    bool together;        /* a constant */
};

LANES_INLINE real NAME(load_at)(const scalar *values, const struct NAME(seats) * at)
{
#if DIM == 2 && LANES > 8
    if (!at->together)
        return REAL(load_halves)(values + at->first, values + at->second);
#endif
    return real_load(values + at->first);
}

/* Takes x from the sums. */
LANES_INLINE void NAME(subtract_at)(scalar *sums, const struct NAME(seats) * at, real x)
{
#if DIM == 2 && LANES > 8
    if (!at->together) {
        REAL(subtract_halves)(sums + at->first, sums + at->second, x);
        return;
    }
#endif
    real_store(sums + at->first, real_load(sums + at->first) - x);
}

/* Where they stand in a column of the views. */
LANES_INLINE struct NAME(seats) NAME(view_seats)(const struct NAME(seats) * at)
{
    return (struct NAME(seats)){NAME(view_at)(at->first), NAME(view_at)(at->second), at->together};
}

/* A column of the views: of those who stand there, or of those right behind them. */
LANES_INLINE real NAME(view)(const void *column, const struct NAME(seats) * at, const struct NAME(seats) * next)
{
    const real here = NAME(load_at)(column, at);
    return next ? REAL(behind)(here, real_load((const scalar *)column + next->first)) : here;
}

/* LANES particles that stand side by side, or, `behind`, those right behind them. */
LANES_INLINE struct NAME(other) NAME(beside)(const struct particles *p, const struct NAME(seats) * seats, bool behind)
{
    struct NAME(other) to = {0};
    const struct NAME(seats) beyond = {.first = seats->first + LANES, .together = true};
    const struct NAME(seats) view = NAME(view_seats)(seats), view_beyond = NAME(view_seats)(&beyond);
    const struct NAME(seats) *at = &view, *next = behind ? &view_beyond : NULL;
    for (int c = 0; c < DIM; c++) {
#if SINGLE
        to.x[c] = NAME(view)(p->view_u[c], at, next);
#else
        const struct NAME(seats) plain = {seats->first + behind, seats->second + behind, seats->together};
        to.x[c] = NAME(load_at)(p->x[c], &plain);
#endif
        to.v[c] = NAME(view)(p->view_v[c], at, next);
    }
#if FRICTIONAL
    real lags[6];
    for (int c = 0; c < LAG_COLUMNS(DIM, SINGLE); c++)
        lags[c] = NAME(view)(p->view_lag[c], at, next);
    for (int c = 0; c < SPRINGS; c++)
        to.omega[c] = NAME(view)(p->view_omega[c], at, next);
    NAME(lags_of)(lags, &to);
#endif
    return to;
}

/* What a range of sets is done with; `kind` of the functions below, a constant, is that of all of them. */
struct NAME(range) {
    const struct particles *p;
    struct contact_slots slots;
    struct NAME(law) law;
    scalar unit, per_unit;
    size_t first, last; /* sets */
    void *force;
    scalar *own; /* column of force 0 */
};

/* The particles i of a set from its slot l on. */
LANES_INLINE struct NAME(seats) NAME(seats)(const struct NAME(range) * r, enum pair_kind kind, size_t set, size_t l)
{
    const uint32_t *first = r->slots.first + 2 * set;
    if (kind != PAIRS_HALVES)
        return (struct NAME(seats)){.first = first[0] + l, .together = true};
    if (DIM == 2 && LANES > HALF_WIDTH)
        return (struct NAME(seats)){.first = first[0], .second = first[1]};
    return (struct NAME(seats)){.first = first[l / HALF_WIDTH] + l % HALF_WIDTH, .together = true};
}

/* First part of LANES pairs of a set, from its slot l on: what the law wants to know of them but for the root of the
 * distance, for which the reach is in the place of `inverse` and, mixed, reach^2 - d^2 in that of delta. */
LANES_INLINE struct NAME(sides) NAME(approach)(const struct NAME(range) * r, enum pair_kind kind, size_t set, size_t l)
{
    const struct particles *p = r->p;
    const struct contact_slots *slots = &r->slots;
    struct NAME(sides) at;
    const size_t k = set * SET_WIDTH + l;
    const struct NAME(seats) seats = NAME(seats)(r, kind, set, l);
    at.inverse = real_load((const scalar *)slots->reach + k);
    const struct NAME(other) i = NAME(beside)(p, &seats, false), j = kind == PAIRS_NEXT
                                                                         ? NAME(beside)(p, &seats, true)
                                                                         : NAME(other)(p, slots->partner + k);
#if SINGLE
    /* d = D + u_i - u_j in quanta, D at the last build; reach^2 - d^2 = (reach^2 - D^2) - (d + D)(d - D), of which
     * nothing is a difference of large numbers */
    real gap = real_load(slots->gap + k);
    for (int c = 0; c < DIM; c++) {
        real built = real_load(slots->built[c] + k), moved = f32_of_difference(i.x[c], j.x[c]);
        at.d[c] = built + moved;
        gap = real_fma(-moved, at.d[c] + built, gap);
    }
    at.delta = gap;
#else
    for (int c = 0; c < DIM; c++)
        at.d[c] = i.x[c] - j.x[c];
    at.delta = real_all(0.0);
#endif
    for (int c = 0; c < DIM; c++)
        at.g[c] = i.v[c] - j.v[c];
#if FRICTIONAL
    const struct NAME(seats) view = NAME(view_seats)(&seats);
    real a_i = NAME(load_at)(p->view_radius, &view), a_j = real_fma(real_all(r->unit), at.inverse, -a_i);
#if ROLLING
    at.radius = a_i;
    at.share = a_j * real_all(r->per_unit); /* over the reach, which `root` divides by */
#endif
    for (int c = 0; c < DIM; c++)
        at.lag[c] = i.lag[c] - j.lag[c];
    for (int c = 0; c < SPRINGS; c++) {
        at.w[c] = real_fma(a_i, i.omega[c], a_j * j.omega[c]);
        at.lag_w[c] = real_fma(a_i, i.lag_omega[c], a_j * j.lag_omega[c]);
#if ROLLING
        at.turning[c] = i.omega[c] - j.omega[c];
        at.lag_turning[c] = i.lag_omega[c] - j.lag_omega[c];
#endif
#if DIM == 3
        at.spin[c] = i.omega[c] + j.omega[c];
#endif
    }
#endif
    return at;
}

/* The root, and with it `inverse`, delta and the lever arms. */
LANES_INLINE void NAME(root)(struct NAME(sides) * at)
{
    const real reach = at->inverse;
#if SINGLE
    /* delta = (reach^2 - d^2)/(reach + |d|) */
    const real_mask active = real_greater(at->delta, real_all(0.0));
    const real d2 = real_fma(reach, reach, -at->delta);
    real distance = f32_sqrt(d2), sum = reach + distance, both = real_all(1.0) / (distance * sum);
    at->inverse = real_where(active, both * sum);
    at->delta = real_where(active, at->delta * (both * distance));
#else
    const real d2 = NAME(inner)(at->d, at->d);
    at->inverse = lanes_rsqrt(d2, f64_rsqrt_seed(d2));
    at->delta = reach - d2 * at->inverse;
#endif
#if FRICTIONAL
    /* d/reach = 1/(1 + x), x = delta/d, without the division: 1/(1 + x) = (1 - x)(1 + x^2)(1 + x^4) ..., to x^8 */
    const real x = at->delta * at->inverse, x2 = x * x, x4 = x2 * x2;
    real arm = real_all(1.0) - x;
    arm = real_fma(x2, arm, arm);
    at->arm = real_fma(x4, arm, arm);
#if ROLLING
    at->share = at->share * (at->arm * at->inverse);
#endif
#endif
}

/* Adds forces and moments to the rows of j, one lane after the other. Padding slots add zeros to the padding particle.
 */
LANES_INLINE void NAME(add_rows)(void *force, const uint32_t *row, const struct NAME(contact_result) * result)
{
#if DIM == 3 || FRICTIONAL
    const real zero = real_all(0.0);
#endif
#if SINGLE
    const int unit = SUMS_BYTES(DIM, FRICTIONAL, 1) / RECORD_STRIDE(DIM, FRICTIONAL, 1);
#define ROW row, unit
#else
#define ROW row
#endif
#if DIM == 2 && !FRICTIONAL
    REAL(add2)(force, ROW, result->force);
#elif DIM == 2
    real column[4] = {result->force[0], result->force[1], result->moment[0], zero};
    REAL(add4)(force, ROW, column);
#elif !FRICTIONAL
    real column[4] = {result->force[0], result->force[1], result->force[2], zero};
    REAL(add4)(force, ROW, column);
#elif SINGLE
    real column[8] = {result->force[0],  result->force[1],  result->force[2],  zero,
                      result->moment[0], result->moment[1], result->moment[2], zero};
    f32_add8(force, ROW, column);
#else
    real column[4] = {result->force[0], result->force[1], result->force[2], zero};
    real moment[4] = {result->moment[0], result->moment[1], result->moment[2], zero};
    f64_add4(force, row, column);
    f64_add4((double *)force + FORCE_MOMENT(3), row, moment);
#endif
#undef ROW
}

/* Last part: sums of the particles j, and of i, which are side by side. If j are the particles behind i, the sums start
 * here, with the forces on i, and on j those of the lane before; `before`: result of the vector before. */
LANES_INLINE void NAME(add_pair)(const struct NAME(range) * r, enum pair_kind kind, size_t set, size_t l,
                                 const struct NAME(contact_result) * result, struct NAME(contact_result) * before)
{
    const struct NAME(seats) particles = NAME(seats)(r, kind, set, l);
    const struct NAME(seats)
        seats = {NAME(sum_at)(particles.first), NAME(sum_at)(particles.second), particles.together};
    const bool next = kind == PAIRS_NEXT;
    scalar *to = r->own;
    if (!next)
        NAME(add_rows)(r->force, r->slots.partner + set * SET_WIDTH + l, result);
    for (int c = 0; c < DIM; c++, to += PARTICLES_BLOCK)
        if (next)
            real_store(to + seats.first, REAL(shifted)(before->force[c], result->force[c]) - result->force[c]);
        else
            NAME(subtract_at)(to, &seats, result->force[c]);
#if FRICTIONAL
#if ROLLING
    const real *own = result->own;
#else
    const real *own = result->moment;
#endif
    for (int c = 0; c < SPRINGS; c++, to += PARTICLES_BLOCK)
        if (next)
            real_store(to + seats.first, REAL(shifted)(before->moment[c], result->moment[c]) + own[c]);
        else
            NAME(subtract_at)(to, &seats, -own[c]);
#endif
    if (next)
        *before = *result;
}

LANES_INLINE struct NAME(contact_result) NAME(no_result)(void)
{
    struct NAME(contact_result) none;
    for (int c = 0; c < DIM; c++)
        none.force[c] = real_all(0.0);
#if FRICTIONAL
    for (int c = 0; c < SPRINGS; c++)
        none.moment[c] = real_all(0.0);
#endif
#if ROLLING
    for (int c = 0; c < SPRINGS; c++)
        none.own[c] = real_all(0.0);
#endif
    return none;
}

/* The sets of contacts are independent but for the sums, and each is one long chain of operations; many of a chain's
 * kind run at a time. So a chunk of sets goes through each part before the next part begins, with what is in between in
 * the nearest cache. With the wider of the vectors a part ends where least has to be kept; the narrower, whose chains
 * are as long, have roots and forces in parts of their own (APART). */
struct NAME(chunk) {
    union {
        struct NAME(sides) sides;
        struct NAME(meeting) at;
        struct NAME(touch) touch;
        struct NAME(contact_result) result;
    } set[CHUNK]; /* each part takes the place of the one before */
};

/* Set m, for the law. */
LANES_INLINE void NAME(keep_meeting)(struct NAME(chunk) * chunk, int m, const struct NAME(law) * law,
                                     const struct NAME(sides) * sides)
{
    if (APART)
        chunk->set[m].sides = *sides;
    else
        chunk->set[m].at = NAME(meet)(law, sides);
}

/* The first half of the law for n sets from slot k on, up to what they keep of their test forces. */
LANES_INLINE void NAME(tests)(struct NAME(chunk) * chunk, const struct NAME(law) * law,
                              const struct contact_slots *slots, size_t k, int n, struct NAME(sums) * sums)
{
    for (int m = 0; m < n; m++) {
        const struct NAME(memory) memory = NAME(memory_at)(slots->pair, slots->history, k + (size_t)m * LANES);
        const struct NAME(meeting) at = APART ? NAME(meet)(law, &chunk->set[m].sides) : chunk->set[m].at;
        struct NAME(touch) touch = NAME(touch)(law, &at, &memory, sums);
#if FRICTIONAL
        if (!APART)
            NAME(keep)(law, &touch, &memory);
#endif
        chunk->set[m].touch = touch;
    }
#if FRICTIONAL
    for (int m = 0; m < n && APART; m++) {
        const struct NAME(memory) memory = NAME(memory_at)(slots->pair, slots->history, k + (size_t)m * LANES);
        NAME(keep)(law, &chunk->set[m].touch, &memory);
    }
#endif
}

/* The second half for set m of them. */
LANES_INLINE struct NAME(contact_result)
    NAME(force_of)(const struct NAME(chunk) * chunk, const struct NAME(law) * law, const struct contact_slots *slots,
                   size_t k, int m, struct NAME(sums) * sums)
{
    const struct NAME(memory) memory = NAME(memory_at)(slots->pair, slots->history, k + (size_t)m * LANES);
    const struct NAME(touch) touch = chunk->set[m].touch;
    return NAME(force)(law, &touch, &memory, sums);
}

/* The law for n sets from slot k on, but for forces that are found where they are added. */
LANES_INLINE void NAME(laws)(struct NAME(chunk) * chunk, const struct NAME(law) * law,
                             const struct contact_slots *slots, size_t k, int n, struct NAME(sums) * sums)
{
    NAME(tests)(chunk, law, slots, k, n, sums);
    for (int m = 0; m < n && APART; m++)
        chunk->set[m].result = NAME(force_of)(chunk, law, slots, k, m, sums);
}

/* What set m of them gives. */
LANES_INLINE struct NAME(contact_result)
    NAME(result_of)(const struct NAME(chunk) * chunk, const struct NAME(law) * law, const struct contact_slots *slots,
                    size_t k, int m, struct NAME(sums) * sums)
{
    if (APART)
        return chunk->set[m].result;
    return NAME(force_of)(chunk, law, slots, k, m, sums);
}

/* Sets from slot k on that fit in a chunk, up to `end`. */
LANES_INLINE int NAME(chunk_size)(size_t k, size_t end)
{
    return end - k < CHUNK * LANES ? (int)((end - k) / LANES) : CHUNK;
}

#if DIM == 2 && !FRICTIONAL
/* Few values are on their way here, and so registers hold them: vector k + 2 is approached, roots are drawn for vector
 * k + 1, the law is that of vector k, and vector k - 1 (in double, which fills registers sooner, k itself) is added up;
 * nothing, before the first one. */
struct NAME(under_way) {
    struct NAME(sides) near, next;
    struct NAME(contact_result) done, before;
    size_t done_set, done_l;
};

/* Slots in the order in which their rows are added up, which wider vectors do two at once (lanes_reference.h). */
LANES_INLINE size_t NAME(in_turn)(enum pair_kind kind, size_t l)
{
    if (LANES > 1 || !SINGLE || kind == PAIRS_NEXT)
        return l;
    return l / HALF_WIDTH * HALF_WIDTH + l % HALF_WIDTH / 2 + l % 2 * (HALF_WIDTH / 2);
}

LANES_INLINE void NAME(go_on)(const struct NAME(range) * r, enum pair_kind kind, size_t set, size_t turn,
                              struct NAME(under_way) * way, struct NAME(sums) * sums)
{
    const size_t l = NAME(in_turn)(kind, turn), ahead = turn + 2 * LANES, set_ahead = set + ahead / SET_WIDTH;
    struct NAME(memory) memory = NAME(memory_at)(r->slots.pair, r->slots.history, set * SET_WIDTH + l);
    const struct NAME(meeting) at = NAME(meet)(&r->law, &way->next);
    way->next = way->near;
    NAME(root)(&way->next);
    if (set_ahead < r->last)
        way->near = NAME(approach)(r, kind, set_ahead, NAME(in_turn)(kind, ahead % SET_WIDTH));
    struct NAME(touch) touch = NAME(touch)(&r->law, &at, &memory, sums);
    struct NAME(contact_result) result = NAME(force)(&r->law, &touch, &memory, sums);
    if (SINGLE)
        NAME(add_pair)(r, kind, way->done_set, way->done_l, &way->done, &way->before);
    else
        NAME(add_pair)(r, kind, set, l, &result, &way->before);
    way->done = result;
    way->done_set = set;
    way->done_l = l;
}

LANES_INLINE void NAME(go_through)(const struct NAME(range) * r, enum pair_kind kind, struct NAME(sums) * sums,
                                   struct NAME(totals) * totals)
{
    enum { TOGETHER = CLOSE_EVERY / SET_WIDTH };
    const bool one = LANES == SET_WIDTH && r->first + 1 == r->last; /* there is no second vector */
    struct NAME(under_way) way = {.done_set = r->first};
    way.done = way.before = NAME(no_result)();
    way.next = NAME(approach)(r, kind, r->first, 0);
    way.near = NAME(approach)(r, kind, r->first + (LANES == SET_WIDTH && !one), NAME(in_turn)(kind, LANES % SET_WIDTH));
    NAME(root)(&way.next);
    for (size_t from = r->first, to; from < r->last; from = to) {
        to = from + TOGETHER < r->last ? from + TOGETHER : r->last;
        for (size_t set = from; set < to; set++) {
            for (size_t l = 0; l < SET_WIDTH; l += LANES)
                NAME(go_on)(r, kind, set, l, &way, sums);
        }
        if (SINGLE)
            NAME(sums_close)(sums, totals);
    }
    if (SINGLE)
        NAME(add_pair)(r, kind, way.done_set, way.done_l, &way.done, &way.before);
}
#else
/* n sets of pairs from slot k on, as the law wants them. */
LANES_INLINE void NAME(meet_pairs)(struct NAME(chunk) * chunk, const struct NAME(range) * r, enum pair_kind kind,
                                   size_t k, int n)
{
    for (int m = 0; m < n; m++) {
        const size_t at = k + (size_t)m * LANES;
        struct NAME(sides) sides = NAME(approach)(r, kind, at / SET_WIDTH, at % SET_WIDTH);
        NAME(root)(&sides);
        NAME(keep_meeting)(chunk, m, &r->law, &sides);
    }
}

LANES_INLINE void NAME(go_through)(const struct NAME(range) * r, enum pair_kind kind, struct NAME(sums) * sums,
                                   struct NAME(totals) * totals)
{
    struct NAME(chunk) chunk;
    struct NAME(contact_result) before = NAME(no_result)();
    const size_t start = r->first * SET_WIDTH, end = r->last * SET_WIDTH;
    for (size_t k = start; k < end; k += CHUNK * LANES) {
        const int n = NAME(chunk_size)(k, end);
        NAME(meet_pairs)(&chunk, r, kind, k, n);
        NAME(laws)(&chunk, &r->law, &r->slots, k, n, sums);
        for (int m = 0; m < n; m++) {
            const size_t at = k + (size_t)m * LANES;
            const struct NAME(contact_result) result = NAME(result_of)(&chunk, &r->law, &r->slots, k, m, sums);
            NAME(add_pair)(r, kind, at / SET_WIDTH, at % SET_WIDTH, &result, &before);
        }
        if (SINGLE && (k - start) % CLOSE_EVERY == 0)
            NAME(sums_close)(sums, totals);
    }
}
#endif

/* Large samples: the records of a span's particles and their rows of sums are read in order, as the CPU sees coming,
 * before pairs ask for them here and there. */
LANES_INLINE void NAME(fetch)(const struct particles *p, const void *force, const struct contact_span *span)
{
    enum { RECORD = 8 * RECORD_STRIDE(DIM, FRICTIONAL, SINGLE), SUMS = SUMS_BYTES(DIM, FRICTIONAL, SINGLE), LINE = 64 };
    const volatile char *record = p->record, *sums = force;
    for (size_t b = (size_t)span->first * RECORD; b < (size_t)span->last * RECORD; b += LINE)
        (void)record[b];
    for (size_t b = (size_t)span->first * SUMS; b < (size_t)span->last * SUMS; b += LINE)
        (void)sums[b];
}

/* The sums of a span's blocks start from nothing, where no pairs of neighbours in the order start them. */
static void NAME(start_sums)(const struct NAME(range) * r, const struct contact_span *span)
{
    const size_t first = NAME(sum_at)((size_t)span->first),
                 last = NAME(sum_at)((size_t)span->last + (size_t)(-span->last & (PARTICLES_BLOCK - 1)));
    memset(r->own + first, 0, (last - first) * sizeof(scalar));
}

/* Sets first ... last - 1 of one kind. */
LANES_INLINE void NAME(go_through_sets)(struct NAME(range) * r, enum pair_kind kind, int first, int last,
                                        struct NAME(sums) * sums, struct NAME(totals) * totals)
{
    r->first = (size_t)first;
    r->last = (size_t)last;
    if (first < last)
        NAME(go_through)(r, kind, sums, totals);
}

/* Narrow vectors have no need to tell whole sets from others; in 3D all are whole. */
LANES_INLINE void NAME(go_through_span)(struct NAME(range) * r, const struct contact_span *span,
                                        struct NAME(sums) * sums, struct NAME(totals) * totals)
{
    if (span->next == span->whole)
        NAME(start_sums)(r, span);
    NAME(go_through_sets)(r, PAIRS_NEXT, span->next, span->whole, sums, totals);
    if (DIM == 2 && LANES <= HALF_WIDTH) {
        NAME(go_through_sets)(r, PAIRS_HALVES, span->whole, span->end, sums, totals);
        return;
    }
    NAME(go_through_sets)(r, PAIRS_WHOLE, span->whole, span->halves, sums, totals);
    if (DIM == 2)
        NAME(go_through_sets)(r, PAIRS_HALVES, span->halves, span->end, sums, totals);
}

/* What the contacts of a list count in. */
static struct law_units NAME(units)(const struct particles *p, const struct contact_slots *slots)
{
    return (struct law_units){.length = slots->unit, .speed = p->speed_unit, .force = p->force_unit};
}

static void NAME(pair)(const struct particles *p, struct contact_list *pairs, int first, int last,
                       const struct contact_law_constants *constants, double dt_s, void *force,
                       struct contact_losses *losses)
{
    void *own = (char *)force + PARTICLES_COLUMNS_OFFSET(p->n_rows, DIM, FRICTIONAL, SINGLE);
    const struct law_units units = NAME(units)(p, &pairs->slots);
    struct NAME(range) range = {.p = p,
                                .slots = pairs->slots,
                                .law = NAME(law_of)(constants, dt_s, dt_s, &units),
                                .unit = (scalar)pairs->slots.unit,
                                .per_unit = (scalar)(1 / pairs->slots.unit),
                                .force = force,
                                .own = own};
    const bool large = p->count >= PARTICLES_LARGE_SAMPLE;
    struct NAME(sums) sums = {0};
    struct NAME(totals) totals = {0};
    for (int s = first; s < last; s++) {
        if (large)
            NAME(fetch)(p, force, &pairs->slots.span[s]);
        NAME(go_through_span)(&range, &pairs->slots.span[s], &sums, &totals);
    }
    NAME(sums_close)(&sums, &totals);
    NAME(totals_add)(&totals, constants, dt_s, &units, losses);
}

/* How far the wall has moved in quanta; further than lists reach is as far as it goes. */
LANES_INLINE int32_t NAME(wall_moved)(const struct particles *p, const struct wall *wall)
{
    const double most = 1 << 30, moved = (wall->x - wall->x_list) / p->quantum;
    return (int32_t)nearbyint(moved > most ? most : moved < -most ? -most : moved);
}

/* Overlap of LANES particles with a wall. */
LANES_INLINE real NAME(overlap)(const struct particles *p, const struct wall *wall, size_t k, real x)
{
#if SINGLE
    real moved = f32_of_difference(x, f32_all_integers(NAME(wall_moved)(p, wall)));
    return real_fma(real_all(-wall->inward), moved, real_load(wall->contacts.slots.gap + k));
#else
    (void)p;
    return real_load((const scalar *)wall->contacts.slots.reach + k) - real_all(wall->inward) * (x - real_all(wall->x));
#endif
}

/* First part against a wall, which has no rotation. */
LANES_INLINE struct NAME(sides) NAME(meet_wall)(const struct particles *p, const struct wall *wall, size_t k)
{
    const struct contact_slots *slots = &wall->contacts.slots;
    const struct NAME(other) i = NAME(other)(p, slots->partner + k);
    struct NAME(sides) at;
    real x = i.x[0];
    for (int c = 0; c < DIM; c++) {
        at.d[c] = real_all(c == wall->axis ? wall->inward : 0.0);
        at.g[c] = i.v[c] - real_all(c == wall->axis ? wall->v / p->speed_unit : 0.0);
        x = c == wall->axis ? i.x[c] : x;
    }
    at.delta = real_larger(NAME(overlap)(p, wall, k, x), real_all(0.0));
    at.inverse = real_where(real_greater(at.delta, real_all(0.0)), real_all(1.0));
#if FRICTIONAL
    const real a_i = real_load((const scalar *)slots->reach + k);
    at.arm = real_all(1.0) - at.delta * real_all((scalar)slots->unit) / a_i;
#if ROLLING
    at.radius = a_i;
    at.share = real_all(1.0);
#endif
    for (int c = 0; c < DIM; c++)
        at.lag[c] = i.lag[c]; /* the wall moves along its normal */
    for (int c = 0; c < SPRINGS; c++) {
        at.w[c] = a_i * i.omega[c];
        at.lag_w[c] = a_i * i.lag_omega[c];
#if ROLLING
        at.turning[c] = i.omega[c];
        at.lag_turning[c] = i.lag_omega[c];
#endif
#if DIM == 3
        at.spin[c] = i.omega[c];
#endif
    }
#endif
    return at;
}

/* Adds the forces of a set to the particles' rows and those of the wall to `columns`, of which there are SET_WIDTH, for
 * the same bits in every instruction set. */
LANES_INLINE void NAME(add_wall)(void *force, const struct wall *wall, size_t k, struct NAME(contact_result) result,
                                 double *columns)
{
    for (int c = 0; c < DIM; c++)
        result.force[c] = -result.force[c];
#if ROLLING
    for (int c = 0; c < SPRINGS; c++)
        result.moment[c] = result.own[c];
#endif
    NAME(add_rows)(force, wall->contacts.slots.partner + k, &result);
    real onto = result.force[0];
    for (int c = 1; c < DIM; c++)
        onto = c == wall->axis ? result.force[c] : onto;
    f64 part[PARTS];
    REAL(widen)(onto, part);
    for (int h = 0; h < PARTS; h++) {
        double *column = columns + k % SET_WIDTH + h * F64_LANES;
        f64_store(column, f64_load(column) + part[h]);
    }
}

/* The same law against one flat wall: delta = a - distance; the wall moves along its normal and does not rotate. */
static void NAME(wall)(struct particles *p, struct wall *wall, const struct contact_law_constants *constants,
                       double dt_s, struct contact_losses *losses)
{
    const struct contact_slots slots = wall->contacts.slots;
    const struct law_units units = NAME(units)(p, &slots);
    const struct NAME(law) law = NAME(law_of)(constants, dt_s, dt_s, &units);
    const size_t end = (size_t)wall->contacts.n_sets * SET_WIDTH;
    double columns[SET_WIDTH] = {0}, total = 0;
    struct NAME(sums) sums = {0};
    struct NAME(totals) totals = {0};
    struct NAME(chunk) chunk;
    real touching = real_all(0.0);
    for (size_t k = 0; k < end; k += CHUNK * LANES) {
        const int n = NAME(chunk_size)(k, end);
        for (int m = 0; m < n; m++) {
            const struct NAME(sides) sides = NAME(meet_wall)(p, wall, k + (size_t)m * LANES);
            NAME(keep_meeting)(&chunk, m, &law, &sides);
            touching = touching + real_where(real_greater(sides.delta, real_all(0.0)), real_all(1.0));
        }
        NAME(laws)(&chunk, &law, &slots, k, n, &sums);
        for (int m = 0; m < n; m++) {
            const struct NAME(contact_result) result = NAME(result_of)(&chunk, &law, &slots, k, m, &sums);
            NAME(add_wall)(p->force, wall, k + (size_t)m * LANES, result, columns);
        }
    }
    NAME(sums_close)(&sums, &totals);
    NAME(totals_add)(&totals, constants, dt_s, &units, losses);
    for (int c = 0; c < SET_WIDTH; c++)
        total += columns[c];
    wall->force = total * units.force * wall->inward;
    wall->touching = (int)NAME(doubles_sum)(NAME(doubles_of)(touching));
}
