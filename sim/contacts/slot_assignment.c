#include "sim/contacts/slot_assignment.h"

#include <stdlib.h>
#include <string.h>

/* Large samples are dealt with span by span, by all threads, and in the same way by one: which member has a pair across
 * spans is settled before, evenly, and such pairs are not passed on. */

/* Each particle has a column in a table, with a place for each row of slots of its block, and pairs are put in as keys
 * are into a hash table with two choices for each ("cuckoo hashing"): if the columns of both members are full, one
 * takes the pair and passes another of its pairs on to that one's other member, and so on. */
struct column {
    int32_t next; /* the next free place in the table, t->width behind the last one */
    int32_t room; /* free places */
    int32_t left; /* pairs of the particle that are still to be dealt out; in the end those beyond the table */
    int32_t seen; /* by which search; before that, pairs across spans that it has */
};

/* What a place holds. */
struct entry {
    int32_t pair, other; /* member of the list, and which of its particles this column is not; -1: empty */
};

/* A column that a search has come to. */
struct visit {
    int owner;
    int from, place; /* whose place led here; not for the first two */
};

/* Rows that a block may get beyond those planned, and columns that pay at most, however long the list lives. */
enum { SPARE_ROWS = 2, VISITS_MAX = 256 };

struct table {
    int from, to; /* particles that are dealt with; a table of its own for each group of them, with arrays for all */
    int n_particles, n_blocks;
    int width, span_width; /* particles of a block, of a span */
    bool chained;
    bool apart;    /* partners half a row apart must not be the same one */
    int32_t *next; /* [n_particles] the pair with the particle behind it; -1: none */
    int32_t *pair; /* [n_pairs] the other pairs, which are dealt out; first those across spans */
    int n_pairs, n_across;
    struct column *column;        /* [n_particles] */
    int32_t *planned;             /* [n_blocks] rows; in the end those that there are */
    int32_t *start;               /* [n_blocks + 1] the block's first place in the table */
    int32_t *whole, *lone, *span; /* as in struct slot_assignment */
    struct entry *entry;          /* [start[n_blocks]] set by set */
    struct entry *over;           /* [n_over] pairs that the table has no place for, and who has them */
    int n_over;
    int n_searches, visits_max;
    struct visit visit[VISITS_MAX];
};

static int n_spans(const struct table *t)
{
    return (t->n_particles + t->span_width - 1) / t->span_width;
}

/* Working memory of the list, first without, then with the table's `places`; what stands before them is kept. */
static enum status lay_out(struct table *t, struct contact_list *list, size_t places)
{
    const size_t column = sizeof *t->column / sizeof(int32_t) * (size_t)t->n_particles;
    const size_t blocks = (size_t)t->n_blocks, even = blocks + blocks % 2;
    const size_t own = (size_t)t->n_particles + (size_t)t->n_particles % 2;
    const size_t pairs = (size_t)list->count + (size_t)list->count % 2;
    const size_t spans = 2 * (size_t)(n_spans(t) / 2 + 1);
    const size_t before = column + 4 * even + 6 + spans + own + 3 * pairs;
    const size_t size = before + (places ? 2 * places : pairs); /* first room for the pairs, once more */
    TRY(contact_list_work(list, size, places ? before : 0));
    t->column = (struct column *)list->scratch;
    t->planned = list->scratch + column;
    t->start = t->planned + even;
    t->whole = t->start + even + 2;
    t->lone = t->whole + even + 2;
    t->span = t->lone + even + 2;
    t->next = t->span + spans;
    t->pair = t->next + own;
    t->over = (struct entry *)(t->pair + pairs);
    t->entry = t->over + pairs;
    return STATUS_OK;
}

/* Particles of the table, all in one span if the sample is large, and the list's members of which they are i. */
struct group {
    int from, to;
    int first_member, end_member;
    int n_next;    /* particles with a pair with the one behind them */
    int n_inside;  /* other pairs of two of them */
    int n_leaving; /* pairs with a particle of a group to come */
    int n_across;  /* pairs across groups that are in their slots */
    int first_pair, n_over;
};

