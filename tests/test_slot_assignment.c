/* Who gets the pairs of a list: each pair one slot of its own in the column of one of its members, sets block by block,
 * hardly a slot empty in a packing, and lists that no table is laid out for. */
#include "sim_fixture.h"

#include <stdlib.h>
#include <string.h>

#include "sim/base/random.h"
#include "sim/contacts/slot_assignment.h"

static struct contact_list list_of(int capacity)
{
    struct contact_list list = {.count = 0};
    must(contact_list_reserve(&list, capacity + 1, 2));
    return list;
}

static void add(struct contact_list *list, int a, int b)
{
    list->i[list->count] = a < b ? a : b;
    list->j[list->count++] = a < b ? b : a;
}

static int owner_of(const struct contact_list *list, int k)
{
    return list->slot[k] % 2 ? list->j[k] : list->i[k];
}

/* Row r is one of block b, but not that of neighbours in the order. */
static bool is_row_of(const struct slot_assignment *assignment, int b, int r)
{
    for (int k = 0; k < slot_assignment_rows(assignment, b); k++)
        if (slot_assignment_row(assignment, b, k) == r)
            return true;
    return false;
}

/* Rows of whole sets belong to blocks that share SET_WIDTH particles side by side, each row in its place. */
static void check_whole(const struct slot_assignment *assignment, int b, int row)
{
    const int shares = SET_WIDTH / assignment->width, s = assignment->width * b / SPAN_WIDTH, set = row / shares;
    assert_in_range(set, slot_assignment_whole_set(assignment, s), assignment->span[s + 1] - 1);
    if (set >= slot_assignment_halves_set(assignment, s))
        return;
    assert_int_equal(row % shares, b % shares);
    for (int h = 0; h < shares; h++)
        assert_true(is_row_of(assignment, b - b % shares + h, set * shares + h));
}

/* Places half a row apart have not the same partner, for kernels add to the sums of both at once. */
static void check_apart(const struct contact_list *list)
{
    const size_t slots = (size_t)list->n_sets * SET_WIDTH;
    int *partner = malloc((slots + 1) * sizeof *partner);
    assert_true(partner);
    for (size_t s = 0; s < slots; s++)
        partner[s] = -1;
    for (int k = 0; k < list->count; k++)
        partner[list->slot[k] / 2] = list->i[k] + list->j[k] - owner_of(list, k);
    for (size_t s = 0; s < slots; s++)
        assert_true(partner[s] < 0 || partner[s] != partner[s ^ (HALF_WIDTH / 2)]);
    free(partner);
}

/* Deals the list out, checks the slots and returns the number of rows but those of neighbours in the order;
 * *others: pairs in them, may be NULL. */
static int check_assignment(struct contact_list *list, int n_particles, int width, int *others)
{
    struct slot_assignment assignment;
    must(slot_assignment_make(list, n_particles, width, SPAN_WIDTH, &assignment));
    assert_int_equal(assignment.n_blocks, (n_particles + width - 1) / width);
    assert_int_equal(assignment.n_spans, (n_particles + SPAN_WIDTH - 1) / SPAN_WIDTH);
    assert_int_equal(assignment.span[assignment.n_spans], list->n_sets);
    int rows = 0, n_others = 0;
    bool *taken = calloc((size_t)list->n_sets * SET_WIDTH + 1, sizeof *taken),
         *used = calloc(2 * (size_t)list->n_sets + 1, 1);
    assert_true(taken && used);
    for (int k = 0; k < list->count; k++) {
        const int slot = (int)(list->slot[k] / 2), row = slot / width, owner = owner_of(list, k);
        const int b = owner / width, s = owner / SPAN_WIDTH;
        assert_in_range(slot / SET_WIDTH, assignment.span[s], assignment.span[s + 1] - 1);
        if (!assignment.chained || row != slot_assignment_chain_row(&assignment, b)) {
            assert_true(is_row_of(&assignment, b, row));
            n_others++;
        } else {
            assert_true(owner == list->i[k] && list->j[k] == owner + 1);
        }
        assert_int_equal(slot % width, owner % width);
        assert_false(taken[slot]);
        taken[slot] = used[row] = true;
    }
    for (int b = 0; b < assignment.n_blocks;
         b++) /* none is empty but of neighbours in the order, none has two blocks */
        for (int k = 0; k < slot_assignment_rows(&assignment, b); k++, rows++) {
            const int row = slot_assignment_row(&assignment, b, k);
            check_whole(&assignment, b, row);
            assert_true(used[row]);
            used[row] = false;
        }
    const int all = rows + (assignment.chained ? assignment.n_blocks : 0), most = all + 2 * assignment.n_spans;
    assert_in_range(SET_WIDTH * list->n_sets, width * all, width * most);
    free(taken);
    free(used);
    if (list->model.mixed && width == HALF_WIDTH)
        check_apart(list);
    if (others)
        *others = n_others;
    return rows;
}

/* Again, with other working memory: the same slots. */
static void check_repeats(const struct contact_list *list, int n_particles, int width)
{
    struct contact_list again = list_of(list->count);
    struct slot_assignment assignment;
    for (int k = 0; k < list->count; k++)
        add(&again, list->i[k], list->j[k]);
    again.search_max = list->search_max;
    again.model.mixed = list->model.mixed;
    for (int round = 0; round < 2; round++) {
        must(slot_assignment_make(&again, n_particles, width, SPAN_WIDTH, &assignment));
        assert_memory_equal(again.slot, list->slot, (size_t)list->count * sizeof *list->slot);
    }
    contact_list_free(&again);
}

