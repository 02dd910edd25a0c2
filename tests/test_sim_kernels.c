/* Every kernel of every instruction set that this CPU runs against the reference, bit for bit, on inputs biased to all
 * branches; the sums of losses to rounding; and nothing written behind the arrays. */
#include "sim_fixture.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim/base/aligned_array.h"
#include "sim/base/random.h"
#include "sim/kernels/kernels.h"
#include "sim/law/normal_elastoplastic.h"
#include "sim/law/normal_hysteretic.h"

enum { WIDEST = SET_WIDTH, CONTACTS_MAX = 2 * WIDEST + 1, REPEATS = 3 };

struct model {
    int dimension, law, frictional, mixed; /* law: enum contact_law; frictional 2: rolling, too, 3: and torsion */
};

/* All that kernels read and write. */
struct bench {
    struct particles p;
    struct contact_list pairs;
    struct wall wall;
    struct contact_law_constants law;
    double dt;
    struct contact_losses losses;
};

static const double canary = -7.25e77;

static int whole_vectors(int count)
{
    return (count + WIDEST - 1) / WIDEST * WIDEST;
}

static double between(struct random *random, double lo, double hi)
{
    return lo + (hi - lo) * random_uniform(random);
}

static int one_of(struct random *random, int n)
{
    return (int)(n * random_uniform(random));
}

static double choose(struct random *random, const double *list, int n)
{
    return list[one_of(random, n)];
}
#define CHOOSE(random, ...)                                                                                            \
    choose(random, (const double[]){__VA_ARGS__}, (int)(sizeof((double[]){__VA_ARGS__}) / sizeof(double)))

static struct contact_model contact_model(struct model model)
{
    struct contact_model contacts = contact_model_make(model.dimension, model.law, model.frictional > 0, model.mixed);
    contacts.rolling = model.frictional >= 2;
    contacts.torsion = model.frictional == 3;
    return contacts;
}

/* kc = 0, k1 = k2, mu = 0 and above 1, kt = 0 (a stage without friction in a scene with it), dt = 0 (forces anew). */
static struct contact_law_constants random_law(struct random *random, struct model model)
{
    double k2 = 1e5, mu = CHOOSE(random, 0, 0.3, 0.3, 1.5);
    struct scene_material m = {
        .law = model.law,
        .kn_n_per_m = k2,
        .kp_n_per_m = k2,
        .phi_f = 0.05,
        .youngs_modulus_pa = 1e8,
        .poisson_ratio = 0.25,
        .restitution = mu > 0.3 ? 0.9 : 0.3,
        .k1_n_per_m = k2 * CHOOSE(random, 0.1, 0.5, 1),
        .k2_n_per_m = k2,
        .kc_n_per_m = k2 * CHOOSE(random, 0, 0.5, 4),
        .gamma_n_kg_per_s = CHOOSE(random, 0, 0.1),
        .mu_s = mu,
        .mu_d = mu * CHOOSE(random, 0.5, 1),
        .kt_n_per_m = CHOOSE(random, 0, 2e4, 2e4),
        .gamma_t_kg_per_s = CHOOSE(random, 0, 0.05),
    };
    if (model.frictional >= 2) {
        m.mu_rolling = CHOOSE(random, 0, 0.1, 0.1, 1);
        m.kr_n_per_m = 1e4;
        m.gamma_r_kg_per_s = CHOOSE(random, 0, 0.02);
        m.mu_torsion = model.frictional == 3 ? CHOOSE(random, 0, 0.05, 1) : 0;
        m.ko_n_per_m = 2e4;
        m.gamma_o_kg_per_s = CHOOSE(random, 0, 0.02);
    }
    return contact_law_constants_of(&m, contact_model(model).normal);
}

static void random_particles(struct particles *p, int count, struct model model, struct random *random)
{
    must(particles_init(p, count, model.dimension, model.frictional, model.mixed));
    double speed = CHOOSE(random, 0, 0.1, 1), moved = CHOOSE(random, 0, 2e-5); /* since the lists were built */
    for (int i = 0; i < count; i++) {
        p->radius[i] = between(random, 0.5e-3, 1.5e-3);
        for (int c = 0; c < model.dimension; c++) {
            p->x_list[c][i] = 1e-3 * i * (c == 0) + between(random, 0, 5e-4);
            p->x[c][i] = p->x_list[c][i] + between(random, -moved, moved);
            p->v[c][i] = between(random, -speed, speed);
            p->a[c][i] = between(random, -100, 100);
        }
        for (int c = 0; c < p->n_rotations; c++) {
            p->omega[c][i] = between(random, -1e3 * speed, 1e3 * speed);
            p->alpha[c][i] = between(random, -100, 100);
        }
    }
    particles_set_mass(p, 2000);
    particles_set_views(p, 1e-4);
    particles_import_state(p);
}

