#include "sim/sample/sample.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim/neighbours/locality_order.h"
#include "sim/sample/initial_packing.h"

double sample_box_length_m(const struct sample *sample, int c)
{
    return sample->walls[2 * c + 1].x - sample->walls[2 * c].x;
}

enum axis sample_axis(const struct sample *sample, int c)
{
    return scene_pair_axis(sample->scene, c);
}

static void name_walls(struct sample *sample)
{
    for (int w = 0; w < sample->n_walls; w++) {
        sample->walls[w] = (struct wall){.axis = w / 2, .inward = w % 2 ? -1 : 1};
        sample->walls[w].contacts.model = sample->pairs.model;
    }
}

static void place_walls(struct sample *sample, const double *lo, const double *hi)
{
    for (int w = 0; w < sample->n_walls; w++)
        sample->walls[w].x = w % 2 ? hi[w / 2] : lo[w / 2];
}

/* Everything that does not need a state. */
static enum status set_model(struct sample *sample, const struct scene *scene)
{
    const struct contact_model model = contact_model_of(scene);
    const int dimension = model.dimension;
    sample->scene = scene;
    sample->stage = -1;
    sample->n_walls = scene_wall_count(scene);
    for (int c = 0; c < dimension && scene->gravity_m_per_s2.count; c++)
        sample->gravity[c] = scene->gravity_m_per_s2.value[sample_axis(sample, c)];
    TRY(instruction_set_select(&sample->isa));
    sample->kernels = kernels_select(sample->isa, &model);
    TRY(particles_init(&sample->particles, (int)scene->sample.count, dimension, model.frictional, model.mixed));
    sample->pairs.model = model;
    name_walls(sample);
    return STATUS_OK;
}

static enum status create_and(struct sample **sample, const struct scene *scene,
                              enum status (*fill)(struct sample *sample))
{
    *sample = calloc(1, sizeof **sample);
    if (!*sample)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    enum status status = set_model(*sample, scene);
    if (status == STATUS_OK && fill)
        status = fill(*sample);
    if (status != STATUS_OK) {
        sample_free(*sample);
        *sample = NULL;
    }
    return status;
}

static enum status cut_lists(struct sample *sample)
{
    return threads_cut(&sample->threads, &sample->particles, &sample->pairs, sample->walls, sample->n_walls);
}

enum status sample_init_lists(struct sample *sample)
{
    TRY(threads_init(&sample->threads, &sample->particles, sample->scene->threads));
    TRY(verlet_list_init(&sample->verlet, &sample->particles, sample->scene->neighbor.skin_ratio, &sample->pairs.model,
                         sample->isa, sample->threads.team));
    sample->pairs.team = sample->threads.team;
    TRY(cut_lists(sample));
    sample->verlet.renumber_steps =
        locality_order_interval(sample->scene->neighbor.renumber_steps, sample->particles.count);
    return STATUS_OK;
}

enum status sample_build_lists(struct sample *sample)
{
    TRY(verlet_list_build(&sample->verlet, &sample->particles, &sample->pairs, sample->walls, sample->n_walls));
    return cut_lists(sample);
}

enum status sample_close_lists(struct sample *sample)
{
    TRY(contact_list_close(&sample->pairs, &sample->particles, NULL));
    for (int w = 0; w < sample->n_walls; w++)
        TRY(contact_list_close(&sample->walls[w].contacts, &sample->particles, &sample->walls[w]));
    return cut_lists(sample);
}

enum status sample_start(struct sample *sample)
{
    for (int w = 0; w < sample->n_walls; w++)
        sample->trajectory.x0[w] = sample->walls[w].x;
    particles_set_units(&sample->particles, sample->scene->stage[0].dt_s);
    TRY(sample_init_lists(sample));
    return sample_build_lists(sample);
}

static enum status place_sample(struct sample *sample)
{
    double lo[3], hi[3];
    TRY(initial_packing_make(&sample->particles, sample->scene, lo, hi));
    place_walls(sample, lo, hi);
    return sample_start(sample);
}

enum status sample_create_empty(struct sample **sample, const struct scene *scene)
{
    return create_and(sample, scene, NULL);
}

enum status sample_create(struct sample **sample, const struct scene *scene)
{
    return create_and(sample, scene, place_sample);
}

void sample_free(struct sample *sample)
{
    if (!sample)
        return;
    particles_free(&sample->particles);
    contact_list_free(&sample->pairs);
    for (int w = 0; w < sample->n_walls; w++)
        contact_list_free(&sample->walls[w].contacts);
    verlet_list_free(&sample->verlet);
    threads_free(&sample->threads);
    free(sample);
}

const struct contact_list *sample_list(const struct sample *sample, int l)
{
    return l == 0 ? &sample->pairs : &sample->walls[l - 1].contacts;
}

void sample_kernel_set(const struct sample *sample, char *text, size_t size)
{
    const struct contact_model *model = &sample->pairs.model;
    snprintf(text, size, "%s %dd %s %s%s", instruction_set_name(sample->isa), sample->particles.dimension,
             scene_law_name(model->normal),
             model->torsion      ? "rolling, torsion"
             : model->rolling    ? "rolling"
             : model->frictional ? "frictional"
                                 : "frictionless",
             model->mixed ? " mixed" : "");
}

/* FNV-1a */
static uint64_t hash_bytes(uint64_t hash, const void *data, size_t size)
{
    const unsigned char *bytes = data;
    for (size_t k = 0; k < size; k++)
        hash = (hash ^ bytes[k]) * 0x100000001b3u;
    return hash;
}

/* In the order of ids. */
static uint64_t hash_values(uint64_t hash, const struct particles *p, const double *values)
{
    for (int i = 0; i < p->count; i++)
        hash = hash_bytes(hash, &values[p->slot[i]], sizeof *values);
    return hash;
}

uint64_t sample_hash(struct complete_sample whole)
{
    const struct sample *sample = whole.sample;
    const struct particles *p = &sample->particles;
    uint64_t hash = 0xcbf29ce484222325u;
    for (int c = 0; c < p->dimension; c++) {
        hash = hash_values(hash, p, p->x[c]);
        hash = hash_values(hash, p, p->v[c]);
    }
    for (int c = 0; c < p->n_rotations; c++)
        hash = hash_values(hash, p, p->omega[c]);
    for (int w = 0; w < sample->n_walls; w++) {
        hash = hash_bytes(hash, &sample->walls[w].x, sizeof(double));
        hash = hash_bytes(hash, &sample->walls[w].v, sizeof(double));
    }
    return hash;
}
