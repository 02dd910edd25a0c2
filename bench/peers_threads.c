/* Many particles on several threads, and on as many ranks of LAMMPS. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/child.h"
#include "bench/lattice_sample.h"
#include "bench/peers_bench.h"
#include "bench/prepared_sample.h"
#include "sim/base/thread_team.h"
#include "sim/run/checkpoint.h"
#include "sim/run/sample_source.h"

/* Long enough for a packing whose lists hold while it is timed. */
enum { RELAX_STEPS = 4000 };

static const struct peers_case CASES[] = {
    {.name = "discs", .file = "lattice_sample.c", .our_steps = 8000, .steps = 1000},
    {.name = "spheres", .file = "lattice_sample.c", .our_steps = 2000, .steps = 400},
};

/* The packing, relaxed and at rest, as FOLDER/prepared.h5; one that is there is taken as it is. */
static enum status prepare(const struct peers_work *work, const struct lattice_kind *kind, const char *file)
{
    struct sample *sample = NULL;
    const struct run_progress none = {0};
    if (access(file, R_OK) == 0)
        return STATUS_OK;
    printf("packing %s\n", work->at->name);
    enum status status = sample_from_scene(&sample, work->whole);
    if (status == STATUS_OK)
        status = lattice_pack(sample, kind, false);
    if (status == STATUS_OK)
        status = lattice_begin(sample, 0);
    if (status == STATUS_OK)
        status = lattice_steps(sample, RELAX_STEPS);
    if (status == STATUS_OK)
        status = checkpoint_write(file, sample, &none);
    sample_free(sample);
    return status;
}

/* The scene of the packing, whose first stage relaxes, and its last stage alone, from the packing. */
static enum status fill_work(struct peers_work *work, const struct peers_threads *options,
                             const struct lattice_kind *kind)
{
    char file[1100];
    snprintf(work->folder, sizeof work->folder, "%s/%s", options->out, work->at->name);
    snprintf(file, sizeof file, "%s/prepared.h5", work->folder);
    TRY(folder_make(work->folder));
    TRY(lattice_scene(work->whole, kind, options->threads, "double", options->count));
    work->whole->stage[0].duration_s = RELAX_STEPS * work->whole->stage[0].dt_s;
    TRY(prepare(work, kind, file));
    TRY(prepare_path(file, work->checkpoint));
    work->last = prepare_scene_copy(work->whole);
    if (!work->last)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    prepare_stage(work->last, (int)work->whole->n_stages - 1, work->checkpoint);
    return STATUS_OK;
}

static enum status run_case(const struct peers_case *at, const struct peers_threads *options, json_t *cases)
{
    const struct lattice_kind *kind = lattice_kind_of(at == CASES ? 2 : 3);
    struct peers_work work = {.at = at,
                              .sim = options->sim,
                              .whole = calloc(1, sizeof *work.whole),
                              .reps = options->reps,
                              .threads = options->threads,
                              .report = json_pack("{s:s, s:i, s:i}", "scene", at->name, "particles", options->count,
                                                  "threads", options->threads)};
    enum status status = work.whole ? fill_work(&work, options, kind) : status_fail(STATUS_NO_MEMORY, "out of memory");
    if (status == STATUS_OK) {
        printf("\n%d %s, %d threads of ours, %d ranks of LAMMPS\n", options->count, at->name, options->threads,
               options->threads);
        status = peers_timing(&work);
    }
    json_array_append_new(cases, work.report);
    prepare_scene_free(work.whole);
    prepare_scene_free(work.last);
    return status;
}

enum status peers_threads(const struct peers_threads *options, json_t *cases)
{
    bool any = false;
    if (options->threads < 2 || options->threads > thread_team_cpus())
        return status_fail(STATUS_USAGE, "--threads must be 2 to %d, the CPUs that this process may use",
                           thread_team_cpus());
    if (options->reps < 1)
        return status_fail(STATUS_USAGE, "with --threads nothing but times is compared: --reps must be above 0");
    for (size_t k = 0; k < sizeof CASES / sizeof *CASES; k++) {
        if (options->only && strcmp(options->only, CASES[k].name) != 0)
            continue;
        any = true;
        TRY(run_case(&CASES[k], options, cases));
    }
    return any ? STATUS_OK
               : status_fail(STATUS_USAGE, "there is no scene %s with --threads: discs or spheres", options->only);
}
