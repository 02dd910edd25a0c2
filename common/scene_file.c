#include "common/scene_file.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/auto_time_step.h"
#include "common/config_literals.h"
#include "common/scene_check.h"
#include "common/scene_keys.h"
#include "common/scene_prepare.h"

static enum status stages_list_check(const config_setting_t *list, const config_setting_t *parent, const char *where)
{
    if (!list)
        return config_fail(parent, where, "missing; a list of stages: stages = ( { ... }, { ... } )");
    if (!config_setting_is_list(list) || config_setting_length(list) < 1)
        return config_fail(list, where, "must be a list of one or more groups: stages = ( { ... }, { ... } )");
    for (int k = 0; k < config_setting_length(list); k++) {
        const config_setting_t *member = config_setting_get_elem(list, (unsigned)k);
        if (!config_setting_is_group(member))
            return config_fail(member, where, "member %d must be a group: { name = ...; ... }", k);
    }
    return STATUS_OK;
}

/* Room for `count` more stages. */
static enum status stages_reserve(struct scene *scene, int64_t count, const config_setting_t *at, const char *where)
{
    if (scene->n_stages + count > SCENE_STAGES_MAX)
        return config_fail(at, where, "%lld stages, repeated ones counted each; allowed: at most %d",
                           (long long)(scene->n_stages + count), SCENE_STAGES_MAX);
    void *grown = realloc(scene->stage, (size_t)(scene->n_stages + count) * sizeof *scene->stage);
    if (!grown)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    scene->stage = grown;
    memset(scene->stage + scene->n_stages, 0, (size_t)count * sizeof *scene->stage);
    return STATUS_OK;
}

/* "auto", or not given. */
static enum status time_step_set(const struct scene *scene, struct scene_stage *stage, const config_setting_t *at,
                                 const char *where)
{
    const double shortest_s = 1e-18, longest_s = 1e6;
    if (stage->dt_s > 0)
        return STATUS_OK;
    const double step_s = time_step_of_stage_s(scene, stage);
    if (!(step_s >= shortest_s))
        return config_fail(at, where,
                           "dt_s = \"auto\" is %g s for this material and these particles; allowed: a number "
                           "from %g s",
                           step_s, shortest_s);
    stage->dt_s = step_s < longest_s ? step_s : longest_s;
    return STATUS_OK;
}

/* The next stage, for which there is room. */
static enum status stage_read(struct scene *scene, const config_setting_t *root, const config_setting_t *setting,
                              const char *where)
{
    struct scene_stage *stage = &scene->stage[scene->n_stages];
    scene_stage_start(scene, stage);
    TRY(config_group_read(setting, scene_stage_keys, where, NULL, stage));
    TRY(config_require(setting, scene_stage_keys, where));
    stage->name_length = (int)strlen(stage->name);
    stage->line = strcmp(where, "prepare") == 0 ? 0 : (int)config_setting_source_line(setting);
    scene_material_refine(&stage->material);
    TRY(scene_check_material(scene, stage, setting, where));
    TRY(time_step_set(scene, stage, setting, where));
    TRY(scene_check_walls(scene, stage, root, setting, where));
    scene_stage_complete(stage);
    TRY(scene_check_stage(stage, setting, where));
    scene->n_stages++;
    return STATUS_OK;
}

/* Copies of the stages from `first` on, under names of their own: NAME.1 of the first pass, NAME.2 of the second ... */
static void group_repeat(struct scene *scene, int64_t first, int64_t repeat)
{
    const int64_t length = scene->n_stages - first;
    scene->stage[first].repeat = repeat;
    scene->stage[first].group_length = length;
    for (int64_t pass = repeat - 1; pass >= 0; pass--) /* the first comes last, as the others are copies of it */
        for (int64_t k = 0; k < length; k++) {
            struct scene_stage *stage = &scene->stage[first + pass * length + k];
            *stage = scene->stage[first + k];
            stage->repeat = pass == 0 ? stage->repeat : 0;
            stage->group_length = pass == 0 ? stage->group_length : 0;
            snprintf(stage->name + stage->name_length, sizeof stage->name - (size_t)stage->name_length, ".%lld",
                     (long long)pass + 1);
        }
    scene->n_stages = first + repeat * length;
}

