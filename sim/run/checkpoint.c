#include "sim/run/checkpoint.h"
#include "common/scene_file.h"

#include <stdlib.h>
#include <string.h>

#include "sim/grains/particle_order.h"
#include "sim/run/checkpoint_items.h"
#include "sim/run/config_difference.h"
#include "sim/sample/stage.h"

/* What a checkpoint is read for: a run that goes on with the same bits, or a sample to start from. */
enum purpose { FOR_RUN, FOR_SAMPLE };

static enum status no_memory(void)
{
    return status_fail(STATUS_NO_MEMORY, "no memory for a checkpoint");
}

/* A scene as scene_print or scene_print_every_key writes it; to be freed. */
static char *scene_text(const struct scene *scene, void (*print)(FILE *out, const struct scene *scene))
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    print(out, scene);
    if (fclose(out) == 0)
        return text;
    free(text);
    return NULL;
}

static enum status put_texts(hid_t file, const struct sample *sample)
{
    char kernel_set[64];
    char *config = scene_text(sample->scene, scene_print);
    if (!config)
        return no_memory();
    sample_kernel_set(sample, kernel_set, sizeof kernel_set);
    enum status status = checkpoint_put_text(file, "effective_config", config);
    free(config);
    TRY(status);
    TRY(checkpoint_put_text(file, "version", SHAKEDOWN_VERSION));
    return checkpoint_put_text(file, "kernel_set", kernel_set);
}

static enum status put_item(hid_t file, const struct checkpoint_item *item)
{
    if (item->columns == 1)
        return checkpoint_put(file, item->path, item->type, item->count, item->data);
    void *values = checkpoint_item_gather(item);
    enum status status = values ? checkpoint_put(file, item->path, item->type, item->count, values) : no_memory();
    free(values);
    return status;
}

static enum status put_items(hid_t file, const struct checkpoint_items *items)
{
    for (int k = 0; k < items->n; k++) {
        const struct checkpoint_item *item = &items->item[k];
        checkpoint_item_read(item);
        TRY(put_item(file, item));
        checkpoint_item_forget(item);
    }
    return STATUS_OK;
}

enum status checkpoint_write(const char *path, struct sample *sample, const struct run_progress *progress)
{
    hid_t file;
    struct run_progress stands = *progress;
    struct checkpoint_items *items = checkpoint_items_of(sample, &stands);
    if (!items)
        return no_memory();
    enum status status = checkpoint_image_create(&file);
    if (status == STATUS_OK)
        status = put_texts(file, sample);
    if (status == STATUS_OK)
        status = put_items(file, items);
    if (status == STATUS_OK)
        status = checkpoint_image_save(file, path);
    checkpoint_image_close(file);
    free(items);
    return status;
}

enum status checkpoint_share(const char *path, const char *copy)
{
    return checkpoint_file_share(path, copy);
}

static enum status lists_reserve(hid_t file, struct sample *sample)
{
    char group[32], path[48];
    for (int l = 0; l <= sample->n_walls; l++) {
        struct contact_list *list = checkpoint_list(sample, l);
        size_t count;
        checkpoint_list_group(group, l);
        snprintf(path, sizeof path, "%s/i", group);
        TRY(checkpoint_count(file, path, &count));
        if (count > INT32_MAX / 2)
            return status_fail(STATUS_FORMAT, "checkpoint: %s has %zu members", path, count);
        TRY(contact_list_reserve(list, (int)count, sample->particles.dimension));
        list->count = (int)count;
    }
    return STATUS_OK;
}

/* Indices are followed without a look later on. */
static enum status lists_check(struct sample *sample)
{
    const int n = sample->particles.count;
    if (sample->stage < -1 || sample->stage >= sample->scene->n_stages)
        return status_fail(STATUS_FORMAT, "checkpoint: it has no stage %d", sample->stage);
    for (int l = 0; l <= sample->n_walls; l++) {
        const struct contact_list *list = checkpoint_list(sample, l);
        for (int k = 0; k < list->count; k++)
            if (list->i[k] < 0 || list->i[k] >= n || list->j[k] <= list->i[k] || list->j[k] > n - (l == 0))
                return status_fail(STATUS_FORMAT, "checkpoint: contact %d of list %d is between no particles", k, l);
    }
    return STATUS_OK;
}

/* What is called for with a sample alone need not be in the file if it was late. */
static enum status get_item(hid_t file, const struct checkpoint_item *item, enum purpose purpose)
{
    if (item->late && !checkpoint_has(file, item->path)) {
        if (purpose == FOR_SAMPLE)
            return STATUS_OK;
        return status_fail(STATUS_FORMAT,
                           "checkpoint: %s is missing, an older version wrote it; a run can start from it as a sample "
                           "(sample.initial), but not go on",
                           item->path);
    }
    if (item->columns == 1)
        return checkpoint_get(file, item->path, item->type, item->count, item->data);
    void *values = checkpoint_item_gather(item);
    enum status status = values ? checkpoint_get(file, item->path, item->type, item->count, values) : no_memory();
    if (status == STATUS_OK)
        checkpoint_item_scatter(item, values);
    free(values);
    return status;
}

