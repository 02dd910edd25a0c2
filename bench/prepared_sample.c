#include "bench/prepared_sample.h"
#include "common/scene_file.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "bench/child.h"

enum { ARGUMENTS_MAX = 300 };

/* The last stage is cut to a step: sim shares the checkpoint of the stage before it under that stage's name. */
static enum status run_sim(const char *sim, const char *path, const struct scene *scene, const char *const *overrides,
                           int n_overrides, const char *folder)
{
    char file[512], log[512], cut[128], cut_path[64], interval[128];
    const char *argv[ARGUMENTS_MAX];
    int n = 0, last = (int)scene->n_stages - 1;
    const double dt_s = scene->stage[last].dt_s;
    snprintf(file, sizeof file, "%s/checkpoint.h5", folder);
    snprintf(log, sizeof log, "%s/prepare.log", folder);
    snprintf(cut, sizeof cut, "stages.%d.duration_s=%.17g", last, dt_s);
    snprintf(cut_path, sizeof cut_path, "stages.%d.cut_path=true", last);
    snprintf(interval, sizeof interval, "stages.%d.sample_interval_s=%.17g", last, dt_s);
    const char *const fixed[] = {sim, path,    "--in-process", "--checkpoint", file,    "--set",
                                 cut, "--set", cut_path,       "--set",        interval};
    for (size_t k = 0; k < sizeof fixed / sizeof *fixed; k++)
        argv[n++] = fixed[k];
    for (int k = 0; k < n_overrides && n < ARGUMENTS_MAX - 2; k++) {
        argv[n++] = "--set";
        argv[n++] = overrides[k];
    }
    argv[n] = NULL;
    fprintf(stderr, "preparing %s\n", scene->name);
    struct child child = {.argv = argv, .log = log};
    return child_run(&child);
}

static enum status keep(const struct scene *scene, const char *folder, const char *file)
{
    char from[1500];
    snprintf(from, sizeof from, "%s/checkpoint-%s.h5", folder, scene->stage[scene->n_stages - 2].name);
    if (rename(from, file) != 0)
        return status_fail(STATUS_IO, "%s: %s", from, strerror(errno));
    return STATUS_OK;
}

enum status prepare_forget(struct sample *sample)
{
    for (int l = 0; l <= sample->n_walls; l++) {
        struct contact_list *list = l == 0 ? &sample->pairs : &sample->walls[l - 1].contacts;
        contact_list_read(list);
        for (int k = 0; k < list->count; k++)
            contact_list_clear(list, k);
    }
    return sample_close_lists(sample);
}

enum status prepare_path(const char *file, char *checkpoint)
{
    char *absolute = realpath(file, NULL);
    if (!absolute)
        return status_fail(STATUS_IO, "%s: %s", file, strerror(errno));
    bool fits = snprintf(checkpoint, CONFIG_STRING_MAX, "%s", absolute) < CONFIG_STRING_MAX;
    free(absolute);
    return fits ? STATUS_OK : status_fail(STATUS_IO, "the path %.200s... is too long", file);
}

enum status prepare_sample(const char *sim, const char *path, const char *const *overrides, int n_overrides,
                           const char *folder, char *checkpoint)
{
    char file[1100];
    TRY(folder_make(folder));
    snprintf(file, sizeof file, "%s/prepared.h5", folder);
    if (access(file, R_OK) == 0)
        return prepare_path(file, checkpoint);
    struct scene *scene = calloc(1, sizeof *scene);
    if (!scene)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = scene_load(scene, path, overrides, n_overrides);
    if (status == STATUS_OK && scene->n_stages < 2)
        status = status_fail(STATUS_USAGE, "%s has nothing but one stage: no preparation", path);
    if (status == STATUS_OK)
        status = run_sim(sim, path, scene, overrides, n_overrides, folder);
    if (status == STATUS_OK)
        status = keep(scene, folder, file);
    scene_free(scene);
    free(scene);
    TRY(status);
    return prepare_path(file, checkpoint);
}

struct scene *prepare_scene_copy(const struct scene *from)
{
    const size_t stages = (size_t)from->n_stages * sizeof *from->stage;
    struct scene *to = malloc(sizeof *to);
    if (!to)
        return NULL;
    *to = *from;
    to->stage = malloc(stages);
    to->text = from->text ? strdup(from->text) : NULL;
    to->source = from->source ? strdup(from->source) : NULL;
    to->prepared = NULL; /* its stages are there */
    if (!to->stage || (from->text && !to->text) || (from->source && !to->source)) {
        prepare_scene_free(to);
        return NULL;
    }
    memcpy(to->stage, from->stage, stages);
    return to;
}

void prepare_scene_free(struct scene *scene)
{
    if (scene)
        scene_free(scene);
    free(scene);
}

void prepare_stage(struct scene *scene, int stage, const char *checkpoint)
{
    scene->stage[0] = scene->stage[stage];
    scene->n_stages = 1;
    scene->analysis.stage[0] = 0;
    scene->sample.initial = INITIAL_CHECKPOINT;
    snprintf(scene->sample.checkpoint, sizeof scene->sample.checkpoint, "%s", checkpoint);
}

enum status prepare_scene_file(const struct scene *scene, const char *path)
{
    FILE *out = fopen(path, "w");
    if (!out)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    scene_print(out, scene);
    bool bad = ferror(out);
    if (fclose(out) != 0 || bad)
        return status_fail(STATUS_IO, "%s cannot be written", path);
    return STATUS_OK;
}