struct dealing {
    struct table table;
    struct contact_list *list;
    struct group *group;
    int n_groups;
    const struct slot_assignment *assignment;
};

static int first_member_of(const struct contact_list *list, int particle)
{
    int lo = 0, hi = list->count;
    while (lo < hi) {
        const int middle = lo + (hi - lo) / 2;
        if (list->i[middle] < particle)
            lo = middle + 1;
        else
            hi = middle;
    }
    return lo;
}

static enum status make_groups(struct dealing *d)
{
    const struct table *t = &d->table;
    const bool large = t->n_particles >= PARTICLES_LARGE_SAMPLE;
    d->n_groups = large ? n_spans(t) : 1;
    d->group = calloc((size_t)d->n_groups, sizeof *d->group);
    if (!d->group)
        return status_fail(STATUS_NO_MEMORY, "no memory for the slots of the pairs");
    for (int g = 0; g < d->n_groups; g++) {
        struct group *group = &d->group[g];
        const bool last = g + 1 == d->n_groups;
        group->from = g * t->span_width;
        group->to = last ? t->n_particles : (g + 1) * t->span_width;
        group->first_member = g == 0 ? 0 : d->group[g - 1].end_member;
        group->end_member = last ? d->list->count : first_member_of(d->list, group->to);
    }
    return STATUS_OK;
}

/* Pairs of a particle and the one behind it, but for where a span of blocks ends. Without branches: they could not be
 * predicted. */
static void find_next(void *context, int g)
{
    const struct dealing *d = context;
    const struct table *t = &d->table;
    struct group *group = &d->group[g];
    const int32_t *const i = d->list->i, *const j = d->list->j;
    memset(t->next + group->from, -1, (size_t)(group->to - group->from) * sizeof *t->next);
    for (int k = group->first_member; k < group->end_member; k++) {
        const int32_t is_next = (j[k] == i[k] + 1) & (j[k] % t->span_width != 0);
        t->next[i[k]] = is_next ? k : t->next[i[k]];
    }
    for (int q = group->from; q < group->to; q++)
        group->n_next += t->next[q] >= 0;
}

/* They get sets of their own if these are filled well enough: one costs the kernels 0.6 (2D) to 0.9 (3D) of what
 * another does, and starts the sums. */
static void decide_next(struct dealing *d)
{
    struct table *t = &d->table;
    int n = 0;
    for (int g = 0; g < d->n_groups; g++)
        n += d->group[g].n_next;
    t->chained = 5 * (int64_t)n > 3 * (int64_t)t->n_particles;
    if (!t->chained)
        memset(t->next, -1, (size_t)t->n_particles * sizeof *t->next);
}

/* The other pairs of a group: inside in `pair`, and leaving in `over`, both from the first member on. */
static void sort_out(void *context, int g)
{
    const struct dealing *d = context;
    const struct table *t = &d->table;
    struct group *group = &d->group[g];
    const int32_t *const i = d->list->i, *const j = d->list->j;
    memset(t->column + group->from, 0, (size_t)(group->to - group->from) * sizeof *t->column);
    group->n_inside = group->n_leaving = 0;
    for (int k = group->first_member; k < group->end_member; k++) {
        const bool other = t->next[i[k]] != k, leaves = j[k] >= group->to;
        t->pair[group->first_member + group->n_inside] = k;
        t->over[group->first_member + group->n_leaving].pair = k;
        group->n_inside += other && !leaves;
        group->n_leaving += other && leaves;
    }
}

static struct group *group_of(const struct dealing *d, int particle)
{
    const int g = particle / d->table.span_width;
    return &d->group[g < d->n_groups ? g : d->n_groups - 1];
}

/* A pair across groups goes to the member that has fewer of them. */
static void share_out_across(struct dealing *d)
{
    struct table *t = &d->table;
    for (int g = 0; g < d->n_groups; g++)
        for (int m = 0; m < d->group[g].n_leaving; m++) {
            struct entry *leaving = &t->over[d->group[g].first_member + m];
            const int i = d->list->i[leaving->pair], j = d->list->j[leaving->pair];
            const int owner = t->column[i].seen <= t->column[j].seen ? i : j;
            t->column[owner].seen++;
            leaving->other = owner;
            group_of(d, owner)->n_across++;
        }
}