/* Open, exactly or barely touching, small, common and large overlaps [m]. */
static double random_overlap(struct random *random)
{
    return CHOOSE(random, -1e-4, -1e-18, 0, 1e-18, 1e-9, 1e-6, 1e-5, 1e-5, 1e-4) * CHOOSE(random, 1, 1, 0.7);
}

/* History for each branch: none, as loaded, unloading, below delta_0, deep on the adhesion branch, on its edge. */
static double random_history(const struct contact_law_constants *law, int normal, double overlap, struct random *random)
{
    const double ratio = law->normal[normal == LAW_ELASTOPLASTIC ? ELASTOPLASTIC_BRANCH : HYSTERETIC_BRANCH_RATIO];
    double d = fabs(overlap);
    return CHOOSE(random, 0, d, 1.1 * d, 2 * d, 10 * d, ratio * d, 1e-5);
}

static void random_state(struct contact_list *list, int k, const struct contact_law_constants *law, double overlap,
                         struct random *random)
{
    double size = CHOOSE(random, 0, 1e-9, 1e-7, 1e-5, 1e-3); /* from none over sticking to sliding */
    if (history_has(&list->model, HISTORY_MAX_OVERLAP))
        list->history[HISTORY_MAX_OVERLAP][k] = random_history(law, list->model.normal, overlap, random);
    if (list->model.frictional)
        list->history[HISTORY_SLIDING][k] = one_of(random, 2);
    for (int c = 0; c < contact_model_springs(&list->model); c++)
        if (list->model.traits & NORMAL_MINDLIN)
            list->history[HISTORY_FORCE + c][k] = 1e4 * between(random, -size, size);
        else
            list->history[HISTORY_SPRING + c][k] = between(random, -size, size);
    for (int c = 0; list->model.rolling && c < contact_model_springs(&list->model); c++)
        list->history[HISTORY_ROLLING + c][k] = between(random, -size, size);
    if (history_has(&list->model, HISTORY_TORSION))
        list->history[HISTORY_TORSION][k] = between(random, -size, size);
    if (history_has(&list->model, HISTORY_CONTACT_RADIUS))
        list->history[HISTORY_CONTACT_RADIUS][k] = sqrt(0.5e-3 * fabs(overlap)) * CHOOSE(random, 0, 0.5, 1, 1, 2);
}

static void list_init(struct contact_list *list, int count, struct model model)
{
    list->model = contact_model(model);
    must(contact_list_reserve(list, count + 1, model.dimension));
    list->count = count;
}

static double distance_of(const struct particles *p, int i, int j)
{
    double d2 = 0;
    for (int c = 0; c < p->dimension; c++)
        d2 += (p->x[c][i] - p->x[c][j]) * (p->x[c][i] - p->x[c][j]);
    return sqrt(d2);
}

/* Pairs of any two particles: `reach` is set so that they overlap as wanted. `behind`: the first ones of a particle and
 * the one behind it, which have sets of their own if there are enough. */
static void random_pairs(struct bench *b, int count, bool behind, struct model model, struct random *random)
{
    list_init(&b->pairs, count, model);
    for (int k = 0; k < count; k++) {
        int i = one_of(random, b->p.count - 1), j = i + 1 + one_of(random, b->p.count - 1 - i);
        if (behind && k + 1 < b->p.count && k % 7 != 3) {
            i = k;
            j = k + 1;
        }
        double overlap = random_overlap(random);
        b->pairs.i[k] = i;
        b->pairs.j[k] = j;
        b->pairs.reach[k] = distance_of(&b->p, i, j) + overlap;
        random_state(&b->pairs, k, &b->law, overlap, random);
    }
    must(contact_list_close(&b->pairs, &b->p, NULL));
}

/* Contacts of a wall, at most one per particle; every other one touches. */
static void random_wall(struct bench *b, int count, struct model model, struct random *random)
{
    struct contact_list *list = &b->wall.contacts;
    int axis = one_of(random, model.dimension);
    b->wall.axis = axis;
    b->wall.inward = one_of(random, 2) ? 1 : -1;
    b->wall.v = between(random, -0.1, 0.1);
    b->wall.x = b->p.x[axis][b->p.count / 2] - b->wall.inward * 1e-3;
    count = count < b->p.count ? count : b->p.count;
    list_init(list, count, model);
    for (int k = 0; k < count; k++) {
        list->i[k] = k;
        list->j[k] = b->p.count;
        double overlap = b->p.radius[k] - b->wall.inward * (b->p.x[axis][k] - b->wall.x);
        list->reach[k] = b->p.radius[k];
        random_state(list, k, &b->law, overlap, random);
    }
    b->wall.x_list = b->wall.x + CHOOSE(random, 0, 1e-5);
    must(contact_list_close(list, &b->p, &b->wall));
}