static enum status group_read(struct scene *scene, const config_setting_t *root, const config_setting_t *setting,
                              const char *where)
{
    static const char *const own[] = {"stages", NULL};
    const config_setting_t *list = config_setting_get_member(setting, "stages");
    const int64_t first = scene->n_stages;
    struct scene_group group;
    char path[128];
    config_defaults(scene_group_keys, &group);
    TRY(config_group_read(setting, scene_group_keys, where, own, &group));
    TRY(config_require(setting, scene_group_keys, where));
    snprintf(path, sizeof path, "%s.stages", where);
    TRY(stages_list_check(list, setting, path));
    TRY(stages_reserve(scene, config_setting_length(list) * group.repeat, setting, where));
    for (int k = 0; k < config_setting_length(list); k++) {
        snprintf(path, sizeof path, "%s.stages.%d", where, k);
        TRY(stage_read(scene, root, config_setting_get_elem(list, (unsigned)k), path));
    }
    group_repeat(scene, first, group.repeat);
    for (int64_t k = first; k < scene->n_stages; k++)
        TRY(scene_check_name(scene, k, setting, where));
    return STATUS_OK;
}

static enum status stages_read(struct scene *scene, const config_setting_t *root)
{
    const config_setting_t *list = config_setting_get_member(root, "stages");
    TRY(stages_list_check(list, root, "stages"));
    for (int k = 0; k < config_setting_length(list); k++) {
        const config_setting_t *setting = config_setting_get_elem(list, (unsigned)k);
        char where[32];
        snprintf(where, sizeof where, "stages.%d", k);
        if (config_setting_get_member(setting, "stages")) {
            TRY(group_read(scene, root, setting, where));
            continue;
        }
        TRY(stages_reserve(scene, 1, setting, where));
        TRY(stage_read(scene, root, setting, where));
        TRY(scene_check_name(scene, scene->n_stages - 1, setting, where));
    }
    return STATUS_OK;
}

/* The stages of prepare = { ... } come first. Errors in them name the line of their own text, which explain prints. */
static enum status prepared_stages_read(struct scene *scene, const config_setting_t *root, const char *name)
{
    char source[512];
    config_t config;
    TRY(scene_prepare_text(scene, root, &scene->prepared));
    if (!scene->prepared)
        return STATUS_OK;
    snprintf(source, sizeof source, "%s, stages of prepare", name);
    config_source_name(source);
    config_init(&config);
    enum status status = STATUS_OK;
    if (config_read_string(&config, scene->prepared) != CONFIG_TRUE)
        status =
            status_fail(STATUS_CONFIG, "%s:%d: %s", source, config_error_line(&config), config_error_text(&config));
    const config_setting_t *list = config_lookup(&config, "stages");
    const int n = list ? config_setting_length(list) : 0;
    if (status == STATUS_OK)
        status = stages_reserve(scene, n, root, "prepare");
    for (int k = 0; k < n && status == STATUS_OK; k++)
        status = stage_read(scene, root, config_setting_get_elem(list, (unsigned)k), "prepare");
    config_destroy(&config);
    config_source_name(name);
    return status;
}

static enum status scene_read(struct scene *scene, const config_setting_t *root, const char *name, const char *path)
{
    static const char *const own[] = {"stages", "prepare", NULL};
    config_defaults(scene_keys, scene);
    TRY(config_group_read(root, scene_keys, "", own, scene));
    TRY(config_require(root, scene_keys, ""));
    if (scene->gravity_m_per_s2.count != 0 && scene->gravity_m_per_s2.count != SCENE_AXES)
        return config_fail(config_setting_get_member(root, "gravity_m_per_s2"), "gravity_m_per_s2",
                           "must have 3 members [x, y, z], or none");
    TRY(scene_check_sample(scene, path, config_setting_get_member(root, "sample")));
    TRY(prepared_stages_read(scene, root, name));
    TRY(stages_read(scene, root));
    if (scene_resists_rolling(scene) && !scene_is_frictional(scene)) /* stages without friction leave it out */
        return config_fail(config_setting_get_member(root, "stages"), "stages",
                           "mu_rolling and mu_torsion need friction (mu_s above 0), without which nothing turns");
    if (scene_stage_find(scene, scene->analysis.stage) < 0)
        return config_fail(config_setting_get_member(root, "analysis"), "analysis.stage", "there is no stage \"%s\"",
                           scene->analysis.stage);
    return STATUS_OK;
}

