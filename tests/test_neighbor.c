/* Lists of neighbours against a search of all pairs, for every instruction set: random samples of any spread of sizes,
 * histories, the skin that tunes itself, and renumbering. */
#include "sim_fixture.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim/base/random.h"
#include "sim/grains/particle_order.h"
#include "sim/measure/measure.h"
#include "sim/neighbours/locality_order.h"
#include "sim/sample/step_completion.h"
#include "sim/sample/time_step.h"

static const char friction[] =
    "law = \"hysteretic\"; k1_n_per_m = 8e4; k2_n_per_m = 1e5; kc_n_per_m = 2e4; mu_s = 0.3; "
    "kt_n_per_m = 2e4; gamma_n_kg_per_s = 0.05; gamma_t_kg_per_s = 0.01;";

/* Particles with radii between 1 mm/ratio and 1 mm, spread evenly over the logarithm, anywhere in a box that they would
 * fill to a part `filled`. */
static struct fixture scatter(int dimension, int count, double ratio, double filled, int seed, const char *more)
{
    const struct fixture_options options = {dimension, count, 1e-7, friction, more};
    struct fixture f = fixture_open(&options);
    struct sample *sample = f.sample;
    struct particles *p = &sample->particles;
    struct random random;
    random_init(&random, (uint64_t)seed);
    for (int i = 0; i < count; i++)
        p->radius[i] = 1e-3 * pow(ratio, -random_uniform(&random));
    double side = pow(particles_solid_volume(p) / filled, 1.0 / dimension);
    for (int c = 0; c < dimension; c++) {
        sample->walls[2 * c].x = 0;
        sample->walls[2 * c + 1].x = side;
        for (int i = 0; i < count; i++)
            p->x[c][i] = side * random_uniform(&random);
    }
    return f;
}

static void build(struct sample *sample)
{
    must(sample_build_lists(sample));
}

static double distance(const struct particles *p, int i, int j)
{
    double d2 = 0;
    for (int c = 0; c < p->dimension; c++)
        d2 += (p->x[c][i] - p->x[c][j]) * (p->x[c][i] - p->x[c][j]);
    return sqrt(d2);
}

/* The lists hold what is closer than the skin, in order. The search works in single precision relative to a cell: it
 * may add what is up to three parts in a million of the largest cell farther. Returns the number of pairs. */
static int check_against_all(const struct sample *sample)
{
    const struct particles *p = &sample->particles;
    const struct contact_list *pairs = &sample->pairs;
    double margin = 0, skin = sample->verlet.skin;
    int at = 0;
    for (int c = 0; c < p->dimension; c++)
        margin = fmax(margin, 3e-6 * sample_box_length_m(sample, c));
    for (int i = 0; i < p->count; i++)
        for (int j = i + 1; j < p->count; j++) {
            double gap = distance(p, i, j) - p->radius[i] - p->radius[j];
            bool listed = at < pairs->count && pairs->i[at] == i && pairs->j[at] == j;
            assert_true(listed || !(gap < skin));
            assert_true(!listed || gap < skin + margin);
            assert_true(!listed || pairs->reach[at] == p->radius[i] + p->radius[j]);
            at += listed;
        }
    assert_int_equal(at, pairs->count); /* rising by (i, j), none twice */
    for (int w = 0; w < sample->n_walls; w++) {
        const struct wall *wall = &sample->walls[w];
        int k = 0;
        for (int i = 0; i < p->count; i++) {
            bool near = wall->inward * (p->x[wall->axis][i] - wall->x) - p->radius[i] < skin;
            assert_true(!near || (k < wall->contacts.count && wall->contacts.i[k] == i));
            k += near;
        }
        assert_int_equal(k, wall->contacts.count);
    }
    return at;
}

static void check_scatter(int dimension, int count, double ratio, double filled, double skin)
{
    struct fixture f = scatter(dimension, count, ratio, filled, count + dimension, "");
    struct sample *sample = f.sample;
    sample->verlet.skin = skin * 1e-3 / ratio;
    int pairs = -1;
    for (int isa = 0; isa < ISA_COUNT; isa++) {
        if (!instruction_set_supported(isa)) {
            print_message("kernels %s skipped: this CPU cannot run them\n", instruction_set_name(isa));
            continue;
        }
        sample->verlet.search = search_select(isa);
        build(sample);
        int found = check_against_all(sample);
        assert_true(pairs < 0 || pairs == found);
        pairs = found;
    }
    assert_true(count < 100 || filled < 0.1 || pairs > 0);
    fixture_close(&f);
}