/* Bytes behind `used` of an array of `size` bytes. */
static void guard(void *array, size_t used, size_t size)
{
    for (size_t k = used; array && k + sizeof canary <= size; k += sizeof canary)
        memcpy((char *)array + k, &canary, sizeof canary);
}

static void guard_check(void *array, size_t used, size_t size)
{
    for (size_t k = used; array && k + sizeof canary <= size; k += sizeof canary)
        assert_memory_equal((char *)array + k, &canary, sizeof canary);
}

typedef void guard_each(void *array, size_t used, size_t size);

static void guard_list(struct contact_list *list, guard_each *each)
{
    const size_t real = list->model.mixed ? sizeof(float) : sizeof(double);
    const size_t used = real * (size_t)list->n_sets * SET_WIDTH;
    const size_t size = list->n_sets ? real * ((size_t)list->slots.capacity * SET_WIDTH + ARRAY_PADDING) : 0;
    for (int c = 0; c < HISTORY_COLUMNS; c++)
        each(list->slots.history[c], used, size);
}

static void guard_doubles(double *array, int count, guard_each *each)
{
    each(array, sizeof(double) * (size_t)whole_vectors(count), sizeof(double) * (size_t)(count + ARRAY_PADDING));
}

static void guard_floats(float *array, int count, guard_each *each)
{
    each(array, sizeof(float) * (size_t)whole_vectors(count), sizeof(float) * (size_t)(count + ARRAY_PADDING));
}

static void guard_particles(struct particles *p, guard_each *each)
{
    for (int c = 0; c < 3; c++) {
        guard_doubles(p->x[c], p->count, each);
        guard_doubles(p->v[c], p->count, each);
        guard_doubles(p->a[c], p->count, each);
        guard_doubles(p->omega[c], p->count, each);
        guard_doubles(p->alpha[c], p->count, each);
    }
    const size_t real = p->mixed ? sizeof(float) : sizeof(double), rows = (size_t)p->n_padded;
    for (int c = 0; c < 3; c++) {
        guard_floats(p->u_rest[c], p->count, each);
        guard_floats(p->v_rest[c], p->count, each);
        guard_floats(p->omega_rest[c], p->count, each);
    }
    const size_t views = real * particles_view_at(p, p->n_padded);
    each(p->view, views, views + real * ARRAY_PADDING);
    size_t size = particles_force_size(p),
           record = sizeof(double) * RECORD_STRIDE(p->dimension, p->n_rotations > 0, p->mixed);
    each(p->record, record * rows, record * (rows + ARRAY_PADDING));
    each(p->force, size, size + ARRAY_PADDING);
}

/* The same seed makes the same bench. */
static struct bench bench_of(uint64_t seed, int count, struct model model)
{
    struct random random;
    struct bench b = {0};
    random_init(&random, seed);
    b.law = random_law(&random, model);
    b.dt = CHOOSE(&random, 0, 1e-6, 1e-6);
    random_particles(&b.p, 2 + one_of(&random, count <= CONTACTS_MAX ? 20 : count), model, &random);
    random_pairs(&b, count, seed % 3 == 0, model, &random);
    random_wall(&b, count, model, &random);
    guard_list(&b.pairs, guard);
    guard_list(&b.wall.contacts, guard);
    guard_particles(&b.p, guard);
    return b;
}

static void bench_free(struct bench *b)
{
    particles_free(&b->p);
    contact_list_free(&b->pairs);
    contact_list_free(&b->wall.contacts);
}

static void same_bits(const char *what, const double *a, const double *b, int count)
{
    for (int k = 0; a && k < count; k++)
        if (memcmp(&a[k], &b[k], sizeof *a) != 0)
            fail_msg("%s[%d]: %.17g, the reference says %.17g", what, k, a[k], b[k]);
}

static void lists_compare(struct contact_list *a, struct contact_list *b)
{
    contact_list_read(a);
    contact_list_read(b);
    for (int c = 0; c < HISTORY_COLUMNS; c++)
        same_bits(history_field(c)->name, a->history[c], b->history[c], a->count);
}

/* Columns in blocks; NULL: none. */
static void same_column(const void *a, const void *b, size_t size, int columns, int count)
{
    for (int i = 0; a && i < count; i++)
        assert_memory_equal((const char *)a + size * COLUMN_AT(columns, i),
                            (const char *)b + size * COLUMN_AT(columns, i), size);
}