/* Each group's pairs get places of their own: in `pair`, first those across groups, and in `over`. */
static void gather_pairs(struct dealing *d, int32_t *inside)
{
    struct table *t = &d->table;
    int before = 0;
    if (d->n_groups == 1)
        return;
    memcpy(inside, t->pair, (size_t)d->list->count * sizeof *inside);
    for (int g = 0; g < d->n_groups; g++) {
        struct group *group = &d->group[g];
        group->first_pair = before;
        before += group->n_across + group->n_inside;
        memcpy(t->pair + group->first_pair + group->n_across, inside + group->first_member,
               (size_t)group->n_inside * sizeof *inside);
        group->n_across = 0;
    }
    for (int g = 0; g < d->n_groups; g++)
        for (int m = 0; m < d->group[g].n_leaving; m++) {
            const struct entry *leaving = &t->over[d->group[g].first_member + m];
            struct group *to = group_of(d, leaving->other);
            t->pair[to->first_pair + to->n_across++] = leaving->pair;
        }
}

static bool is_here(const struct table *t, int particle)
{
    return particle >= t->from && particle < t->to;
}

/* The table of a group. */
static struct table table_of(const struct dealing *d, int g)
{
    const struct group *group = &d->group[g];
    struct table t = d->table;
    t.from = group->from;
    t.to = group->to;
    t.pair += group->first_pair;
    t.over += group->first_pair;
    t.n_across = group->n_across;
    t.n_pairs = group->n_across + group->n_inside;
    t.n_over = group->n_over;
    return t;
}

static int block_from(const struct table *t)
{
    return t->from / t->width;
}

static int block_to(const struct table *t)
{
    return (t->to + t->width - 1) / t->width;
}

/* Of a pair across groups the member that is here. */
static int owner_of(const struct table *t, const struct contact_list *list, int k)
{
    return is_here(t, list->i[k]) ? list->i[k] : list->j[k];
}

static void count_pairs(struct table *t, const struct contact_list *list)
{
    for (int m = 0; m < t->n_across; m++)
        t->column[owner_of(t, list, t->pair[m])].left++;
    for (int m = t->n_across; m < t->n_pairs; m++) {
        t->column[list->i[t->pair[m]]].left++;
        t->column[list->j[t->pair[m]]].left++;
    }
}

/* Rows that block b should have, given what it is owed: half the ends of the pairs dealt with so far, and a hundredth,
 * less the places found for them [1/200 of a place]. No particle fills more places than it has pairs; what would be
 * mostly empty is left to the blocks to come. */
static int plan_block(const struct table *t, int b, int lanes, int64_t *owed)
{
    enum { OWED_PER_END = 101, OWED_PER_PLACE = 200, COUNTED = 64 };
    const struct column *column = t->column + t->width * b;
    int of_length[COUNTED] = {0}, rows = 0, filled = lanes;
    for (int l = 0; l < lanes; l++) {
        *owed += (int64_t)OWED_PER_END * (column[l].left + column[l].seen); /* those across spans are whole ones */
        of_length[column[l].left < COUNTED ? column[l].left : COUNTED - 1]++;
    }
    filled -= of_length[0];
    while (2 * *owed > OWED_PER_PLACE * filled && 2 * filled >= lanes && rows < COUNTED - 1) {
        *owed -= OWED_PER_PLACE * filled;
        filled -= of_length[++rows];
    }
    return rows;
}

static int lanes_of(const struct table *t, int b)
{
    const int rest = t->n_particles - t->width * b;
    return rest < t->width ? rest : t->width;
}

static void plan(void *context, int g)
{
    const struct dealing *d = context;
    struct table t = table_of(d, g);
    int64_t owed = 0;
    count_pairs(&t, d->list);
    for (int b = block_from(&t); b < block_to(&t); b++)
        t.planned[b] = plan_block(&t, b, lanes_of(&t, b), &owed);
}

