#include "sim/run/sample_source.h"

#include <math.h>
#include <string.h>

#include "sim/run/checkpoint.h"
#include "sim/sample/contact_state.h"
#include "sim/sample/stage.h"

/* Column c of the history of contact k, where both models have it. */
static double take_value(const struct sample *from, const struct contact_model *to, int l, int k, int c)
{
    const struct contact_list *old = sample_list(from, l);
    if (c == HISTORY_MAX_OVERLAP && !history_has(&old->model, c))
        return fmax(contact_geometry_at(from, l, k).overlap, 0);
    if (!history_has(&old->model, c))
        return 0;
    /* in double there is no place for what rounding left out */
    return to->mixed ? contact_list_value(old, c, k) : contact_list_whole(old, c, k);
}

/* Contacts of another model, unpadded: the lists are built anew from them. */
static enum status take_list(struct sample *to, const struct sample *from, int l)
{
    const struct contact_list *old = sample_list(from, l);
    struct contact_list *list = l == 0 ? &to->pairs : &to->walls[l - 1].contacts;
    TRY(contact_list_reserve(list, old->count, to->particles.dimension));
    list->count = old->count;
    for (int k = 0; k < old->count; k++) {
        list->i[k] = old->i[k];
        list->j[k] = old->j[k];
        for (int c = 0; c < HISTORY_COLUMNS; c++)
            if (history_has(&list->model, c))
                list->history[c][k] = take_value(from, &list->model, l, k, c);
    }
    return STATUS_OK;
}

static void take_particles(struct particles *to, const struct particles *from)
{
    size_t size = (size_t)to->count * sizeof(double);
    for (int c = 0; c < to->dimension; c++) {
        memcpy(to->x[c], from->x[c], size);
        memcpy(to->v[c], from->v[c], size);
        memcpy(to->a[c], from->a[c], size);
    }
    for (int c = 0; c < to->n_rotations && from->n_rotations; c++) {
        memcpy(to->omega[c], from->omega[c], size);
        memcpy(to->alpha[c], from->alpha[c], size);
    }
    memcpy(to->radius, from->radius, size);
    memcpy(to->mass, from->mass, size);
    memcpy(to->id, from->id, (size_t)to->count * sizeof *to->id);
    memcpy(to->slot, from->slot, (size_t)to->count * sizeof *to->slot);
    particles_set_inverse(to);
}

static enum status take_sample(const char *path, struct sample *to, const struct sample *from)
{
    if (to->particles.dimension != from->particles.dimension)
        return status_fail(STATUS_CONFIG, "%s holds a sample of dimension %d, the scene says %d", path,
                           from->particles.dimension, to->particles.dimension);
    if (to->particles.count != from->particles.count)
        return status_fail(STATUS_CONFIG, "%s holds %d particles, the scene says sample.count = %d", path,
                           from->particles.count, to->particles.count);
    take_particles(&to->particles, &from->particles);
    for (int w = 0; w < to->n_walls; w++) {
        to->walls[w].x = from->walls[w].x;
        to->walls[w].force = from->walls[w].force;
    }
    for (int l = 0; l <= to->n_walls; l++)
        TRY(take_list(to, from, l));
    return STATUS_OK;
}

static enum status start_from_checkpoint(struct sample *sample, const char *path)
{
    struct checkpoint_content *content;
    TRY(checkpoint_load_sample(&content, path));
    enum status status = stage_settle_springs(content->sample);
    if (status == STATUS_OK)
        status = take_sample(path, sample, content->sample);
    checkpoint_content_free(content);
    TRY(status);
    return sample_start(sample);
}

enum status sample_from_scene(struct sample **sample, const struct scene *scene)
{
    if (scene->sample.initial != INITIAL_CHECKPOINT)
        return sample_create(sample, scene);
    TRY(sample_create_empty(sample, scene));
    enum status status = start_from_checkpoint(*sample, scene->sample.checkpoint);
    if (status != STATUS_OK) {
        sample_free(*sample);
        *sample = NULL;
    }
    return status;
}
