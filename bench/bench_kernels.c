/* bench_kernels [--json FILE]: nanoseconds per contact of the pair and wall kernels and per particle of drift, kick and
 * both in one, for every model, precision and instruction set that the CPU can run, and how far the forces are from the
 * reference in double. A lattice with disturbed positions: about three candidates a particle, nine in ten touching. */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/timing.h"
#include "common/command_line.h"
#include "common/floating_point.h"
#include "sim/base/random.h"
#include "sim/kernels/kernels.h"

enum { BLOCKS = 20, REPEATS = 15, SIDE_2D = 45, SIDE_3D = 15 };

struct model {
    int dimension;
    bool hysteretic, frictional, mixed;
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
    kernels->pair(&s->p, &s->pairs, 0, s->pairs.slots.n_spans, &s->law, 0, s->p.force, &losses);
}

static void wall_part(struct sample *s, const struct kernels *kernels)
{
    struct contact_losses losses = {0};
    kernels->wall(&s->p, &s->wall, &s->law, 0, &losses);
}

static void drift_part(struct sample *s, const struct kernels *kernels)
{
    (void)kernels->drift(&s->p, 0, 0, INFINITY);
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

static struct contact_model contact_model(struct model model)
{
    return contact_model_make(model.dimension, model.hysteretic ? LAW_HYSTERETIC : LAW_LINEAR, model.frictional,
                              model.mixed);
}

static struct kernels kernels_of(enum instruction_set isa, struct model model)
{
    const struct contact_model contacts = contact_model(model);
    return kernels_select(isa, &contacts);
}

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
    return contact_law_constants_of(&m, contact_model(model).normal);
}