static void place_blocks(struct table *t)
{
    t->start[0] = 0;
    for (int b = 0; b < t->n_blocks; b++)
        t->start[b + 1] = t->start[b] + t->width * (t->planned[b] + SPARE_ROWS);
}

static void open_columns(struct table *t)
{
    const int first = t->start[block_from(t)], end = t->start[block_to(t)];
    memset(t->entry + first, -1, (size_t)(end - first) * sizeof *t->entry);
    for (int q = t->from; q < t->to; q++) {
        t->column[q].room = t->planned[q / t->width];
        t->column[q].next = t->start[q / t->width] + q % t->width;
        t->column[q].seen = 0;
    }
}

static int start_of(const struct table *t, int particle)
{
    return t->start[particle / t->width] + particle % t->width;
}

static void put(struct table *t, int owner, struct entry entry)
{
    struct column *column = &t->column[owner];
    t->entry[column->next] = entry;
    column->next += t->width;
    column->room--;
}

/* One more row for the block of `owner`, who has no room; or a place beyond the table. */
static void put_beyond(struct table *t, int owner, struct entry entry)
{
    const int b = owner / t->width, lanes = lanes_of(t, b);
    if (t->start[b] + t->width * (t->planned[b] + 1) > t->start[b + 1]) {
        t->over[t->n_over++] = (struct entry){entry.pair, owner};
        return;
    }
    t->planned[b]++;
    for (int l = 0; l < lanes; l++)
        t->column[t->width * b + l].room++;
    put(t, owner, entry);
}

/* The pair at `at`, in the column of visit v, goes to its other member, that of the place that led to v comes here, and
 * so on back to one of the first two visits, where there is a place then for `pair`. */
static void pass_along(struct table *t, int v, int at, int pair)
{
    struct entry moved = t->entry[at];
    put(t, moved.other, (struct entry){moved.pair, t->visit[v].owner});
    for (; v >= 2; v = t->visit[v].from) {
        const int before = t->visit[v].place;
        t->entry[at] = (struct entry){t->entry[before].pair, t->visit[t->visit[v].from].owner};
        at = before;
    }
    t->entry[at] = (struct entry){pair, t->visit[1 - v].owner};
}

/* Both members of a pair are full: looks for the shortest chain of columns that pass pairs on, to one with room. */
static void pass_on(struct table *t, int pair, int i, int j)
{
    int n = 2;
    t->visit[0].owner = i;
    t->visit[1].owner = j;
    t->column[i].seen = t->column[j].seen = ++t->n_searches;
    for (int v = 0; v < n; v++) {
        const int owner = t->visit[v].owner, end = t->column[owner].next;
        for (int at = start_of(t, owner); at < end; at += t->width) {
            const int other = t->entry[at].other;
            if (!is_here(t, other))
                continue;
            if (t->column[other].room > 0) {
                pass_along(t, v, at, pair);
                return;
            }
            if (t->column[other].seen != t->n_searches && n < t->visits_max) {
                t->column[other].seen = t->n_searches;
                t->visit[n++] = (struct visit){other, v, at};
            }
        }
    }
    put_beyond(t, i, (struct entry){pair, j});
}

/* A pair goes to the member that has more places to fill for each pair to come. Without a branch: it could not be
 * predicted. */
static void deal_out(struct table *t, const struct contact_list *list)
{
    struct column *const columns = t->column;
    const int32_t *const i = list->i, *const j = list->j, n_pairs = t->n_pairs;
    for (int m = 0; m < t->n_across; m++) {
        const int32_t k = t->pair[m], owner = owner_of(t, list, k);
        const struct entry entry = {k, i[k] + j[k] - owner};
        columns[owner].left--;
        if (columns[owner].room > 0)
            put(t, owner, entry);
        else
            put_beyond(t, owner, entry);
    }
    for (int m = t->n_across; m < n_pairs; m++) {
        const int32_t k = t->pair[m];
        struct column *of_i = &columns[i[k]], *of_j = &columns[j[k]];
        const int32_t to_j = (int64_t)of_j->room * of_i->left > (int64_t)of_i->room * of_j->left, both = i[k] ^ j[k];
        const int32_t owner = i[k] ^ (both & -to_j);
        of_i->left--;
        of_j->left--;
        if (columns[owner].room > 0)
            put(t, owner, (struct entry){k, both ^ owner});
        else
            pass_on(t, k, i[k], j[k]);
    }
}