/* The sums of forces and moments but for those of the padding, which may differ in the sign of zero. */
static void forces_compare(const struct particles *a, const struct particles *b)
{
    const size_t row = (size_t)SUMS_BYTES(a->dimension, a->n_rotations > 0, a->mixed);
    const size_t columns = PARTICLES_COLUMNS_OFFSET(a->n_rows, a->dimension, a->n_rotations > 0, a->mixed);
    const size_t real = a->mixed ? sizeof(float) : sizeof(double);
    assert_memory_equal(a->force, b->force, row * (size_t)a->count);
    for (int c = 0; c < a->dimension + a->n_rotations; c++) {
        size_t at = columns + real * (size_t)(c * PARTICLES_BLOCK);
        same_column((char *)a->force + at, (char *)b->force + at, real, SUMS_COLUMNS(a->dimension, a->n_rotations > 0),
                    a->count);
    }
}

static void same_memory(const void *a, const void *b, size_t size)
{
    if (a)
        assert_memory_equal(a, b, size);
}

/* What steps go on with. */
static void motion_compare(const struct particles *a, const struct particles *b)
{
    const size_t real = a->mixed ? sizeof(float) : sizeof(double), count = (size_t)a->count;
    const int views = VIEW_COLUMNS(a->dimension, a->n_rotations > 0, a->mixed);
    for (int c = 0; c < 3; c++) {
        if (!a->mixed) {
            same_bits("x", a->x[c], b->x[c], a->count);
            same_bits("v", a->v[c], b->v[c], a->count);
            same_bits("omega", a->omega[c], b->omega[c], a->count);
        }
        same_column(a->view_u[c], b->view_u[c], real, views, a->count);
        same_column(a->view_v[c], b->view_v[c], real, views, a->count);
        same_column(a->view_omega[c], b->view_omega[c], real, views, a->count);
        same_column(a->view_lag[c], b->view_lag[c], real, views, a->count);
        same_column(a->view_lag[3 + c], b->view_lag[3 + c], real, views, a->count);
        same_memory(a->u_rest[c], b->u_rest[c], count * sizeof(float));
        same_memory(a->v_rest[c], b->v_rest[c], count * sizeof(float));
        same_memory(a->omega_rest[c], b->omega_rest[c], count * sizeof(float));
    }
    assert_memory_equal(a->record, b->record,
                        count * sizeof(double) * RECORD_STRIDE(a->dimension, a->n_rotations > 0, a->mixed));
}

static void particles_compare(const struct particles *a, const struct particles *b)
{
    motion_compare(a, b);
    for (int c = 0; c < 3; c++) {
        same_bits("x", a->x[c], b->x[c], a->count);
        same_bits("v", a->v[c], b->v[c], a->count);
        same_bits("omega", a->omega[c], b->omega[c], a->count);
        same_bits("a", a->a[c], b->a[c], a->count);
        same_bits("alpha", a->alpha[c], b->alpha[c], a->count);
    }
}

/* What contact k of the pairs alone loses by a law, with the reference. */
static struct contact_losses losses_alone(struct bench *b, int k, struct model model, const struct kernels *kernels,
                                          const struct contact_law_constants *law)
{
    struct contact_losses lost = {0};
    struct contact_list one = {0};
    list_init(&one, 1, model);
    one.i[0] = b->pairs.i[k];
    one.j[0] = b->pairs.j[k];
    one.reach[0] = b->pairs.reach[k];
    contact_list_carry(&one, 0, &b->pairs, k);
    must(contact_list_close(&one, &b->p, NULL));
    kernels->pair(&b->p, &one, 0, one.slots.n_spans, law, b->dt, b->p.force, &lost);
    contact_list_free(&one);
    return lost;
}

/* Sum of the sizes of the terms of each loss: contact by contact; rolling and torsion, which go into one sum and may
 * have different signs there, each by itself, and what dashpots and a changing stiffness would take without sliding:
 * friction takes it where contacts slide, and a rounding decides that for those at their limit. */
static struct contact_losses loss_sizes(struct bench *b, struct model model, const struct kernels *kernels)
{
    struct contact_losses sizes = {0};
    struct contact_law_constants rolling = b->law, torsion = b->law, stuck = b->law;
    rolling.torsion = torsion.rolling = (struct contact_resistance){0};
    stuck.rolling.mu = stuck.torsion.mu = stuck.mu_s = stuck.mu_d = 1e10;
    for (int k = 0; k < b->pairs.count; k++) {
        const struct contact_losses lost = losses_alone(b, k, model, kernels, &rolling),
                                    twist = losses_alone(b, k, model, kernels, &torsion),
                                    taken = losses_alone(b, k, model, kernels, &stuck);
        sizes.hysteresis += fabs(lost.hysteresis);
        sizes.viscous_normal += fabs(lost.viscous_normal);
        sizes.viscous_tangential += fabs(taken.viscous_tangential);
        sizes.stiffness += fabs(taken.stiffness);
        sizes.friction += fabs(lost.friction) + fabs(taken.viscous_tangential) + fabs(taken.stiffness);
        sizes.viscous_rolling += fabs(taken.viscous_rolling);
        sizes.rolling += fabs(lost.rolling) + fabs(twist.rolling) + fabs(taken.viscous_rolling);
    }
    return sizes;
}