static enum status get_items(hid_t file, struct sample *sample, struct run_progress *progress, enum purpose purpose)
{
    TRY(lists_reserve(file, sample));
    struct checkpoint_items *items = checkpoint_items_of(sample, progress);
    if (!items)
        return no_memory();
    enum status status = STATUS_OK;
    for (int k = 0; status == STATUS_OK && k < items->n; k++)
        status = get_item(file, &items->item[k], purpose);
    free(items);
    TRY(status);
    TRY(particles_set_slots(&sample->particles));
    TRY(lists_check(sample));
    particles_set_views(&sample->particles, sample->verlet.skin); /* slots are in their quanta */
    return sample_close_lists(sample);
}

void checkpoint_content_free(struct checkpoint_content *content)
{
    if (!content)
        return;
    sample_free(content->sample);
    scene_free(&content->scene);
    free(content->config);
    free(content->kernel_set);
    free(content);
}

static enum status content_fill(struct checkpoint_content *content, hid_t file, const char *path, enum purpose purpose)
{
    TRY(checkpoint_get_text(file, "effective_config", &content->config));
    TRY(checkpoint_get_text(file, "kernel_set", &content->kernel_set));
    TRY(scene_parse(&content->scene, content->config, path));
    TRY(sample_create_empty(&content->sample, &content->scene));
    TRY(get_items(file, content->sample, &content->progress, purpose));
    sample_set_law(content->sample);
    const struct verlet_list before = content->sample->verlet;
    TRY(sample_init_lists(content->sample)); /* needs the radii */
    content->sample->verlet.skin = before.skin;
    content->sample->verlet.rebuilds = before.rebuilds;
    content->sample->verlet.built_step = before.built_step;
    return STATUS_OK;
}

static enum status content_load(struct checkpoint_content **content, const char *path, enum purpose purpose)
{
    hid_t file;
    *content = NULL;
    TRY(checkpoint_image_load(path, &file));
    *content = calloc(1, sizeof **content);
    enum status status = *content ? content_fill(*content, file, path, purpose) : no_memory();
    checkpoint_image_close(file);
    if (status == STATUS_OK)
        return STATUS_OK;
    checkpoint_content_free(*content);
    *content = NULL;
    return status;
}

/* Says so if the kernels are others: the state has the same bits in all of them, the energy ledger has not. */
static void warn_of_kernels(const char *path, const struct checkpoint_content *content)
{
    char now[64];
    sample_kernel_set(content->sample, now, sizeof now);
    if (strcmp(now, content->kernel_set) != 0)
        fprintf(stderr,
                "sim: warning: %s was written by the kernels \"%s\", these are \"%s\": energies may differ in the last "
                "digits\n",
                path, content->kernel_set, now);
}

static enum status check_scene(const char *path, const struct checkpoint_content *content, const struct scene *scene)
{
    char difference[512];
    char *before = scene_text(&content->scene, scene_print_every_key), *now = scene_text(scene, scene_print_every_key);
    const bool memory = before && now;
    const bool same = memory && config_is_same(before, now, difference, sizeof difference);
    free(before);
    free(now);
    if (!memory)
        return no_memory();
    return same ? STATUS_OK : status_fail(STATUS_CONFIG, "%s belongs to another scene: %s", path, difference);
}

enum status checkpoint_resume(const char *path, const struct scene *scene, struct sample **sample,
                              struct run_progress *progress)
{
    struct checkpoint_content *content;
    *sample = NULL;
    TRY(content_load(&content, path, FOR_RUN));
    enum status status = check_scene(path, content, scene);
    if (status == STATUS_OK) {
        warn_of_kernels(path, content);
        *sample = content->sample;
        content->sample = NULL;
        (*sample)->scene = scene;
        sample_set_law(*sample);
        *progress = content->progress;
    }
    checkpoint_content_free(content);
    return status;
}

enum status checkpoint_load_sample(struct checkpoint_content **content, const char *path)
{
    return content_load(content, path, FOR_SAMPLE);
}

bool checkpoint_equal(struct sample *a, struct sample *b, char *difference, size_t size)
{
    struct checkpoint_items *of_a = checkpoint_items_of(a, NULL), *of_b = checkpoint_items_of(b, NULL);
    bool same = of_a && of_b && of_a->n == of_b->n;
    snprintf(difference, size, "%s", same ? "" : "the models");
    for (int k = 0; same && k < of_a->n; k++) {
        const struct checkpoint_item *x = &of_a->item[k], *y = &of_b->item[k];
        checkpoint_item_read(x);
        checkpoint_item_read(y);
        same = strcmp(x->path, y->path) == 0 && checkpoint_item_equal(x, y);
        if (!same)
            snprintf(difference, size, "%s", x->path);
    }
    free(of_a);
    free(of_b);
    return same;
}