static uint32_t slot_of(const struct table *t, int row, int owner, int other)
{
    return 2 * (uint32_t)(row * t->width + owner % t->width) + (owner > other);
}

/* Rows of a block in the table: as many as its longest column needs. */
static int rows_filled(const struct table *t, int b)
{
    int most = 0;
    for (int l = 0; l < lanes_of(t, b); l++) {
        const int length = (t->column[t->width * b + l].next - t->start[b]) / t->width;
        most = length > most ? length : most;
    }
    return most;
}

/* The place half a row apart. */
static int twin_of(const struct table *t, int place)
{
    return place ^ (t->width / 2);
}

static bool fits(const struct table *t, int particle, int place)
{
    return particle < 0 || particle != t->entry[twin_of(t, place)].other;
}

/* The entry of `owner` and another one of its column change places, if both fit there. */
static bool change_places(struct table *t, int place, int owner)
{
    const struct entry here = t->entry[place];
    for (int k = 0; k < t->planned[owner / t->width]; k++) {
        const int to = start_of(t, owner) + t->width * k;
        const struct entry there = t->entry[to];
        if (to == place || !fits(t, here.other, to) || !fits(t, there.other, place))
            continue;
        t->entry[place] = there;
        t->entry[to] = here;
        return true;
    }
    return false;
}

/* The entry goes to an empty place of a particle's column, in rows from `first` to end - 1, as the pair of `owner` with
 * `other`. */
static bool move(struct table *t, int place, int owner, int other, int first, int end)
{
    for (int k = first; k < end; k++) {
        const int to = start_of(t, owner) + t->width * k;
        if (to >= t->start[owner / t->width + 1] || t->entry[to].pair >= 0 || !fits(t, other, to))
            continue;
        t->entry[to] = (struct entry){t->entry[place].pair, other};
        t->entry[place] = (struct entry){-1, -1};
        return true;
    }
    return false;
}

/* The same partner in a row twice, at `place` of its first half and half a row on: one of the two changes places, goes
 * to the partner, or to a row of its own. */
static void part(struct table *t, int b, int place)
{
    const int owner = t->width * b + place % t->width, twin = owner + t->width / 2, other = t->entry[place].other;
    const int rows = is_here(t, other) ? t->planned[other / t->width] : 0;
    if (change_places(t, place, owner) || move(t, place, other, owner, 0, rows) ||
        change_places(t, twin_of(t, place), twin) || move(t, twin_of(t, place), other, twin, 0, rows))
        return;
    if (move(t, place, owner, other, t->planned[b], t->planned[b] + 1)) {
        t->planned[b]++;
        return;
    }
    t->over[t->n_over++] = (struct entry){t->entry[place].pair, owner};
    t->entry[place] = (struct entry){-1, -1};
}

/* What is dealt out gets its rows, of which columns know nothing from here on. */
static void settle(struct table *t)
{
    const int half = t->width / 2;
    for (int b = block_from(t); b < block_to(t); b++)
        t->planned[b] = rows_filled(t, b);
    for (int b = block_from(t); b < block_to(t) && t->apart; b++)
        for (int k = 0; k < t->planned[b]; k++)
            for (int place = t->start[b] + t->width * k, end = place + half; place < end; place++)
                if (t->entry[place].other >= 0 && !fits(t, t->entry[place].other, place))
                    part(t, b, place);
}