static void lists_are_those_of_all_pairs(void **state)
{
    static const int count[] = {1, 2, 3, 16, 17, 130, 700};
    static const double ratio[] = {1, 3, 10, 100}, filled[] = {0.01, 0.5, 3}, skin[] = {0.1, 3};
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++)
        for (int n = 0; n < 7; n++)
            for (int r = 0; r < 4; r++)
                for (int k = 0; k < 6; k++)
                    check_scatter(dimension, count[n], ratio[r], filled[k / 2], skin[k % 2]);
}

/* All in one place, on a line, and one far away: grids of one cell, of one row, and mostly empty. */
static void odd_places_are_found_too(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++)
        for (int odd = 0; odd < 3; odd++) {
            struct fixture f = scatter(dimension, 50, 10, 0.5, 3, "");
            struct particles *p = &f.sample->particles;
            for (int i = 0; i < p->count; i++)
                for (int c = 0; c < dimension; c++)
                    p->x[c][i] = odd == 0            ? 1e-3
                                 : odd == 1 && c > 0 ? 2e-3
                                                     : p->x[c][i] * (odd == 2 && i == 0 ? 1e5 : 1);
            build(f.sample);
            const struct contact_list *pairs = &f.sample->pairs;
            assert_true(odd > 0 || pairs->count == 50 * 49 / 2);
            int at = 0;
            for (int i = 0; i < p->count; i++)
                for (int j = i + 1; j < p->count; j++) {
                    double gap = distance(p, i, j) - p->radius[i] - p->radius[j];
                    bool listed = at < pairs->count && pairs->i[at] == i && pairs->j[at] == j;
                    assert_true(listed || !(gap < f.sample->verlet.skin));
                    at += listed;
                }
            assert_int_equal(at, pairs->count);
            fixture_close(&f);
        }
}

/* ---- histories ---- */

/* A number of its own for each pair and array. */
static double mark(int i, int j, int array)
{
    return 1 + i + 1000.0 * j + 1e7 * array;
}

static double *array_of(const struct contact_list *list, int array)
{
    static const int columns[] = {HISTORY_MAX_OVERLAP, HISTORY_SLIDING, HISTORY_SPRING, HISTORY_SPRING + 1,
                                  HISTORY_SPRING + 2};
    return list->history[columns[array]];
}

static void mark_list(struct contact_list *list, const struct particles *p, const struct wall *wall)
{
    contact_list_read(list);
    for (int a = 0; a < 2 + contact_model_springs(&list->model); a++)
        for (int k = 0; k < list->count; k++)
            array_of(list, a)[k] = a == 1 ? k % 2 : mark(list->i[k], list->j[k], a);
    must(contact_list_close(list, p, wall));
}

static bool was_listed(const struct contact_list *list, int i, int j)
{
    for (int k = 0; k < list->count; k++)
        if (list->i[k] == i && list->j[k] == j)
            return true;
    return false;
}

static void copy_pairs(struct contact_list *to, const struct contact_list *from)
{
    *to = (struct contact_list){.count = from->count};
    to->i = malloc(((size_t)from->count + 1) * sizeof *to->i);
    to->j = malloc(((size_t)from->count + 1) * sizeof *to->j);
    assert_true(to->i && to->j);
    memcpy(to->i, from->i, (size_t)from->count * sizeof *to->i);
    memcpy(to->j, from->j, (size_t)from->count * sizeof *to->j);
}

/* Returns 1 for a history that was kept, 0 for a new candidate's. */
static int check_marks(struct contact_list *list, const struct contact_list *before, int *fresh)
{
    int kept = 0;
    contact_list_read(list);
    for (int k = 0; k < list->count; k++) {
        bool known = was_listed(before, list->i[k], list->j[k]);
        for (int a = 0; a < 2 + contact_model_springs(&list->model); a++)
            if (a != 1)
                assert_true(array_of(list, a)[k] == (known ? mark(list->i[k], list->j[k], a) : 0));
        kept += known;
        *fresh += !known;
    }
    return kept;
}

