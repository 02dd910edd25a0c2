/* bench_peers --bin DIR --root DIR [--scene A|B|C] [--reps N] [--out DIR] [--json FILE]: the same packing stepped by
 * LAMMPS, LIGGGHTS and us, one thread each, in turn on one core; and the forces of all three compared
 * (docs/peers.md). With --threads N [--count N] [--scene discs|spheres]: large packings stepped by N threads of ours
 * and N ranks of LAMMPS. */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench/child.h"
#include "bench/peers_bench.h"
#include "bench/prepared_sample.h"
#include "common/command_line.h"
#include "common/floating_point.h"
#include "common/scene_file.h"
#include "sim/kernels/kernels.h"

static const struct peers_case CASES[] = {
    {.name = "A", .file = "scenes/biaxial.cfg", .our_steps = 40000, .steps = 4000},
    {.name = "B", .file = "scenes/triaxial_cyclic.cfg", .our_steps = 8000, .steps = 2000},
    {.name = "C", .file = "bench/glass_beads.cfg", .our_steps = 6000, .steps = 1000},
};

struct options {
    const char *bin, *root, *out;
    int reps, threads, count; /* threads 0: scenes on one core */
};

static void show_cpu(json_t *root)
{
    char line[256], model[256] = "unknown CPU";
    FILE *file = fopen("/proc/cpuinfo", "r");
    while (file && fgets(line, sizeof line, file))
        if (sscanf(line, "model name : %255[^\n]", model) == 1)
            break;
    if (file)
        fclose(file);
    printf("CPU: %s", model);
    for (int isa = 0; isa < ISA_COUNT; isa++)
        if (instruction_set_supported(isa))
            printf(", %s", instruction_set_name(isa));
    printf("\n");
    json_object_set_new(root, "cpu", json_string(model));
}

static enum status fill_work(struct peers_work *work, const struct options *options)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", options->root, work->at->file);
    snprintf(work->folder, sizeof work->folder, "%s/%s", options->out, work->at->name);
    TRY(prepare_sample(work->sim, path, NULL, 0, work->folder, work->checkpoint));
    TRY(scene_load(work->whole, path, NULL, 0));
    work->last = prepare_scene_copy(work->whole);
    if (!work->last)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    prepare_stage(work->last, (int)work->whole->n_stages - 1, work->checkpoint);
    return STATUS_OK;
}

static enum status run_case(const struct peers_case *at, const struct options *options, json_t *cases)
{
    char sim[1024];
    snprintf(sim, sizeof sim, "%s/sim/sim", options->bin);
    struct peers_work work = {.at = at,
                              .sim = sim,
                              .whole = calloc(1, sizeof *work.whole),
                              .reps = options->reps,
                              .threads = 1,
                              .report = json_pack("{s:s, s:s}", "scene", at->name, "file", at->file)};
    enum status status = work.whole ? fill_work(&work, options) : status_fail(STATUS_NO_MEMORY, "out of memory");
    if (status == STATUS_OK) {
        printf("\nscene %s: %s, %lld particles\n", at->name, at->file, (long long)work.last->sample.count);
        status = peers_physics(&work);
    }
    if (status == STATUS_OK && work.last->stage[0].material.law == LAW_HERTZ)
        status = peers_states(&work);
    if (status == STATUS_OK && work.reps > 0)
        status = peers_timing(&work);
    json_array_append_new(cases, work.report);
    prepare_scene_free(work.whole);
    prepare_scene_free(work.last);
    return status;
}

static enum status run_threads(const struct options *options, const char *only, json_t *cases)
{
    char sim[1024];
    snprintf(sim, sizeof sim, "%s/sim/sim", options->bin);
    const struct peers_threads threaded = {.sim = sim,
                                           .out = options->out,
                                           .only = only,
                                           .threads = options->threads,
                                           .count = options->count,
                                           .reps = options->reps};
    return peers_threads(&threaded, cases);
}

static enum status run_cases(const struct options *options, const char *only, json_t *root)
{
    json_t *cases = json_array();
    bool any = false;
    json_object_set_new(root, "cases", cases);
    TRY(folder_make(options->out));
    show_cpu(root);
    if (options->threads > 0)
        return run_threads(options, only, cases);
    for (size_t k = 0; k < sizeof CASES / sizeof *CASES; k++) {
        if (only && strcmp(only, CASES[k].name) != 0)
            continue;
        any = true;
        TRY(run_case(&CASES[k], options, cases));
    }
    return any ? STATUS_OK : status_fail(STATUS_USAGE, "there is no scene %s: A, B or C", only);
}

/* What options say, NULL: not given. */
struct words {
    const char *only, *reps, *threads, *count, *json;
};

static enum status read_numbers(struct options *options, const struct words *words)
{
    options->reps = words->reps ? atoi(words->reps) : 5;
    options->threads = words->threads ? atoi(words->threads) : 0;
    options->count = words->count ? atoi(words->count) : 100000;
    if (options->reps < 0 || options->reps > PEERS_REPS_MAX)
        return status_fail(STATUS_USAGE, "--reps must be 0 (forces only) to %d", PEERS_REPS_MAX);
    if (words->threads && options->threads < 1)
        return status_fail(STATUS_USAGE, "--threads must be a number of threads: %s", words->threads);
    if (words->count && !words->threads)
        return status_fail(STATUS_USAGE, "--count goes with --threads");
    if (options->count < PARTICLES_LARGE_SAMPLE || options->count > 10000000)
        return status_fail(STATUS_USAGE, "--count must be %d to 10000000", PARTICLES_LARGE_SAMPLE);
    return STATUS_OK;
}

static enum status bench(struct options *options, const struct words *words)
{
    int core;
    if (!options->bin || !options->root || !options->out)
        return status_fail(STATUS_USAGE, "start it with ./shakedown bench peers");
    TRY(read_numbers(options, words));
    if (options->threads == 0)
        TRY(pin_to_core(&core));
    json_t *root = json_object();
    enum status status = run_cases(options, words->only, root);
    if (status == STATUS_OK && words->json && json_dump_file(root, words->json, JSON_INDENT(1)) != 0)
        status = status_fail(STATUS_IO, "%s: cannot be written", words->json);
    json_decref(root);
    return status;
}

int main(int argc, char **argv)
{
    struct options options = {0};
    struct words words = {0};
    const struct command_line_option own[] = {
        {"bin", &options.bin, NULL},       {"root", &options.root, NULL}, {"scene", &words.only, NULL},
        {"reps", &words.reps, NULL},       {"out", &options.out, NULL},   {"json", &words.json, NULL},
        {"threads", &words.threads, NULL}, {"count", &words.count, NULL}, {NULL, NULL, NULL}};
    struct command_line line;
    setvbuf(stdout, NULL, _IOLBF, 0);
    floating_point_flush_subnormals();
    enum status status = command_line_parse(&line, argc, argv, own);
    if (status == STATUS_OK)
        status = bench(&options, &words);
    return status_report("bench_peers", status);
}