/* Rows of a block: those in the table, and behind them such for what is beyond it, from row `room` of a column on. */
static int number_beyond(struct table *t, int b)
{
    const int half = t->width / 2, lanes = lanes_of(t, b);
    int rows = t->planned[b];
    for (int l = 0; l < lanes; l++) {
        struct column *column = &t->column[t->width * b + l];
        column->room = t->planned[b] + (t->apart && l >= half ? column[-half].left : 0);
        rows = column->room + column->left > rows ? column->room + column->left : rows;
    }
    return rows;
}

/* From here on `left` counts what is beyond the table, and has rows. */
static void plan_beyond(struct table *t)
{
    for (int q = t->from; q < t->to; q++)
        t->column[q].left = 0;
    for (int m = 0; m < t->n_over; m++)
        t->column[t->over[m].other].left++;
    for (int b = block_from(t); b < block_to(t); b++)
        t->planned[b] = number_beyond(t, b);
}

/* The rows that the blocks of SET_WIDTH particles side by side all have are whole sets, the others are not. */
static void number_rows(struct table *t)
{
    const int shares = SET_WIDTH / t->width;
    t->whole[0] = t->lone[0] = 0;
    for (int b = 0; b < t->n_blocks; b += shares) {
        const int last = b + shares - 1, of_last = last < t->n_blocks ? t->planned[last] : 0;
        const int least = of_last < t->planned[b] ? of_last : t->planned[b]; /* of one or two blocks */
        for (int h = b; h <= last && h < t->n_blocks; h++) {
            t->whole[h] = t->whole[b];
            t->lone[h + 1] = t->lone[h] + t->planned[h] - least;
        }
        t->whole[b + shares] = t->whole[b] + least;
    }
}

static int shares_of(const struct slot_assignment *assignment)
{
    return SET_WIDTH / assignment->width;
}

/* The first block of span s, or what would be the next one behind the last block. */
static int first_block(const struct slot_assignment *assignment, int s)
{
    const int blocks = assignment->span_width / assignment->width, shares = shares_of(assignment),
              end = (assignment->n_blocks + shares - 1) / shares * shares;
    return s * blocks < end ? s * blocks : end;
}

static int lone_before(const struct slot_assignment *assignment, int b)
{
    return assignment->lone[b < assignment->n_blocks ? b : assignment->n_blocks];
}

int slot_assignment_whole_set(const struct slot_assignment *assignment, int s)
{
    const int blocks = first_block(assignment, s + 1) - first_block(assignment, s);
    return assignment->span[s] + (assignment->chained ? blocks / shares_of(assignment) : 0);
}

int slot_assignment_halves_set(const struct slot_assignment *assignment, int s)
{
    return slot_assignment_whole_set(assignment, s) + assignment->whole[first_block(assignment, s + 1)] -
           assignment->whole[first_block(assignment, s)];
}

/* Sets of the spans. */
static void number_spans(struct table *t, const struct slot_assignment *assignment)
{
    t->span[0] = 0;
    for (int s = 0; s < assignment->n_spans; s++) {
        const int rows = lone_before(assignment, first_block(assignment, s + 1)) -
                         lone_before(assignment, first_block(assignment, s));
        t->span[s + 1] = slot_assignment_halves_set(assignment, s) + (rows * t->width + SET_WIDTH - 1) / SET_WIDTH;
    }
}

int slot_assignment_chain_row(const struct slot_assignment *assignment, int b)
{
    const int blocks = assignment->span_width / assignment->width;
    return shares_of(assignment) * assignment->span[b / blocks] + b % blocks;
}

/* How many rows of block b are in whole sets. */
static int whole_rows(const struct slot_assignment *assignment, int b)
{
    const int shares = shares_of(assignment), first = b - b % shares;
    return assignment->whole[first + shares] - assignment->whole[first];
}

int slot_assignment_rows(const struct slot_assignment *assignment, int b)
{
    return whole_rows(assignment, b) + assignment->lone[b + 1] - assignment->lone[b];
}