static void histories_are_carried_exactly(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++)
        for (int isa = 0; isa < ISA_COUNT; isa++) {
            if (!instruction_set_supported(isa))
                continue;
            struct fixture f = scatter(dimension, 300, 3, 1, 5, "");
            struct sample *sample = f.sample;
            struct particles *p = &sample->particles;
            struct contact_list before, wall_before;
            struct random random;
            int kept = 0, fresh = 0;
            sample->verlet.search = search_select(isa);
            random_init(&random, 9);
            build(sample);
            mark_list(&sample->pairs, p, NULL);
            mark_list(&sample->walls[1].contacts, p, &sample->walls[1]);
            copy_pairs(&before, &sample->pairs);
            copy_pairs(&wall_before, &sample->walls[1].contacts);
            for (int c = 0; c < dimension; c++)
                for (int i = 0; i < p->count; i++)
                    p->x[c][i] += 3e-4 * (random_uniform(&random) - 0.5);
            build(sample);
            kept += check_marks(&sample->pairs, &before, &fresh);
            assert_true(kept > 100 && fresh > 20);
            check_marks(&sample->walls[1].contacts, &wall_before, &fresh);
            free(before.i);
            free(before.j);
            free(wall_before.i);
            free(wall_before.j);
            fixture_close(&f);
        }
}

/* ---- a gas whose particles mix ---- */

static struct fixture gas_of(int count, int dimension, const char *more)
{
    char text[1024];
    snprintf(
        text, sizeof text,
        "dimension = %d;\nsample = { count = %d; radius_min_m = 0.2e-3; radius_max_m = 1.5e-3; density_kg_per_m3 = "
        "2000.0; speed_m_per_s = 2.0; gap_ratio = 0.02; };\nmaterial = { %s };\n%s\n"
        "stages = ( { name = \"a\"; dt_s = 5e-7; duration_s = 1.0; } );\n",
        dimension, count, friction, more);
    struct fixture f = fixture_from_text(text);
    fixture_start(&f);
    return f;
}

static struct fixture gas(int dimension, const char *more)
{
    return gas_of(120, dimension, more);
}

/* The lanes behind the last particle are empty, and do not fall: they would be far from where they were listed, and
 * lists built at every step. */
static void gravity_builds_no_lists(void **state)
{
    (void)state;
    for (int count = 116; count <= 120; count += 4)
        for (int single = 0; single < 2; single++) {
            struct fixture f = gas_of(count, 2, single ? "precision = \"mixed\";" : "");
            f.sample->gravity[1] = -1000;
            fixture_steps(&f, 4000);
            assert_true(f.sample->verlet.rebuilds < 400);
            fixture_close(&f);
        }
}

/* Lists built at different times, the same motion but for rounding, which collisions let grow; and fewer builds than
 * with the narrowest skin. */
static void the_tuned_skin_changes_nothing(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        struct fixture fixed = gas(dimension, "neighbor = { skin_ratio = 0.02; };"), tuned = gas(dimension, "");
        double first = tuned.sample->verlet.skin;
        fixture_steps(&fixed, 8000);
        fixture_steps(&tuned, 8000);
        double worst = 0;
        for (int c = 0; c < dimension; c++)
            for (int i = 0; i < 120; i++)
                worst = fmax(worst, fabs(fixed.sample->particles.x[c][i] - tuned.sample->particles.x[c][i]));
        print_message("%dD: positions differ by %.2g m\n", dimension, worst);
        assert_true(worst < 1e-12);
        assert_true(tuned.sample->verlet.rebuilds < fixed.sample->verlet.rebuilds / 2);
        assert_true(tuned.sample->verlet.skin > first);
        fixture_close(&fixed);
        fixture_close(&tuned);
    }
}