/* n terms summed in two orders differ by at most 2 n eps sum |term|; one loss is itself a sum over up to 3 components.
 */
static void losses_compare(const struct contact_losses *a, const struct contact_losses *b,
                           const struct contact_losses *sizes, bool mixed)
{
    const double allowed = 2 * 3 * (CONTACTS_MAX + 1) * (mixed ? FLT_EPSILON : DBL_EPSILON);
    assert_close("hysteresis", a->hysteresis, b->hysteresis, allowed * sizes->hysteresis);
    assert_close("viscous normal", a->viscous_normal, b->viscous_normal, allowed * sizes->viscous_normal);
    assert_close("viscous tangential", a->viscous_tangential, b->viscous_tangential,
                 allowed * sizes->viscous_tangential);
    assert_close("friction", a->friction, b->friction, allowed * sizes->friction);
    assert_close("stiffness", a->stiffness, b->stiffness, allowed * sizes->stiffness);
    assert_close("rolling", a->rolling, b->rolling, allowed * sizes->rolling);
    assert_close("viscous rolling", a->viscous_rolling, b->viscous_rolling, allowed * sizes->viscous_rolling);
}

static struct kernels kernels_of(enum instruction_set isa, struct model model)
{
    const struct contact_model contacts = contact_model(model);
    return kernels_select(isa, &contacts);
}

/* A force evaluation and a step, as in integrate.c. */
static bool step(struct bench *b, const struct kernels *kernels, bool pairs_only, bool gravity)
{
    struct kick_constants kick = {.dt = b->dt, .gamma_b = 0.01, .gamma_br = 0.02};
    if (gravity)
        kick.gravity[1] = -9.81;
    struct contact_losses of_wall = {0};
    memset(&b->losses, 0, sizeof b->losses);
    kernels->pair(&b->p, &b->pairs, 0, b->pairs.slots.n_spans, &b->law, b->dt, b->p.force, &b->losses);
    if (pairs_only)
        return false;
    kernels->wall(&b->p, &b->wall, &b->law, b->dt, &of_wall);
    (void)kernels->kick(&b->p, &kick);
    return kernels->drift(&b->p, b->dt, b->dt, 1e-6);
}

static void compare_once(uint64_t seed, int count, struct model model, enum instruction_set isa)
{
    struct kernels reference = kernels_of(ISA_reference, model);
    struct kernels tested = kernels_of(isa, model);
    struct bench a = bench_of(seed, count, model), b = bench_of(seed, count, model), c = bench_of(seed, count, model);
    for (int k = 0; k < 2;
         k++) { /* twice: then velocities have no lag yet, and losses are no differences of large terms */
        const double before = k * 1e-6;
        (void)tested.drift(&a.p, 0, before, INFINITY);
        (void)reference.drift(&b.p, 0, before, INFINITY);
        (void)reference.drift(&c.p, 0, before, INFINITY);
    }
    struct contact_losses sizes = loss_sizes(&c, model, &reference);
    for (int k = 0; k < REPEATS; k++) { /* the second time histories stand exactly on the edges of branches */
        bool stale = step(&a, &tested, k == 0, seed % 2);
        assert_int_equal(step(&b, &reference, k == 0, seed % 2), stale);
        if (k == 0)
            losses_compare(&a.losses, &b.losses, &sizes, model.mixed);
        lists_compare(&a.pairs, &b.pairs);
        forces_compare(&a.p, &b.p);
        lists_compare(&a.wall.contacts, &b.wall.contacts);
        particles_compare(&a.p, &b.p);
        same_bits("wall force", &a.wall.force, &b.wall.force, 1);
    }
    guard_list(&a.pairs, guard_check);
    guard_list(&a.wall.contacts, guard_check);
    guard_particles(&a.p, guard_check);
    bench_free(&a);
    bench_free(&b);
    bench_free(&c);
}

static void isa_against_reference(enum instruction_set isa)
{
    enum { SEEDS = 20 };
    static const int chunks[] = {8 * WIDEST - 1, 8 * WIDEST, 8 * WIDEST + 1, 17 * WIDEST}; /* of the pair kernels */
    if (!instruction_set_supported(isa)) {
        print_message("*** %s: THIS CPU CANNOT RUN IT, NOT TESTED ***\n", instruction_set_name(isa));
        skip();
    }
    for (int m = 0; m < 16 * LAW_COUNT; m++) {
        struct model model = {2 + m / (8 * LAW_COUNT), m / 8 % LAW_COUNT, m / 2 % 4, m % 2};
        if (model.dimension == 2 && model.frictional == 3) /* in a plane nothing twists */
            continue;
        for (int count = 0; count <= CONTACTS_MAX; count++)
            for (uint64_t seed = 1; seed <= SEEDS; seed++)
                compare_once(1000 * seed + (uint64_t)count, count, model, isa);
        for (size_t k = 0; k < sizeof chunks / sizeof *chunks; k++)
            for (uint64_t seed = 1; seed <= 2; seed++)
                compare_once(seed, chunks[k], model, isa);
    }
}