int slot_assignment_row(const struct slot_assignment *assignment, int b, int k)
{
    const int s = b / (assignment->span_width / assignment->width), first = first_block(assignment, s),
              shares = shares_of(assignment);
    const int n_whole = whole_rows(assignment, b);
    if (k < n_whole)
        return shares *
                   (slot_assignment_whole_set(assignment, s) + assignment->whole[b] - assignment->whole[first] + k) +
               b % shares;
    return shares * slot_assignment_halves_set(assignment, s) + assignment->lone[b] - assignment->lone[first] + k -
           n_whole;
}

static void number_block(const struct table *t, const struct slot_assignment *assignment, int b,
                         struct contact_list *list)
{
    const int lanes = lanes_of(t, b), n = slot_assignment_rows(assignment, b);
    for (int k = 0, at = t->start[b]; k < n && at < t->start[b + 1]; k++, at += t->width) {
        const int row = slot_assignment_row(assignment, b, k);
        for (int l = 0; l < lanes; l++)
            if (t->entry[at + l].pair >= 0)
                list->slot[t->entry[at + l].pair] = slot_of(t, row, t->width * b + l, t->entry[at + l].other);
    }
}

static void number_slots(void *context, int g)
{
    const struct dealing *d = context;
    const struct table table = table_of(d, g), *t = &table;
    const struct slot_assignment *assignment = d->assignment;
    struct contact_list *list = d->list;
    for (int b = block_from(t); b < block_to(t); b++)
        number_block(t, assignment, b, list);
    for (int q = t->from; q < t->to; q++)
        if (t->next[q] >= 0)
            list->slot[t->next[q]] = slot_of(t, slot_assignment_chain_row(assignment, q / t->width), q, q + 1);
    for (int m = 0; m < t->n_over; m++) {
        const int k = t->over[m].pair, owner = t->over[m].other, b = owner / t->width;
        struct column *column = &t->column[owner];
        const int place = column->room + --column->left;
        list->slot[k] = slot_of(t, slot_assignment_row(assignment, b, place), owner, list->i[k] + list->j[k] - owner);
    }
}

static void deal_out_group(void *context, int g)
{
    struct dealing *d = context;
    struct table t = table_of(d, g);
    open_columns(&t);
    deal_out(&t, d->list);
    settle(&t);
    if (t.n_over > 0)
        plan_beyond(&t);
    d->group[g].n_over = t.n_over;
}

static enum status deal_groups(struct dealing *d, struct slot_assignment *assignment)
{
    struct table *t = &d->table;
    struct thread_team *team = d->list->team;
    thread_team_run(team, d->n_groups, find_next, d);
    decide_next(d);
    thread_team_run(team, d->n_groups, sort_out, d);
    share_out_across(d);
    gather_pairs(d, (int32_t *)t->entry);
    thread_team_run(team, d->n_groups, plan, d);
    place_blocks(t);
    TRY(lay_out(t, d->list, (size_t)t->start[t->n_blocks]));
    thread_team_run(team, d->n_groups, deal_out_group, d);
    number_rows(t);
    *assignment = (struct slot_assignment){.width = t->width,
                                           .span_width = t->span_width,
                                           .n_blocks = t->n_blocks,
                                           .n_spans = n_spans(t),
                                           .chained = t->chained,
                                           .whole = t->whole,
                                           .lone = t->lone,
                                           .span = t->span};
    number_spans(t, assignment);
    d->assignment = assignment;
    thread_team_run(team, d->n_groups, number_slots, d);
    d->list->n_sets = t->span[assignment->n_spans];
    return STATUS_OK;
}

enum status slot_assignment_make(struct contact_list *list, int n_particles, int width, int span_width,
                                 struct slot_assignment *assignment)
{
    struct dealing d = {.list = list};
    d.table = (struct table){.n_particles = n_particles,
                             .n_blocks = (n_particles + width - 1) / width,
                             .width = width,
                             .span_width = span_width,
                             .apart = list->model.mixed && width == HALF_WIDTH};
    d.table.visits_max = list->search_max > 0 && list->search_max < VISITS_MAX ? list->search_max : VISITS_MAX;
    TRY(lay_out(&d.table, list, 0));
    TRY(make_groups(&d));
    const enum status status = deal_groups(&d, assignment);
    free(d.group);
    return status;
}
