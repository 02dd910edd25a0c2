#include "studies/plan.h"

#include <ctype.h>
#include <inttypes.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "common/scene_file.h"
#include "studies/files.h"
#include "studies/task.h"

static const double checkpoint_interval_s = 60; /* wall-clock: what a kill may cost of a long run */

static enum status no_memory(void)
{
    return status_fail(STATUS_NO_MEMORY, "out of memory");
}

/* The effective configuration as text, with the hash of it. */
static enum status scene_text(const struct scene *scene, char **text, char hash[PLAN_HASH_MAX])
{
    size_t size = 0;
    FILE *out = open_memstream(text, &size);
    if (!out)
        return no_memory();
    scene_print(out, scene);
    if (fclose(out) != 0)
        return no_memory();
    snprintf(hash, PLAN_HASH_MAX, "%016" PRIx64, files_hash(*text));
    return STATUS_OK;
}

static double scene_cost(const struct scene *scene, int first, int end)
{
    double steps = 0;
    for (int k = first; k < end; k++)
        steps += scene->stage[k].duration_s / scene->stage[k].dt_s;
    return steps * (double)scene->sample.count;
}

/* The first stages alone, without what only later ones, the record and the evaluation look at: the same text for all
 * runs that agree up to there. */
static void preparation_cut(struct scene *scene, int n_stages)
{
    scene->n_stages = n_stages;
    snprintf(scene->name, sizeof scene->name, "preparation");
    for (int k = 0; k < n_stages; k++)
        snprintf(scene->stage[k].name, sizeof scene->stage[k].name, "stage %d", k + 1);
    scene->material = scene->stage[0].material;
    scene->wall_material = scene->stage[0].wall_material;
    memcpy(scene->axis, scene->stage[0].axis, sizeof scene->axis);
    scene->record = (struct scene_record){0};
    memset(&scene->analysis, 0, sizeof scene->analysis);
    scene->analysis.modulus_strain = 1e-3;
}

static enum status preparation_find(struct plan *plan, const struct scene *scene, int n_stages,
                                    char hash[PLAN_HASH_MAX])
{
    struct scene *cut = malloc(sizeof *cut);
    char *text = NULL;
    if (!cut)
        return no_memory();
    *cut = *scene;
    preparation_cut(cut, n_stages);
    enum status status = scene_text(cut, &text, hash);
    free(cut);
    if (status != STATUS_OK)
        return status;
    for (int k = 0; k < plan->n_preparations; k++)
        if (strcmp(plan->preparation[k].hash, hash) == 0) {
            free(text);
            return STATUS_OK;
        }
    struct plan_preparation *preparation = &plan->preparation[plan->n_preparations++];
    memcpy(preparation->hash, hash, PLAN_HASH_MAX);
    preparation->cost = scene_cost(scene, 0, n_stages);
    preparation->scene = text;
    return STATUS_OK;
}

/* Takes the first stages away: the run starts from their checkpoint. */
static enum status scene_start_prepared(struct scene *scene, int n_stages, const char *hash)
{
    scene->n_stages -= n_stages;
    memmove(scene->stage, scene->stage + n_stages, (size_t)scene->n_stages * sizeof *scene->stage);
    scene->sample.initial = INITIAL_CHECKPOINT;
    snprintf(scene->sample.checkpoint, sizeof scene->sample.checkpoint, "../../prepared/%s/%s", hash, TASK_PREPARED);
    if (scene_stage_find(scene, scene->analysis.stage) < 0)
        return status_fail(STATUS_CONFIG, "the stage to be evaluated, \"%s\", belongs to the preparation",
                           scene->analysis.stage);
    return STATUS_OK;
}

static enum status run_prepare(struct plan *plan, struct plan_run *run, const struct study_series *series,
                               struct scene *scene)
{
    if (!series->prepare[0])
        return STATUS_OK;
    int last = scene_stage_find(scene, series->prepare);
    if (last < 0)
        return status_fail(STATUS_CONFIG, "prepare: the scene has no stage \"%s\"", series->prepare);
    if (last + 1 >= scene->n_stages)
        return status_fail(STATUS_CONFIG, "prepare: no stage comes after \"%s\"", series->prepare);
    TRY(preparation_find(plan, scene, last + 1, run->preparation));
    return scene_start_prepared(scene, last + 1, run->preparation);
}