static void avx2_is_the_reference(void **state)
{
    (void)state;
    isa_against_reference(ISA_avx2);
}

static void avx512_is_the_reference(void **state)
{
    (void)state;
    isa_against_reference(ISA_avx512);
}

/* Forces in mixed precision are those in double but for 1e-6 of their size and 1e-11 m of the overlap, although the
 * particles have moved since the lists were built. */
static void mixed_forces_are_those_in_double(void **state)
{
    (void)state;
    const struct kick_constants kick = {.dt = 0};
    for (int m = 0; m < 4; m++)
        for (uint64_t seed = 1; seed <= 100; seed++) {
            const int law = m % 2 ? LAW_HYSTERETIC : LAW_LINEAR;
            struct model model = {2 + m / 2, law, 0, 0}, mixed = {2 + m / 2, law, 0, 1};
            struct bench a = bench_of(seed, CONTACTS_MAX, model), b = bench_of(seed, CONTACTS_MAX, mixed);
            struct kernels ka = kernels_of(ISA_reference, model), kb = kernels_of(ISA_reference, mixed);
            double size = 0;
            a.law.gamma_n = b.law.gamma_n = 0; /* it jumps where contacts begin, which float does not tell to 1e-18 */
            (void)ka.drift(&a.p, 0, 0, INFINITY);
            (void)kb.drift(&b.p, 0, 0, INFINITY);
            ka.pair(&a.p, &a.pairs, 0, a.pairs.slots.n_spans, &a.law, a.dt, a.p.force, &a.losses);
            kb.pair(&b.p, &b.pairs, 0, b.pairs.slots.n_spans, &b.law, b.dt, b.p.force, &b.losses);
            (void)ka.kick(&a.p, &kick);
            (void)kb.kick(&b.p, &kick);
            for (int k = 0; k < model.dimension * a.p.count; k++)
                size = fmax(size, fabs(a.p.a[k / a.p.count][k % a.p.count] * a.p.mass[k % a.p.count]));
            for (int c = 0; c < model.dimension; c++)
                for (int i = 0; i < a.p.count; i++)
                    assert_close("force", b.p.a[c][i] * a.p.mass[i], a.p.a[c][i] * a.p.mass[i],
                                 CONTACTS_MAX * (1e-7 * size + 1e-11 * a.law.stiffness));
            bench_free(&a);
            bench_free(&b);
        }
}

/* k1 = k2, kc = 0: the hysteretic kernels give the linear law's forces, whatever the history. */
static void hysteretic_without_hysteresis_is_linear(void **state)
{
    (void)state;
    for (int m = 0; m < 8; m++)
        for (uint64_t seed = 1; seed <= 100; seed++) {
            struct model linear = {2 + m / 4, 0, m / 2 % 2, m % 2}, hysteretic = linear;
            hysteretic.law = LAW_HYSTERETIC;
            struct bench a = bench_of(seed, CONTACTS_MAX, hysteretic), b = bench_of(seed, CONTACTS_MAX, hysteretic);
            struct kernels ka = kernels_of(ISA_reference, hysteretic), kb = kernels_of(ISA_reference, linear);
            const struct scene_material same = {.law = LAW_LINEAR, .kn_n_per_m = a.law.stiffness};
            memcpy(a.law.normal, contact_law_constants_of(&same, LAW_HYSTERETIC).normal, sizeof a.law.normal);
            memcpy(b.law.normal, contact_law_constants_of(&same, LAW_LINEAR).normal, sizeof b.law.normal);
            (void)ka.drift(&a.p, 0, 0, INFINITY);
            (void)kb.drift(&b.p, 0, 0, INFINITY);
            ka.pair(&a.p, &a.pairs, 0, a.pairs.slots.n_spans, &a.law, a.dt, a.p.force, &a.losses);
            kb.pair(&b.p, &b.pairs, 0, b.pairs.slots.n_spans, &b.law, b.dt, b.p.force, &b.losses);
            forces_compare(&a.p, &b.p);
            contact_list_read(&a.pairs);
            contact_list_read(&b.pairs);
            for (int c = 0; c < 3; c++)
                same_bits("spring", a.pairs.history[HISTORY_SPRING + c], b.pairs.history[HISTORY_SPRING + c],
                          CONTACTS_MAX);
            assert_true(a.losses.hysteresis == 0);
            bench_free(&a);
            bench_free(&b);
        }
}

