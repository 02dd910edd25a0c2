/* bench_scene SCENE [--set key=value]... [--json FILE]: microseconds per step of a scene's last stage and of each of
 * its parts, for every instruction set that the CPU can run, side by side in one run. The earlier stages are run first,
 * in process and without records. Of many short blocks the least and the median: the least is the machine undisturbed.
 */
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/bus.h"
#include "common/command_line.h"
#include "common/floating_point.h"
#include "sim/measure.h"
#include "sim/world.h"
#include "wallctl/law.h"

enum { BLOCKS = 40, STEPS_PER_BLOCK = 100, BUILDS_PER_BLOCK = 4, ENERGY_STEPS = 500 };

struct bench {
    struct world *world;
    double kinetic_j, elastic_j; /* for the controller's conditions */
    int64_t energy_step;
    bool finished;
};

struct timing {
    double least_us, median_us;
};

/* Exchange with the law and one step, as `sim --in-process` with an interval of 1. */
static enum status step(struct bench *bench)
{
    struct world *world = bench->world;
    struct wall_state state;
    struct wall_command command;
    if (world->step % ENERGY_STEPS == 0) {
        struct elastic_energy elastic = measure_elastic_energy(world);
        bench->kinetic_j = measure_kinetic_energy_j(world);
        bench->elastic_j = elastic.normal_j + elastic.tangential_j;
        bench->energy_step = world->step;
    }
    world_wall_state(world, &state);
    state.kinetic_energy_j = bench->kinetic_j;
    state.elastic_energy_j = bench->elastic_j;
    state.energy_step = bench->energy_step;
    TRY(wallctl_law(world->scene, &state, &command));
    bench->finished = command.finished;
    if (command.finished)
        return STATUS_OK;
    TRY(world_command(world, &command));
    return world_step_open(world);
}

static enum status prepare(struct bench *bench)
{
    double start = clock_now_s(), shown = start;
    const int last = (int)bench->world->scene->n_stages - 1;
    while (!bench->finished && bench->world->stage < last) {
        TRY(step(bench));
        if (bench->world->step % 1024 != 0 || clock_now_s() - shown < 1)
            continue;
        shown = clock_now_s();
        fprintf(stderr, "\rpreparing: stage %d of %d, %" PRId64 " steps, %.0f s ", bench->world->stage + 1, last,
                bench->world->step, shown - start);
    }
    fprintf(stderr, "\n");
    return STATUS_OK;
}

static enum status one_step(struct bench *bench)
{
    TRY(step(bench));
    return bench->finished ? status_fail(STATUS_LIMIT, "the last stage is shorter than what is measured") : STATUS_OK;
}

/* The parts, each as often as wanted at one state: no time passes (dt = 0), so nothing changes. */
static enum status one_pair(struct bench *bench)
{
    struct contact_losses losses = {0};
    struct world *world = bench->world;
    world->law.dt = 0;
    world->kernels.pair(&world->particles, &world->pairs, 0, world->pairs.n_sets, &world->law, world->particles.force,
                        &losses);
    return STATUS_OK;
}

static enum status one_walls(struct bench *bench)
{
    struct contact_losses losses = {0};
    struct world *world = bench->world;
    world->law.dt = 0;
    for (int w = 0; w < world->n_walls; w++)
        world->kernels.wall(&world->particles, &world->walls[w], &world->law, &losses);
    return STATUS_OK;
}

static enum status one_drift(struct bench *bench)
{
    (void)bench->world->kernels.drift(&bench->world->particles, 0, INFINITY);
    return STATUS_OK;
}

static enum status one_kick(struct bench *bench)
{
    struct kick_constants constants = {0};
    (void)bench->world->kernels.kick(&bench->world->particles, &constants);
    return STATUS_OK;
}

static enum status one_build(struct bench *bench)
{
    struct world *world = bench->world;
    return world_build_lists(world);
}

