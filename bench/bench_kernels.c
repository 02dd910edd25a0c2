/* bench_kernels [--json FILE]: nanoseconds per contact of the pair and wall kernels and per particle of drift, kick and
 * both in one, for every model, precision and instruction set that the CPU can run, and how far the forces are from the
 * reference in double. A lattice with disturbed positions: about three candidates a particle, nine in ten touching. */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/bus.h"
#include "common/command_line.h"
#include "common/floating_point.h"
#include "sim/kernels.h"
#include "sim/random.h"

enum { BLOCKS = 40, REPEATS = 15, SIDE_2D = 45, SIDE_3D = 15 };

struct model {
    int dimension;
    bool hysteretic, frictional, single;
};

struct sample {
    struct model model;
    struct particles p;
    struct contact_list pairs;
    struct wall wall;
    struct contact_law_constants law;
    int touching;
};

/* A part of a step as often as wanted at one state: no time passes. */
typedef void part(struct sample *sample, const struct kernels *kernels);

static void pair_part(struct sample *s, const struct kernels *kernels)
{
    struct contact_losses losses = {0};
    kernels->pair(&s->p, &s->pairs, 0, s->pairs.n_sets, &s->law, s->p.force, &losses);
}

static void wall_part(struct sample *s, const struct kernels *kernels)
{
    struct contact_losses losses = {0};
    kernels->wall(&s->p, &s->wall, &s->law, &losses);
}

static void drift_part(struct sample *s, const struct kernels *kernels)
{
    (void)kernels->drift(&s->p, 0, INFINITY);
}

static void kick_part(struct sample *s, const struct kernels *kernels)
{
    const struct kick_constants constants = {0};
    (void)kernels->kick(&s->p, &constants);
}

static void advance_part(struct sample *s, const struct kernels *kernels)
{
    const struct kick_constants constants = {0};
    double power;
    (void)kernels->advance(&s->p, &constants, 0, INFINITY, &power);
}

static const struct {
    const char *name;
    part *run;
    enum { PER_CANDIDATE, PER_WALL_CONTACT, PER_PARTICLE } per;
} parts[] = {{"pair", pair_part, PER_CANDIDATE},
             {"wall", wall_part, PER_WALL_CONTACT},
             {"drift", drift_part, PER_PARTICLE},
             {"kick", kick_part, PER_PARTICLE},
             {"advance", advance_part, PER_PARTICLE}};

static struct contact_law_constants law_of(struct model model)
{
    struct scene_material m = {.law = model.hysteretic ? LAW_HYSTERETIC : LAW_LINEAR,
                               .kn_n_per_m = 1e5,
                               .k1_n_per_m = 5e4,
                               .k2_n_per_m = 1e5,
                               .kc_n_per_m = 5e4,
                               .gamma_n_kg_per_s = 0.1,
                               .mu_s = 0.3,
                               .mu_d = 0.3,
                               .kt_n_per_m = 2e4,
                               .gamma_t_kg_per_s = 0.02};
    return contact_law_constants_of(&m);
}

static enum status place(struct sample *s, struct random *random)
{
    const int side = s->model.dimension == 2 ? SIDE_2D : SIDE_3D, dim = s->model.dimension;
    TRY(particles_init(&s->p, dim == 2 ? side * side : side * side * side, dim, s->model.frictional, s->model.single));
    for (int i = 0; i < s->p.count; i++) {
        const int at[3] = {i % side, i / side % side, i / side / side};
        s->p.radius[i] = (float)1e-3;
        for (int c = 0; c < dim; c++) {
            s->p.x[c][i] = 1e-3 * (1 + 1.99 * at[c] + 0.01 * (random_uniform(random) - 0.5));
            s->p.v[c][i] = 0.01 * (random_uniform(random) - 0.5);
        }
        for (int c = 0; c < s->p.n_rotations; c++)
            s->p.omega[c][i] = 10 * (random_uniform(random) - 0.5);
    }
    particles_set_mass(&s->p, 2000);
    return STATUS_OK;
}

static void history(struct contact_list *list, int k, struct random *random)
{
    contact_list_clear(list, k);
    if (list->hysteretic)
        list->history[k] = 2e-5 * random_uniform(random);
    for (int c = 0; c < list->n_springs; c++)
        list->spring[c][k] = 2e-5 * (random_uniform(random) - 0.5);
}