static enum status place(struct sample *s, struct random *random)
{
    const int side = s->model.dimension == 2 ? SIDE_2D : SIDE_3D, dim = s->model.dimension;
    TRY(particles_init(&s->p, dim == 2 ? side * side : side * side * side, dim, s->model.frictional, s->model.mixed));
    for (int i = 0; i < s->p.count; i++) {
        const int at[3] = {i % side, i / side % side, i / side / side};
        s->p.radius[i] = 1e-3;
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

/* In space, springs lie across the direction d of the contact. */
static void history(struct contact_list *list, int k, const double *d, struct random *random)
{
    double along = 0, d2 = 0;
    contact_list_clear(list, k);
    double *const *spring = &list->history[HISTORY_SPRING];
    const int springs = contact_model_springs(&list->model);
    if (history_has(&list->model, HISTORY_MAX_OVERLAP))
        list->history[HISTORY_MAX_OVERLAP][k] = 2e-5 * random_uniform(random);
    for (int c = 0; c < springs; c++) {
        spring[c][k] = 2e-5 * (random_uniform(random) - 0.5);
        along += spring[c][k] * d[c];
        d2 += d[c] * d[c];
    }
    for (int c = 0; c < springs && springs == 3; c++)
        spring[c][k] -= along * d[c] / d2;
}

static void add(struct contact_list *list, int i, int j, const double *d, double reach, struct random *random)
{
    int k = list->count++;
    list->i[k] = i;
    list->j[k] = j;
    list->reach[k] = reach;
    history(list, k, d, random);
}

static void add_pair(struct sample *s, int i, int j, struct random *random)
{
    double d[3];
    for (int c = 0; c < s->p.dimension; c++)
        d[c] = s->p.x[c][i] - s->p.x[c][j];
    add(&s->pairs, i, j, d, s->p.radius[i] + s->p.radius[j], random);
}

static enum status list_init(struct contact_list *list, const struct sample *s, int capacity)
{
    list->model = contact_model(s->model);
    return contact_list_reserve(list, capacity, s->model.dimension);
}

static enum status connect(struct sample *s, struct random *random)
{
    const int side = s->model.dimension == 2 ? SIDE_2D : SIDE_3D, dim = s->model.dimension;
    const double across[3] = {1, 0, 0};
    TRY(list_init(&s->pairs, s, dim * s->p.count));
    TRY(list_init(&s->wall.contacts, s, s->p.count));
    s->wall.inward = 1;
    for (int i = 0; i < s->p.count; i++) {
        for (int c = 0, step = 1; c < dim; c++, step *= side)
            if (i / step % side + 1 < side && random_uniform(random) < 0.98)
                add_pair(s, i, i + step, random);
        if (i % side == 0)
            add(&s->wall.contacts, i, s->p.count, across, s->p.radius[i], random);
    }
    particles_mark_listed(&s->p, 2e-4);
    TRY(contact_list_close(&s->pairs, &s->p, NULL));
    return contact_list_close(&s->wall.contacts, &s->p, &s->wall);
}

/* The particles have moved since the lists were built: together by a fifth of the skin, and each on its own. */
static void move(struct sample *s, struct random *random)
{
    for (int c = 0; c < s->model.dimension; c++)
        for (int i = 0; i < s->p.count; i++)
            s->p.x[c][i] += 4e-5 + 2e-6 * (random_uniform(random) - 0.5);
    particles_import_state(&s->p);
}

static enum status sample_init(struct sample *s, struct model model)
{
    struct random random;
    memset(s, 0, sizeof *s);
    s->model = model;
    s->law = law_of(model);
    random_init(&random, 1);
    TRY(place(s, &random));
    TRY(connect(s, &random));
    move(s, &random);
    s->wall.x += 4e-5;
    return STATUS_OK;
}

static void sample_free(struct sample *s)
{
    particles_free(&s->p);
    contact_list_free(&s->pairs);
    contact_list_free(&s->wall.contacts);
}

/* What the pairs do to the particles: their accelerations, component after component. Room for 3 count. */
static void accelerations(struct sample *s, const struct kernels *kernels, double *a)
{
    const struct kick_constants constants = {0};
    drift_part(s, kernels);
    (void)kernels->kick(&s->p, &constants); /* sums start from zero */
    pair_part(s, kernels);
    (void)kernels->kick(&s->p, &constants);
    for (int c = 0; c < s->model.dimension; c++)
        memcpy(a + c * s->p.count, s->p.a[c], (size_t)s->p.count * sizeof *a);
}

/* Root of the mean square of the difference from the reference in double, over that of the reference. */
static enum status error_of(struct model model, enum instruction_set isa, double *error)
{
    struct model exact = model;
    struct sample s, reference = {0};
    double off2 = 0, size2 = 0;
    exact.mixed = false;
    enum status status = sample_init(&s, model);
    if (status == STATUS_OK)
        status = sample_init(&reference, exact);
    double *a = malloc((size_t)(6 * s.p.count) * sizeof *a), *b = a ? a + 3 * s.p.count : NULL;
    if (!a)
        status = status_fail(STATUS_NO_MEMORY, "out of memory");
    if (status == STATUS_OK) {
        struct kernels tested = kernels_of(isa, model), known = kernels_of(ISA_reference, exact);
        accelerations(&s, &tested, a);
        accelerations(&reference, &known, b);
        for (int k = 0; k < model.dimension * s.p.count; k++) {
            off2 += (a[k] - b[k]) * (a[k] - b[k]);
            size2 += b[k] * b[k];
        }
        *error = sqrt(off2 / size2);
    }
    free(a);
    sample_free(&s);
    sample_free(&reference);
    return status;
}

struct call {
    struct sample *sample;
    struct kernels kernels;
    part *run;
};

static enum status call_part(void *user)
{
    struct call *call = user;
    call->run(call->sample, &call->kernels);
    return STATUS_OK;
}

static json_t *row(struct model model, enum instruction_set isa, const char *kernel, double ns, double instructions,
                   double error)
{
    return json_pack("{s:s, s:i, s:b, s:b, s:s, s:s, s:f, s:f, s:f}", "isa", instruction_set_name(isa), "dimension",
                     model.dimension, "hysteretic", model.hysteretic, "frictional", model.frictional, "precision",
                     model.mixed ? "mixed" : "double", "kernel", kernel, "ns_each", ns, "instructions_each",
                     instructions, "force_error", error);
}

static enum status measure_parts(struct sample *s, enum instruction_set isa, double error, json_t *rows)
{
    struct call call = {.sample = s, .kernels = kernels_of(isa, s->model)};
    const int n[] = {s->pairs.count, s->wall.contacts.count, s->p.count};
    const int blocks = isa == ISA_reference ? 2 : BLOCKS, repeats = isa == ISA_reference ? 3 : REPEATS;
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++) {
        struct timing timing;
        call.run = parts[k].run;
        TRY(timing_take(call_part, &call, blocks, repeats, &timing));
        const double each = n[parts[k].per], instructions = timing.instructions < 0 ? -1 : timing.instructions / each;
        printf(" %7.2f", 1e3 * timing.least_us / each);
        json_array_append_new(rows,
                              row(s->model, isa, parts[k].name, 1e3 * timing.least_us / each, instructions, error));
    }
    return STATUS_OK;
}

static enum status measure_model(struct model model, enum instruction_set isa, json_t *rows)
{
    struct sample s;
    double error = 0;
    TRY(error_of(model, isa, &error));
    enum status status = sample_init(&s, model);
    printf("%-10s %dD %-10s %-12s %-6s", instruction_set_name(isa), model.dimension,
           model.hysteretic ? "hysteretic" : "linear", model.frictional ? "frictional" : "frictionless",
           model.mixed ? "mixed" : "double");
    if (status == STATUS_OK)
        status = measure_parts(&s, isa, error, rows);
    printf(" %9.1e\n", error);
    sample_free(&s);
    return status;
}

static enum status measure_all(json_t *rows)
{
    (void)timing_counts_instructions();
    printf(
        "ns per candidate (pair), wall contact (wall), particle (drift, kick, both: advance); error of the forces\n");
    printf("%-45s", "");
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++)
        printf(" %7s", parts[k].name);
    printf(" %9s\n", "error");
    for (int isa = 0; isa < ISA_COUNT; isa++) {
        if (!instruction_set_supported(isa)) {
            printf("*** %s: THIS CPU CANNOT RUN IT, NOT MEASURED ***\n", instruction_set_name(isa));
            continue;
        }
        for (int m = 0; m < 16; m++)
            TRY(measure_model((struct model){2 + m / 8, m / 4 % 2, m / 2 % 2, m % 2}, isa, rows));
    }
    return STATUS_OK;
}

int main(int argc, char **argv)
{
    const char *json_path = NULL;
    const struct command_line_option own[] = {{"json", &json_path, NULL}, {NULL, NULL, NULL}};
    struct command_line line;
    json_t *rows = json_array();
    floating_point_flush_subnormals();
    enum status status = command_line_parse(&line, argc, argv, own);
    if (status == STATUS_OK && line.n_positional > 0)
        status = status_fail(STATUS_USAGE, "usage: bench_kernels [--json FILE]");
    const struct timing_core before = timing_core();
    if (status == STATUS_OK)
        status = measure_all(rows);
    const struct timing_core after = timing_core();
    if (status == STATUS_OK)
        timing_core_print(&before, &after);
    json_t *all = json_pack("{s:o, s:o}", "core", timing_core_json(&before, &after), "rows", rows);
    if (status == STATUS_OK && json_path && json_dump_file(all, json_path, JSON_INDENT(1)) != 0)
        status = status_fail(STATUS_IO, "%s: cannot be written", json_path);
    json_decref(all);
    return status_report("bench_kernels", status);
}