/* A triangular lattice without a third of its pairs, two a particle; the partner in the row is `near` places on. */
static struct contact_list lattice(int side, int near)
{
    struct contact_list list = list_of(3 * side * side);
    struct random random;
    random_init(&random, 5);
    for (int i = 0; i < side * side; i++) {
        const int to[] = {i + near, i + side, i + side + 1};
        for (int n = 0; n < 3; n++)
            if (to[n] < side * side && (n == 1 || i % side + near < side) && 3 * random_uniform(&random) < 2)
                add(&list, i, to[n]);
    }
    return list;
}

/* The longer the searches, the fuller; the shortest asks the partners of the two members only. */
static void a_lattice_fills_its_sets(void **state)
{
    static const int visits[] = {1, 12, 0};
    static const double filled[] = {0.85, 0.9, 0.94};
    (void)state;
    for (int n = 0; n < 3; n++) {
        struct contact_list list = lattice(64, 2);
        list.search_max = visits[n];
        int others, rows = check_assignment(&list, 64 * 64, SET_WIDTH, &others);
        double part = (double)others / (rows * SET_WIDTH);
        print_message("%d visits: %.3f filled\n", visits[n], part);
        assert_true(part > filled[n] && part <= 1);
        check_repeats(&list, 64 * 64, SET_WIDTH);
        contact_list_free(&list);
    }
}

/* Where most particles have a partner right behind them, but for the last of a span of blocks, these pairs have sets of
 * their own; the others, 1.3 a particle, have to do with fewer sets, and fill them less well. */
static void neighbours_in_the_order_have_their_sets(void **state)
{
    enum { SIDE = 64, N = SIDE * SIDE };
    (void)state;
    struct contact_list list = lattice(SIDE, 1);
    int next = 0, others, rows = check_assignment(&list, N, SET_WIDTH, &others);
    for (int k = 0; k < list.count; k++)
        next += list.j[k] == list.i[k] + 1 && list.j[k] % SPAN_WIDTH != 0;
    assert_true(next > 0.6 * N);
    assert_int_equal(others, list.count - next);
    print_message("others: %.3f filled\n", (double)others / (rows * SET_WIDTH));
    assert_true(others > 0.75 * rows * SET_WIDTH);
    check_repeats(&list, N, SET_WIDTH);
    contact_list_free(&list);
}

/* Random graphs of any density, with particles that have no pair, and pairs that are there twice. */
static void every_pair_has_one_slot(void **state)
{
    static const int count[] = {2, 3, 15, 16, 17, 33, 200};
    (void)state;
    struct random random;
    random_init(&random, 3);
    for (int c = 0; c < 7; c++)
        for (int pairs = 1; pairs <= 4096; pairs *= 4) {
            struct contact_list list = list_of(pairs);
            for (int k = 0; k < pairs; k++) {
                int a = (int)(random_uniform(&random) * count[c]), b = (int)(random_uniform(&random) * (count[c] - 1));
                add(&list, a, b + (b >= a));
            }
            list.search_max = pairs % 3 ? 12 : 0;
            list.model.mixed = c % 2;
            check_assignment(&list, count[c], pairs % 5 < 3 ? HALF_WIDTH : SET_WIDTH, NULL);
            check_repeats(&list, count[c], pairs % 5 < 3 ? HALF_WIDTH : SET_WIDTH);
            contact_list_free(&list);
        }
}

/* One particle in all pairs, and all with all: far more than is planned for a block. */
static void crowded_blocks_get_their_sets(void **state)
{
    enum { STAR = 3000, CROWD = 200 };
    (void)state;
    struct contact_list star = list_of(STAR), crowd = list_of(CROWD * CROWD / 2);
    for (int k = 1; k <= STAR; k++)
        add(&star, 0, k);
    int rows = check_assignment(&star, STAR + 1, SET_WIDTH, NULL);
    assert_true(rows <= (STAR + SET_WIDTH) / SET_WIDTH); /* one for each block: the others have them */
    for (int a = 0; a < CROWD; a++)
        for (int b = 0; b < a; b++)
            add(&crowd, b, a);
    int others;
    rows = check_assignment(&crowd, CROWD, SET_WIDTH, &others);
    assert_int_equal(others, crowd.count - (CROWD - 1)); /* each has the next one as a partner */
    assert_true(others > 0.8 * rows * SET_WIDTH);
    check_repeats(&crowd, CROWD, SET_WIDTH);
    star.model.mixed = crowd.model.mixed = true;
    check_assignment(&star, STAR + 1, HALF_WIDTH, NULL);
    check_assignment(&crowd, CROWD, HALF_WIDTH, NULL);
    contact_list_free(&star);
    contact_list_free(&crowd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lattice_fills_its_sets),
        cmocka_unit_test(neighbours_in_the_order_have_their_sets),
        cmocka_unit_test(every_pair_has_one_slot),
        cmocka_unit_test(crowded_blocks_get_their_sets),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