/* A sample that has come to rest needs no skin: the lists are built again without much of it. */
static void the_tuned_skin_narrows_at_rest(void **state)
{
    (void)state;
    struct fixture f = scatter(2, 100, 2, 0.1, 4, "");
    fixture_start(&f);
    double wide = f.sample->verlet.skin = 1e-3;
    build(f.sample);
    for (int c = 0; c < 2; c++)
        memset(f.sample->particles.v[c], 0, 100 * sizeof(double));
    f.sample->material = &f.scene->stage[0].material;
    memset(f.sample->law.normal, 0, sizeof f.sample->law.normal); /* what overlaps stays */
    memset(f.sample->wall_law, 0, sizeof f.sample->wall_law);
    for (int c = 0; c < 2; c++)
        memset(f.sample->particles.a[c], 0, 100 * sizeof(double));
    fixture_steps(&f, 600);
    assert_true(f.sample->verlet.skin < 0.2 * wide);
    fixture_close(&f);
}

/* ---- renumbering ---- */

static struct contact_measurement *contacts_of(struct sample *sample, int *n)
{
    *n = measure_contacts(sample_complete(sample), NULL);
    struct contact_measurement *contacts = calloc((size_t)*n + 1, sizeof *contacts);
    assert_non_null(contacts);
    assert_int_equal(measure_contacts(sample_complete(sample), contacts), *n);
    return contacts;
}

static void assert_same_contacts(const struct contact_measurement *a, const struct contact_measurement *b, int n)
{
    for (int k = 0; k < n; k++) {
        assert_int_equal(a[k].i, b[k].i);
        assert_int_equal(a[k].j, b[k].j);
        assert_true(a[k].overlap_m == b[k].overlap_m && a[k].normal_force_n == b[k].normal_force_n);
        assert_true(a[k].sliding == b[k].sliding);
        for (int c = 0; c < 3; c++)
            assert_true(a[k].normal[c] == b[k].normal[c] && a[k].tangential_force_n[c] == b[k].tangential_force_n[c]);
    }
}

/* Neither a bit of the state nor of a contact changes, in the order of ids; only where things are. */
static void renumbering_only_moves(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        struct fixture f = scatter(dimension, 200, 2, 0.7, 6, "neighbor = { renumber_steps = 0; };");
        struct sample *sample = f.sample;
        int n, m, moved = 0;
        fixture_start(&f);
        fixture_steps(&f, 200); /* springs and histories of many contacts */
        uint64_t hash = sample_hash(sample_complete(sample));
        struct contact_measurement *before = contacts_of(sample, &n);
        assert_true(n > 100);
        must(locality_order_apply(&sample->particles, &sample->pairs, sample->walls, sample->n_walls));
        build(sample);
        assert_true(sample_hash(sample_complete(sample)) == hash);
        struct contact_measurement *after = contacts_of(sample, &m);
        assert_int_equal(n, m);
        assert_same_contacts(before, after, n);
        for (int i = 0; i < sample->particles.count; i++) {
            assert_int_equal(sample->particles.id[sample->particles.slot[i]], i);
            moved += sample->particles.id[i] != i;
        }
        assert_true(moved > sample->particles.count / 2);
        check_against_all(sample);
        free(before);
        free(after);
        fixture_close(&f);
    }
}

/* Forces are summed in another order, so a step differs by rounding, and collisions amplify that: over 200 steps with
 * renumbering at every 10th, at most by 1e-9 of the distance travelled at 2 m/s. */
static void renumbering_keeps_the_physics(void **state)
{
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        struct fixture plain = gas(dimension, "neighbor = { renumber_steps = 0; };");
        struct fixture mixed = gas(dimension, "neighbor = { renumber_steps = 10; };");
        const struct particles *a = &plain.sample->particles, *b = &mixed.sample->particles;
        fixture_steps(&plain, 200);
        fixture_steps(&mixed, 200);
        for (int i = 0; i < a->count; i++) {
            assert_true(a->radius[i] == b->radius[b->slot[i]] && a->mass[i] == b->mass[b->slot[i]]);
            for (int c = 0; c < dimension; c++)
                assert_close("position", b->x[c][b->slot[i]], a->x[c][i], 1e-9 * 2.0 * 200 * 5e-7);
        }
        assert_true(mixed.sample->verlet.rebuilds >= 20);
        fixture_close(&plain);
        fixture_close(&mixed);
    }
}