/* A part of a folder's name: other characters than these become '_'. */
static void name_add(char *name, const char *text)
{
    size_t length = strlen(name);
    for (; *text && length + 1 < PLAN_NAME_MAX; text++)
        name[length++] = (char)(isalnum((unsigned char)*text) || strchr("._+-", *text) ? *text : '_');
    name[length] = '\0';
}

static void run_name(const struct study *study, struct plan_run *run)
{
    const struct study_series *series = &study->series[run->series];
    char seed[32];
    run->name[0] = '\0';
    if (study->n_series > 1) {
        name_add(run->name, series->name);
        name_add(run->name, "-");
    }
    for (int f = 0; f < series->n_factors; f++) {
        name_add(run->name, series->factor[f].name);
        name_add(run->name, "_");
        name_add(run->name, series->factor[f].level[run->level[f]].name);
        name_add(run->name, "-");
    }
    snprintf(seed, sizeof seed, "seed%" PRId64, run->seed);
    name_add(run->name, seed);
}

static enum status assignments_collect(const struct study_series *series, const struct plan_run *run, const char *seed,
                                       struct text_list *all)
{
    for (int k = 0; k < series->set.n; k++)
        TRY(text_list_add(all, series->set.text[k]));
    for (int f = 0; f < series->n_factors; f++) {
        const struct text_list *set = &series->factor[f].level[run->level[f]].set;
        for (int k = 0; k < set->n; k++)
            TRY(text_list_add(all, set->text[k]));
    }
    return text_list_add(all, seed);
}

static enum status scene_path(const struct study *study, const struct study_series *series, char path[PATH_MAX])
{
    char joined[2 * STUDY_PATH_MAX];
    if (series->scene[0] == '/')
        snprintf(joined, sizeof joined, "%s", series->scene);
    else
        TRY(files_join(joined, sizeof joined, study->folder, series->scene));
    if (!realpath(joined, path))
        return status_fail(STATUS_IO, "scene %s: there is no such file", joined);
    return STATUS_OK;
}

static enum status scene_make(const struct study *study, struct plan *plan, struct plan_run *run, struct scene *scene)
{
    const struct study_series *series = &study->series[run->series];
    struct text_list all = {0};
    char path[PATH_MAX], seed[32];
    TRY(scene_path(study, series, path));
    snprintf(seed, sizeof seed, "seed=%" PRId64 "L", run->seed);
    enum status status = assignments_collect(series, run, seed, &all);
    if (status == STATUS_OK)
        status = scene_load(scene, path, (const char *const *)all.text, all.n);
    text_list_free(&all);
    TRY(status);
    if (scene->checkpoint_interval_s <= 0)
        scene->checkpoint_interval_s = checkpoint_interval_s;
    TRY(run_prepare(plan, run, series, scene));
    run->cost = scene_cost(scene, 0, (int)scene->n_stages);
    return scene_text(scene, &run->scene, run->hash);
}

static enum status run_make(const struct study *study, struct plan *plan, struct plan_run *run)
{
    struct scene *scene = calloc(1, sizeof *scene);
    if (!scene)
        return no_memory();
    run_name(study, run);
    enum status status = scene_make(study, plan, run, scene);
    scene_free(scene);
    free(scene);
    if (status != STATUS_OK) {
        char text[900];
        snprintf(text, sizeof text, "%s", status_message());
        return status_fail(status, "run %s: %s", run->name, text);
    }
    for (int k = 0; k < plan->n_runs; k++)
        if (strcmp(plan->run[k].name, run->name) == 0)
            return status_fail(STATUS_CONFIG, "%s: two runs would be called %s: names of series and levels must differ",
                               study->path, run->name);
    return STATUS_OK;
}

static int combinations(const struct study_series *series)
{
    int n = 1;
    for (int f = 0; f < series->n_factors; f++)
        n *= series->factor[f].n_levels;
    return n;
}