static enum status config_parse(config_t *config, const char *text, const char *name, const char *const *overrides,
                                int n_overrides)
{
    char *checked;
    TRY(config_literals(text, name, &checked));
    enum status status = STATUS_OK;
    if (config_read_string(config, checked) != CONFIG_TRUE)
        status = status_fail(STATUS_CONFIG, "%s:%d: %s", name, config_error_line(config), config_error_text(config));
    free(checked);
    for (int k = 0; status == STATUS_OK && k < n_overrides; k++)
        status = config_override(config, overrides[k]);
    return status;
}

/* `path`: of the file that the text is from, or NULL. */
static enum status parse(struct scene *scene, const char *text, const char *name, const char *path,
                         const char *const *overrides, int n_overrides)
{
    config_t config;
    memset(scene, 0, sizeof *scene);
    if (!(scene->source = strdup(name)))
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    config_source_name(name);
    config_init(&config);
    enum status status = config_parse(&config, text, name, overrides, n_overrides);
    if (status == STATUS_OK)
        status = scene_read(scene, config_root_setting(&config), name, path);
    config_destroy(&config);
    if (status == STATUS_OK && !(scene->text = strdup(text)))
        status = status_fail(STATUS_NO_MEMORY, "out of memory");
    if (status != STATUS_OK)
        scene_free(scene);
    return status;
}

/* The whole file as a string; it travels in one message with the effective configuration. */
static enum status file_read(const char *path, char **text)
{
    enum { LIMIT = 24 * 1024 };
    FILE *file = fopen(path, "rb");
    if (!file)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    char *buffer = calloc(LIMIT + 1, 1);
    size_t length = buffer ? fread(buffer, 1, LIMIT + 1, file) : 0;
    int failed = ferror(file);
    fclose(file);
    enum status status = STATUS_OK;
    if (!buffer)
        status = status_fail(STATUS_NO_MEMORY, "out of memory");
    else if (failed)
        status = status_fail(STATUS_IO, "%s: cannot be read: %s", path, strerror(errno));
    else if (length > LIMIT)
        status = status_fail(STATUS_CONFIG, "%s: larger than %d bytes", path, LIMIT);
    else if (memchr(buffer, '\0', length))
        status = status_fail(STATUS_CONFIG, "%s: not a text file", path);
    if (status != STATUS_OK) {
        free(buffer);
        return status;
    }
    *text = buffer;
    return STATUS_OK;
}

/* RUN_INFO carries the text and the effective configuration in one message of at most 60 kB. */
static enum status check_message_size(const struct scene *scene, const char *path)
{
    enum { LIMIT = 58000 };
    char *effective = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&effective, &size);
    if (!out)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    scene_print(out, scene);
    bool failed = fclose(out) != 0;
    free(effective);
    if (failed)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    if (size + strlen(scene->text) > LIMIT)
        return status_fail(
            STATUS_CONFIG,
            "%s: the file and its effective configuration (%zu bytes) exceed the %d bytes that a message "
            "can carry; fewer stages or shorter comments would fit",
            path, size + strlen(scene->text), LIMIT);
    return STATUS_OK;
}

enum status scene_load(struct scene *scene, const char *path, const char *const *overrides, int n_overrides)
{
    char *text = NULL;
    TRY(file_read(path, &text));
    enum status status = parse(scene, text, path, path, overrides, n_overrides);
    free(text);
    if (status == STATUS_OK)
        status = scene_check_paths(scene);
    return status == STATUS_OK ? check_message_size(scene, path) : status;
}

enum status scene_parse(struct scene *scene, const char *text, const char *name)
{
    return parse(scene, text, name, NULL, NULL, 0);
}