/* A k2 that does not grow: the elastoplastic kernels give the hysteretic law's forces and histories, bit for bit. */
static void elastoplastic_of_constant_k2_is_hysteretic(void **state)
{
    (void)state;
    for (int m = 0; m < 8; m++)
        for (uint64_t seed = 1; seed <= 100; seed++) {
            struct model plain = {2 + m / 4, LAW_HYSTERETIC, m / 2 % 2, m % 2}, grows = plain;
            grows.law = LAW_ELASTOPLASTIC;
            struct bench a = bench_of(seed, CONTACTS_MAX, grows), b = bench_of(seed, CONTACTS_MAX, plain);
            struct kernels ka = kernels_of(ISA_reference, grows), kb = kernels_of(ISA_reference, plain);
            const double k2 = b.law.stiffness;
            const struct scene_material same = {.law = LAW_HYSTERETIC,
                                                .k1_n_per_m = k2 - b.law.normal[HYSTERETIC_K2_MINUS_K1],
                                                .k2_n_per_m = k2,
                                                .kc_n_per_m = b.law.normal[HYSTERETIC_KC],
                                                .gamma_n_kg_per_s = b.law.gamma_n};
            memcpy(a.law.normal, contact_law_constants_of(&same, LAW_ELASTOPLASTIC).normal, sizeof a.law.normal);
            memcpy(b.law.normal, contact_law_constants_of(&same, LAW_HYSTERETIC).normal, sizeof b.law.normal);
            (void)ka.drift(&a.p, 0, 0, INFINITY);
            (void)kb.drift(&b.p, 0, 0, INFINITY);
            ka.pair(&a.p, &a.pairs, 0, a.pairs.slots.n_spans, &a.law, a.dt, a.p.force, &a.losses);
            kb.pair(&b.p, &b.pairs, 0, b.pairs.slots.n_spans, &b.law, b.dt, b.p.force, &b.losses);
            forces_compare(&a.p, &b.p);
            lists_compare(&a.pairs, &b.pairs);
            bench_free(&a);
            bench_free(&b);
        }
}

/* Without a spring of torsion the kernels that have it give what those of rolling alone give, but for the sign of zero.
 */
static void rolling_alone_is_torsion_without_spring(void **state)
{
    (void)state;
    for (int m = 0; m < 2 * LAW_COUNT; m++)
        for (uint64_t seed = 1; seed <= 50; seed++) {
            const struct model rolls = {3, m / 2, 2, m % 2}, twists = {3, m / 2, 3, m % 2};
            const struct kick_constants kick = {.dt = 0};
            struct bench bench[2];
            for (int k = 0; k < 2; k++) {
                struct bench *b = &bench[k];
                const struct kernels kernels = kernels_of(ISA_reference, k ? twists : rolls);
                *b = bench_of(seed, CONTACTS_MAX, twists);
                b->law.torsion = (struct contact_resistance){0};
                (void)kernels.drift(&b->p, 0, 0, INFINITY);
                kernels.pair(&b->p, &b->pairs, 0, b->pairs.slots.n_spans, &b->law, b->dt, b->p.force, &b->losses);
                (void)kernels.kick(&b->p, &kick);
                contact_list_read(&b->pairs);
            }
            for (int c = 0; c < 3; c++) {
                for (int i = 0; i < bench->p.count; i++)
                    assert_true(bench[0].p.a[c][i] == bench[1].p.a[c][i] &&
                                bench[0].p.alpha[c][i] == bench[1].p.alpha[c][i]);
                for (int k = 0; k < bench->pairs.count; k++)
                    assert_true(bench[0].pairs.history[HISTORY_ROLLING + c][k] ==
                                bench[1].pairs.history[HISTORY_ROLLING + c][k]);
            }
            assert_true(bench[0].losses.rolling == bench[1].losses.rolling);
            for (int k = 0; k < 2; k++)
                bench_free(&bench[k]);
        }
}

/* Kick and drift in one pass: the bits of one after the other. */
static void advance_is_kick_and_drift(void **state)
{
    (void)state;
    for (int isa = 0; isa < ISA_COUNT; isa++)
        for (int m = 0; m < 8 * LAW_COUNT && instruction_set_supported(isa); m++) {
            struct model model = {2 + m / (4 * LAW_COUNT), m / 4 % LAW_COUNT, m / 2 % 2, m % 2};
            struct kernels kernels = kernels_of(isa, model);
            struct bench a = bench_of(7, CONTACTS_MAX, model), b = bench_of(7, CONTACTS_MAX, model);
            struct kick_constants kick = {.dt = 1e-6, .gamma_b = 0.01, .gamma_br = 0.02, .gravity = {0, -9.81, 3}};
            double power;
            (void)kernels.drift(&a.p, 0, 0, INFINITY);
            (void)kernels.drift(&b.p, 0, 0, INFINITY);
            kernels.pair(&a.p, &a.pairs, 0, a.pairs.slots.n_spans, &a.law, a.dt, a.p.force, &a.losses);
            kernels.pair(&b.p, &b.pairs, 0, b.pairs.slots.n_spans, &b.law, b.dt, b.p.force, &b.losses);
            bool stale = kernels.advance(&a.p, &kick, 1e-6, 1e-7, &power);
            double expected = kernels.kick(&b.p, &kick);
            same_bits("power", &power, &expected, 1);
            assert_int_equal(kernels.drift(&b.p, 1e-6, 1e-6, 1e-7), stale);
            motion_compare(&a.p, &b.p);
            forces_compare(&a.p, &b.p);
            bench_free(&a);
            bench_free(&b);
        }
}