static enum status series_make(const struct study *study, struct plan *plan, int s)
{
    const struct study_series *series = &study->series[s];
    for (int c = 0; c < combinations(series); c++) {
        for (int k = 0; k < series->n_seeds; k++) {
            struct plan_run *run = &plan->run[plan->n_runs];
            int rest = c;
            run->series = s;
            run->seed = series->seed[k];
            for (int f = series->n_factors - 1; f >= 0; f--) {
                run->level[f] = rest % series->factor[f].n_levels;
                rest /= series->factor[f].n_levels;
            }
            enum status status = run_make(study, plan, run);
            plan->n_runs++; /* also of one that failed: its text is to be freed */
            TRY(status);
        }
    }
    return STATUS_OK;
}

/* How many runs before this one start from the same preparation. */
static int rank_of(const struct plan *plan, int run)
{
    int rank = 0;
    for (int k = 0; k < run && plan->run[run].preparation[0]; k++)
        rank += strcmp(plan->run[k].preparation, plan->run[run].preparation) == 0;
    return rank;
}

/* Those come first that prepare their own sample; otherwise the order of the file. */
static enum status runs_order(struct plan *plan)
{
    struct plan_run *ordered = calloc((size_t)plan->n_runs + 1, sizeof *ordered);
    int n = 0;
    if (!ordered)
        return no_memory();
    for (int rank = 0; n < plan->n_runs; rank++)
        for (int k = 0; k < plan->n_runs; k++)
            if (rank_of(plan, k) == rank)
                ordered[n++] = plan->run[k];
    free(plan->run);
    plan->run = ordered;
    return STATUS_OK;
}

static enum status all_make(struct plan *plan, const struct study *study)
{
    size_t most = 1;
    for (int s = 0; s < study->n_series; s++)
        most += (size_t)combinations(&study->series[s]) * (size_t)study->series[s].n_seeds;
    plan->run = calloc(most, sizeof *plan->run);
    plan->preparation = calloc(most, sizeof *plan->preparation);
    if (!plan->run || !plan->preparation)
        return no_memory();
    for (int s = 0; s < study->n_series; s++)
        TRY(series_make(study, plan, s));
    return runs_order(plan);
}

enum status plan_make(struct plan *plan, const struct study *study)
{
    *plan = (struct plan){0};
    enum status status = all_make(plan, study);
    if (status != STATUS_OK)
        plan_free(plan);
    return status;
}

void plan_free(struct plan *plan)
{
    for (int k = 0; plan->run && k < plan->n_runs; k++)
        free(plan->run[k].scene);
    for (int k = 0; plan->preparation && k < plan->n_preparations; k++)
        free(plan->preparation[k].scene);
    free(plan->run);
    free(plan->preparation);
    *plan = (struct plan){0};
}

static enum status preparation_write(const struct plan_preparation *preparation, const char *out)
{
    char folder[4096], path[4200];
    if (snprintf(folder, sizeof folder, "%s/prepared/%s", out, preparation->hash) >= (int)sizeof folder)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", out);
    TRY(files_make_folder(folder));
    TRY(files_join(path, sizeof path, folder, "scene.cfg"));
    return files_exist(path) ? STATUS_OK : files_write(path, preparation->scene);
}

static enum status run_write(const struct plan_run *run, const char *out)
{
    struct task task;
    TRY(task_open(&task, out, run->name));
    if (strcmp(task.hash, run->hash) == 0)
        return STATUS_OK;
    return task_set(&task, run->scene, run->hash, run->preparation);
}

enum status plan_write(const struct plan *plan, const char *out)
{
    for (int k = 0; k < plan->n_preparations; k++)
        TRY(preparation_write(&plan->preparation[k], out));
    for (int k = 0; k < plan->n_runs; k++)
        TRY(run_write(&plan->run[k], out));
    return STATUS_OK;
}

bool plan_run_meets(const struct study *study, const struct plan_run *run, const struct study_where *where)
{
    const struct study_series *series = &study->series[run->series];
    for (int k = 0; k < where->n; k++) {
        int f = study_factor_find(series, where->factor[k]);
        if (f < 0 || strcmp(series->factor[f].level[run->level[f]].name, where->level[k]) != 0)
            return false;
    }
    return true;
}