static int rising(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static enum status time_it(struct bench *bench, enum status (*part)(struct bench *), int repeats, struct timing *timing)
{
    double us[BLOCKS];
    for (int b = 0; b < BLOCKS; b++) {
        double start = clock_now_s();
        for (int k = 0; k < repeats; k++)
            TRY(part(bench));
        us[b] = 1e6 * (clock_now_s() - start) / repeats;
    }
    qsort(us, BLOCKS, sizeof *us, rising);
    *timing = (struct timing){us[0], us[BLOCKS / 2]};
    return STATUS_OK;
}

static json_t *row(const char *isa, const char *name, const struct timing *t)
{
    printf("%-10s %-8s %10.2f %10.2f\n", isa, name, t->least_us, t->median_us);
    return json_pack("{s:s, s:s, s:f, s:f}", "isa", isa, "part", name, "least_us", t->least_us, "median_us",
                     t->median_us);
}

static enum status measure_isa(struct bench *bench, enum kernel_isa isa, json_t *rows)
{
    static const struct {
        const char *name;
        enum status (*part)(struct bench *);
        int repeats;
    } parts[] = {{"step", one_step, STEPS_PER_BLOCK},   {"pair", one_pair, STEPS_PER_BLOCK},
                 {"walls", one_walls, STEPS_PER_BLOCK}, {"drift", one_drift, STEPS_PER_BLOCK},
                 {"kick", one_kick, STEPS_PER_BLOCK},   {"build", one_build, BUILDS_PER_BLOCK}};
    struct world *world = bench->world;
    world->kernels = kernels_select(isa, world->particles.dimension, world->pairs.hysteretic,
                                    world->pairs.n_springs > 0, world->pairs.single);
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++) {
        struct timing timing;
        TRY(time_it(bench, parts[k].part, parts[k].repeats, &timing));
        json_array_append_new(rows, row(kernel_isa_name(isa), parts[k].name, &timing));
    }
    return STATUS_OK;
}

static enum status report(struct bench *bench, const char *json_path)
{
    struct world *world = bench->world;
    int contacts = measure_contacts(world, NULL), wall_candidates = 0;
    json_t *rows = json_array();
    for (int w = 0; w < world->n_walls; w++)
        wall_candidates += world->walls[w].contacts.count;
    printf("%s: %d particles, %d contacts, %d candidates and %d at walls\n", world->scene->name, world->particles.count,
           contacts, world->pairs.count, wall_candidates);
    printf("%-10s %-8s %10s %10s\n", "kernels", "part", "least us", "median us");
    for (int isa = 0; isa < ISA_COUNT; isa++) {
        if (!kernel_isa_supported(isa))
            printf("%-10s skipped: this CPU cannot run it\n", kernel_isa_name(isa));
        else
            TRY(measure_isa(bench, isa, rows));
    }
    json_t *all =
        json_pack("{s:s, s:i, s:i, s:i, s:o}", "scene", world->scene->name, "particles", world->particles.count,
                  "contacts", contacts, "candidates", world->pairs.count, "rows", rows);
    enum status status = STATUS_OK;
    if (json_path && json_dump_file(all, json_path, JSON_INDENT(1)) != 0)
        status = status_fail(STATUS_IO, "%s: cannot be written", json_path);
    json_decref(all);
    return status;
}

static enum status bench_scene(const struct command_line *line, const char *json_path)
{
    if (line->n_positional != 1)
        return status_fail(STATUS_USAGE, "usage: bench_scene SCENE [--set key=value]... [--json FILE]");
    struct scene *scene = calloc(1, sizeof *scene);
    struct bench bench = {0};
    if (!scene)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = scene_load(scene, line->positional[0], line->override, line->n_overrides);
    if (status == STATUS_OK)
        status = world_create(&bench.world, scene);
    if (status == STATUS_OK)
        status = prepare(&bench);
    if (status == STATUS_OK)
        status = report(&bench, json_path);
    world_free(bench.world);
    scene_free(scene);
    free(scene);
    return status;
}

int main(int argc, char **argv)
{
    const char *json_path = NULL;
    const struct command_line_option own[] = {{"json", &json_path, NULL}, {NULL, NULL, NULL}};
    struct command_line line;
    floating_point_flush_subnormals();
    enum status status = command_line_parse(&line, argc, argv, own);
    if (status == STATUS_OK)
        status = bench_scene(&line, json_path);
    return status_report("bench_scene", status);
}