/* By its id, wherever it is kept. */
static void a_particle_that_left_is_named(void **state)
{
    (void)state;
    struct fixture f = scatter(2, 200, 2, 0.7, 6, "neighbor = { renumber_steps = 0; };");
    struct particles *p = &f.sample->particles;
    char name[64];
    fixture_start(&f);
    must(locality_order_apply(p, &f.sample->pairs, f.sample->walls, f.sample->n_walls));
    build(f.sample);
    int slot = 0;
    while (p->id[slot] == slot)
        slot++;
    p->x[0][slot] = f.sample->walls[1].x + 1;
    assert_int_equal(sample_step(f.sample), STATUS_UNSTABLE);
    snprintf(name, sizeof name, "particle %d left the box in x", p->id[slot]);
    assert_non_null(strstr(status_message(), name));
    fixture_close(&f);
}

/* Neighbours in space become neighbours in memory. */
static void renumbering_brings_neighbours_together(void **state)
{
    (void)state;
    struct fixture f = scatter(2, 2000, 1, 0.8, 8, "");
    double apart[2];
    for (int k = 0; k < 2; k++) {
        build(f.sample);
        const struct contact_list *pairs = &f.sample->pairs;
        apart[k] = 0;
        for (int m = 0; m < pairs->count; m++)
            apart[k] += (double)(pairs->j[m] - pairs->i[m]) / pairs->count;
        must(locality_order_apply(&f.sample->particles, &f.sample->pairs, f.sample->walls, f.sample->n_walls));
    }
    assert_close("mean distance at random", apart[0], 2000 / 3.0, 60); /* of 3000 pairs: 5 standard errors */
    assert_true(apart[1] < 2 * sqrt(2000));                            /* about a row of cells */
    fixture_close(&f);
}

/* As many partners as in a packing, 4 to 6: nearly all particles have one right behind them, large samples too, where
 * paths stay within a stretch. */
static void paths_lead_from_partner_to_partner(void **state)
{
    static const struct {
        int dimension, count;
        double filled;
    } samples[] = {{2, 2000, 1.3}, {3, 2000, 0.8}, {2, 20000, 1.3}};
    (void)state;
    for (int k = 0; k < 3; k++) {
        const int count = samples[k].count;
        struct fixture f = scatter(samples[k].dimension, count, 1, samples[k].filled, 8, "");
        const struct contact_list *pairs = &f.sample->pairs;
        int next = 0;
        build(f.sample);
        must(locality_order_apply(&f.sample->particles, &f.sample->pairs, f.sample->walls, f.sample->n_walls));
        build(f.sample);
        for (int m = 0; m < pairs->count; m++)
            next += pairs->j[m] == pairs->i[m] + 1;
        print_message("%dD, %.1f partners: %.3f\n", samples[k].dimension, 2.0 * pairs->count / count,
                      (double)next / count);
        assert_true(next > 0.9 * count);
        fixture_close(&f);
    }
}

static void ids_that_are_none_are_refused(void **state)
{
    (void)state;
    struct fixture f = scatter(2, 10, 1, 0.1, 8, "");
    f.sample->particles.id[3] = 4;
    assert_int_equal(particles_set_slots(&f.sample->particles), STATUS_FORMAT);
    f.sample->particles.id[3] = 10;
    assert_int_equal(particles_set_slots(&f.sample->particles), STATUS_FORMAT);
    f.sample->particles.id[3] = 3;
    must(particles_set_slots(&f.sample->particles));
    fixture_close(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lists_are_those_of_all_pairs),       cmocka_unit_test(odd_places_are_found_too),
        cmocka_unit_test(histories_are_carried_exactly),      cmocka_unit_test(the_tuned_skin_changes_nothing),
        cmocka_unit_test(the_tuned_skin_narrows_at_rest),     cmocka_unit_test(renumbering_only_moves),
        cmocka_unit_test(renumbering_keeps_the_physics),      cmocka_unit_test(renumbering_brings_neighbours_together),
        cmocka_unit_test(paths_lead_from_partner_to_partner), cmocka_unit_test(a_particle_that_left_is_named),
        cmocka_unit_test(ids_that_are_none_are_refused),      cmocka_unit_test(gravity_builds_no_lists),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