/* Steps in mixed precision go where those in double go, but for 1e-7 of what accelerations do, and
 * what is far below a float's rounding of the velocity is not lost: 20 000 steps under gravity, now and then settled.
 */
static void mixed_steps_are_those_in_double(void **state)
{
    enum { STEPS = 20000, SETTLE = 777 };
    (void)state;
    for (int m = 0; m < 2; m++)
        for (int slow = 0; slow < 2; slow++) {
            const double dt = 1e-6, g = slow ? 1e-7 : 9.81;
            const struct kick_constants kick = {.dt = dt, .gravity = {0, -g, 0.3 * g}};
            struct model model = {2 + m, 0, 1, 0}, mixed = {2 + m, 0, 1, 1};
            struct bench a = bench_of(3, CONTACTS_MAX, model), b = bench_of(3, CONTACTS_MAX, mixed);
            struct kernels ka = kernels_of(ISA_reference, model), kb = kernels_of(ISA_reference, mixed);
            double power, before = 0;
            particles_set_views(&b.p, 1); /* they go far from where they were listed */
            particles_import_state(&b.p);
            (void)ka.drift(&a.p, 0, 0, INFINITY);
            (void)kb.drift(&b.p, 0, 0, INFINITY);
            (void)ka.kick(&a.p, &(struct kick_constants){0});
            (void)kb.kick(&b.p, &(struct kick_constants){0});
            (void)ka.drift(&a.p, dt, before, INFINITY);
            (void)kb.drift(&b.p, dt, before, INFINITY);
            for (int k = 1; k < STEPS; k++) {
                (void)ka.advance(&a.p, &kick, dt, INFINITY, &power);
                if (k % SETTLE) {
                    (void)kb.advance(&b.p, &kick, dt, INFINITY, &power);
                } else {
                    (void)kb.kick(&b.p, &kick);
                    (void)kb.drift(&b.p, dt, dt, INFINITY);
                }
            }
            (void)ka.kick(&a.p, &kick);
            (void)kb.kick(&b.p, &kick);
            particles_export_positions(&b.p);
            for (int c = 0; c < model.dimension; c++)
                for (int i = 0; i < a.p.count; i++) {
                    double fallen = 0.5 * g * STEPS * dt * STEPS * dt;
                    assert_close("v", b.p.v[c][i], a.p.v[c][i], 1e-13 * fabs(a.p.v[c][i]) + 1e-7 * g * STEPS * dt);
                    assert_close("x", b.p.x[c][i], a.p.x[c][i], 1e-5 * b.p.quantum + 1e-7 * fallen);
                }
            bench_free(&a);
            bench_free(&b);
        }
}

/* SHAKEDOWN_ISA chooses, and a wrong name is refused. */
static void isa_is_chosen_by_name(void **state)
{
    enum instruction_set isa = ISA_COUNT;
    (void)state;
    assert_int_equal(setenv("SHAKEDOWN_ISA", "reference", 1), 0);
    must(instruction_set_select(&isa));
    assert_int_equal(isa, ISA_reference);
    assert_int_equal(setenv("SHAKEDOWN_ISA", "mmx", 1), 0);
    assert_int_equal(instruction_set_select(&isa), STATUS_USAGE);
    assert_non_null(strstr(status_message(), "mmx"));
    assert_int_equal(unsetenv("SHAKEDOWN_ISA"), 0);
    must(instruction_set_select(&isa));
    assert_true(instruction_set_supported(isa));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(avx2_is_the_reference),
        cmocka_unit_test(avx512_is_the_reference),
        cmocka_unit_test(mixed_forces_are_those_in_double),
        cmocka_unit_test(hysteretic_without_hysteresis_is_linear),
        cmocka_unit_test(elastoplastic_of_constant_k2_is_hysteretic),
        cmocka_unit_test(rolling_alone_is_torsion_without_spring),
        cmocka_unit_test(advance_is_kick_and_drift),
        cmocka_unit_test(mixed_steps_are_those_in_double),
        cmocka_unit_test(isa_is_chosen_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