static void add(struct contact_list *list, int i, int j, double reach, struct random *random)
{
    int k = list->count++;
    list->i[k] = i;
    list->j[k] = j;
    list->reach[k] = reach;
    history(list, k, random);
}

static enum status list_init(struct contact_list *list, const struct sample *s, int capacity)
{
    list->hysteretic = s->model.hysteretic;
    list->n_springs = s->p.n_rotations;
    list->single = s->model.single;
    return contact_list_reserve(list, capacity, s->model.dimension);
}

static enum status connect(struct sample *s, struct random *random)
{
    const int side = s->model.dimension == 2 ? SIDE_2D : SIDE_3D, dim = s->model.dimension;
    TRY(list_init(&s->pairs, s, dim * s->p.count));
    TRY(list_init(&s->wall.contacts, s, s->p.count));
    s->wall.inward = 1;
    for (int i = 0; i < s->p.count; i++) {
        for (int c = 0, step = 1; c < dim; c++, step *= side)
            if (i / step % side + 1 < side && random_uniform(random) < (dim == 2 ? 0.999 : 0.999))
                add(&s->pairs, i, i + step, s->p.radius[i] + s->p.radius[i + step], random);
        if (i % side == 0)
            add(&s->wall.contacts, i, s->p.count, s->p.radius[i], random);
    }
    TRY(contact_list_close(&s->pairs, &s->p));
    return contact_list_close(&s->wall.contacts, &s->p);
}

static enum status sample_init(struct sample *s, struct model model)
{
    struct random random;
    memset(s, 0, sizeof *s);
    s->model = model;
    s->law = law_of(model);
    random_init(&random, 1);
    TRY(place(s, &random));
    return connect(s, &random);
}

static void sample_free(struct sample *s)
{
    particles_free(&s->p);
    contact_list_free(&s->pairs);
    contact_list_free(&s->wall.contacts);
}

static double cpu_now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int rising(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Least time of a call [ns]. */
static double time_ns(struct sample *s, const struct kernels *kernels, part *run)
{
    double ns[BLOCKS];
    for (int b = 0; b < BLOCKS; b++) {
        double start = cpu_now_s();
        for (int k = 0; k < REPEATS; k++)
            run(s, kernels);
        ns[b] = 1e9 * (cpu_now_s() - start) / REPEATS;
    }
    qsort(ns, BLOCKS, sizeof *ns, rising);
    return ns[0];
}

static enum status measure_model(struct model model, enum kernel_isa isa, json_t *rows)
{
    struct kernels kernels = kernels_select(isa, model.dimension, model.hysteretic, model.frictional, model.single);
    struct sample s;
    enum status status = sample_init(&s, model);
    printf("%-10s %dD %-10s %-12s %-6s", kernel_isa_name(isa), model.dimension,
           model.hysteretic ? "hysteretic" : "linear", model.frictional ? "frictional" : "frictionless",
           model.single ? "mixed" : "double");
    if (status == STATUS_OK)
        drift_part(&s, &kernels);
    for (size_t k = 0; status == STATUS_OK && k < sizeof parts / sizeof *parts; k++) {
        const int n[] = {s.pairs.count, s.wall.contacts.count, s.p.count};
        double ns = time_ns(&s, &kernels, parts[k].run) / n[parts[k].per];
        printf(" %s %6.2f", parts[k].name, ns);
        json_array_append_new(rows,
                              json_pack("{s:s, s:i, s:b, s:b, s:b, s:s, s:f}", "isa", kernel_isa_name(isa), "dimension",
                                        model.dimension, "hysteretic", model.hysteretic, "frictional", model.frictional,
                                        "mixed", model.single, "kernel", parts[k].name, "ns_each", ns));
    }
    printf("  %d sets for %d candidates\n", s.pairs.n_sets, s.pairs.count);
    sample_free(&s);
    return status;
}

int main(int argc, char **argv)
{
    (void)argc;
    (void)argv;
    json_t *rows = json_array();
    floating_point_flush_subnormals();
    enum status status = STATUS_OK;
    int from = getenv("ALL") ? 0 : ISA_avx512;
    for (int isa = from; isa < ISA_COUNT; isa++)
        for (int m = 0; status == STATUS_OK && m < 16; m++)
            if (getenv("ALL") || m == 4 || m == 5 || m == 10 || m == 11)
                status = measure_model((struct model){2 + m / 8, m / 4 % 2, m / 2 % 2, m % 2}, isa, rows);
    json_decref(rows);
    return status_report("bench_kernels", status);
}
