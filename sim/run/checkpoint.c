#include "sim/run/checkpoint.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim/neighbours/locality_order.h"
#include "sim/run/checkpoint_file.h"
#include "sim/run/config_difference.h"
#include "sim/run/records.h"

/* What a checkpoint is read for: a run that goes on with the same bits, or a sample to start from. */
enum purpose { FOR_RUN, FOR_SAMPLE };

/* What an entry of the table is a member of. */
enum owner { OF_PROGRESS, OF_SAMPLE, OF_PARTICLES, OF_WALL, OF_LIST };

/* Where its values are: in the owner itself, or behind as many pointers as the model has components. */
enum extent {
    IN_PLACE,
    ONE_ARRAY,
    PER_AXIS,
    PER_ROTATION,
    PER_SPRING,
    PER_AXIS_IF_SINGLE,
    PER_ROTATION_IF_SINGLE,
    IF_ROTATIONS,
    IF_FRICTIONAL,
    IF_HYSTERETIC
};

struct entry {
    const char *name; /* of the dataset in the owner's group */
    enum owner owner;
    enum checkpoint_type type;
    size_t offset;
    enum extent extent;
    size_t count; /* IN_PLACE */
    bool late;    /* files of older versions do not have it */
};

#define I32 CHECKPOINT_I32
#define I64 CHECKPOINT_I64
#define F32 CHECKPOINT_F32
#define F64 CHECKPOINT_F64
#define VALUES(owner, type_, member, value_type, count)                                                                \
    {                                                                                                                  \
#member, owner, value_type, offsetof(struct type_, member), IN_PLACE, count, false                             \
    }
#define PROGRESS(member, value_type)      VALUES(OF_PROGRESS, run_progress, member, value_type, 1)
#define SAMPLE(member, value_type, count) VALUES(OF_SAMPLE, sample, member, value_type, count)
#define WALL(member)                      VALUES(OF_WALL, wall, member, F64, 1)
#define PARTICLES(member, extent)                                                                                      \
    {                                                                                                                  \
#member, OF_PARTICLES, F64, offsetof(struct particles, member), extent, 0, false                               \
    }
#define STEPS(member, value_type, extent)                                                                              \
    {                                                                                                                  \
#member, OF_PARTICLES, value_type, offsetof(struct particles, member), extent, 0, true                         \
    }
#define LIST(member, value_type, extent)                                                                               \
    {                                                                                                                  \
#member, OF_LIST, value_type, offsetof(struct contact_list, member), extent, 0, false                          \
    }

/* A new member that decides later bits is one line here. What every step makes anew before it is used (forces,
 * records of particles) is left out. */
static const struct entry table[] = {
    PROGRESS(run_id, I64),
    PROGRESS(fraction_done, F64),
    PROGRESS(kinetic_j, F64),
    PROGRESS(elastic_j, F64),
    PROGRESS(energy_step, I64),
    PROGRESS(frame_strain_next, I64),
    PROGRESS(exchanges, I64),
    PROGRESS(commands_repeated, I64),
    PROGRESS(frames, I64),
    PROGRESS(last_sample_step, I64),
    PROGRESS(last_frame_step, I64),
    VALUES(OF_PROGRESS, run_progress, record_total, I64, RECORD_CHANNELS),
    PROGRESS(log_bytes, I64),
    PROGRESS(elapsed_s, F64),
    PROGRESS(has_command, I32),
    PROGRESS(command.step, I64),
    PROGRESS(command.stage, I32),
    PROGRESS(command.n_steps, I32),
    PROGRESS(command.fraction_done, F64),
    PROGRESS(command.n_walls, I32),
    VALUES(OF_PROGRESS, run_progress, command.drive, I32, SCENE_WALLS_MAX),
    VALUES(OF_PROGRESS, run_progress, command.position_m, F64, SCENE_WALLS_MAX),
    VALUES(OF_PROGRESS, run_progress, command.velocity_m_per_s, F64, SCENE_WALLS_MAX),
    VALUES(OF_PROGRESS, run_progress, command.acceleration_m_per_s2, F64, SCENE_WALLS_MAX),
    VALUES(OF_PROGRESS, run_progress, command.force_n, F64, SCENE_WALLS_MAX),
    SAMPLE(step, I64, 1),
    SAMPLE(time_s, F64, 1),
    SAMPLE(stage, I32, 1),
    SAMPLE(stage_step, I64, 1),
    SAMPLE(stage_time_start_s, F64, 1),
    SAMPLE(stage_position_m, F64, SCENE_WALLS_MAX),
    SAMPLE(dt, F64, 1),
    {"kicked_s", OF_SAMPLE, F64, offsetof(struct sample, kicked_s), IN_PLACE, 1, true},
    SAMPLE(trajectory.from_step, I64, 1),
    SAMPLE(trajectory.n_steps, I32, 1),
    SAMPLE(trajectory.dt, F64, 1),
    SAMPLE(trajectory.x0, F64, SCENE_WALLS_MAX),
    SAMPLE(trajectory.v0, F64, SCENE_WALLS_MAX),
    SAMPLE(trajectory.a0, F64, SCENE_WALLS_MAX),
    SAMPLE(trajectory.drive, I32, SCENE_WALLS_MAX),
    SAMPLE(trajectory.force, F64, SCENE_WALLS_MAX),
    SAMPLE(trajectory.force_rate, F64, SCENE_WALLS_MAX),
    SAMPLE(trajectory.force_rate2, F64, SCENE_WALLS_MAX),
    SAMPLE(trajectory.v_last, F64, SCENE_WALLS_MAX),
    SAMPLE(audit.residual_j, F64, 1),
    SAMPLE(audit.controller_residual_j, F64, 1),
    SAMPLE(audit.error, F64, 1),
    SAMPLE(audit.error_before, F64, 1),
    SAMPLE(audit.force_start, F64, SCENE_WALLS_MAX),
    SAMPLE(audit.controller_force, F64, SCENE_WALLS_MAX),
    SAMPLE(audit.x_start, F64, SCENE_WALLS_MAX),
    SAMPLE(audit.work, F64, SCENE_WALLS_MAX),
    SAMPLE(audit.window_residual_j, F64, 1),
    SAMPLE(audit.window_error, F64, 1),
    SAMPLE(audit.window_intervals, I32, 1),
    SAMPLE(audit.bad_windows, I32, 1),
    SAMPLE(audit.leaking_windows, I32, 1),
    SAMPLE(ledger.kinetic_start, F64, 1),
    SAMPLE(ledger.elastic_start, F64, 1),
    SAMPLE(ledger.potential_start, F64, 1),
    SAMPLE(ledger.work_walls, F64, 1),
    SAMPLE(ledger.background, F64, 1),
    SAMPLE(ledger.contacts.hysteresis, F64, 1),
    SAMPLE(ledger.contacts.viscous_normal, F64, 1),
    SAMPLE(ledger.contacts.viscous_tangential, F64, 1),
    SAMPLE(ledger.contacts.friction, F64, 1),
    SAMPLE(verlet.skin, F64, 1),
    SAMPLE(pairs.search_max, I32, 1),
    SAMPLE(verlet.rebuilds, I64, 1),
    SAMPLE(verlet.built_step, I64, 1),
    {"id", OF_PARTICLES, I32, offsetof(struct particles, id), ONE_ARRAY, 0, false},
    PARTICLES(x, PER_AXIS),
    PARTICLES(v, PER_AXIS),
    PARTICLES(a, PER_AXIS),
    PARTICLES(x_list, PER_AXIS),
    PARTICLES(omega, PER_ROTATION),
    PARTICLES(alpha, PER_ROTATION),
    PARTICLES(radius, ONE_ARRAY),
    PARTICLES(mass, ONE_ARRAY),
    PARTICLES(inv_mass, ONE_ARRAY),
    PARTICLES(inv_inertia, IF_ROTATIONS),
    STEPS(view_u, I32, PER_AXIS_IF_SINGLE),
    STEPS(view_v, F32, PER_AXIS_IF_SINGLE),
    STEPS(view_omega, F32, PER_ROTATION_IF_SINGLE),
    STEPS(u_rest, F32, PER_AXIS_IF_SINGLE),
    STEPS(v_rest, F32, PER_AXIS_IF_SINGLE),
    STEPS(omega_rest, F32, PER_ROTATION_IF_SINGLE),
    WALL(x),
    WALL(v),
    WALL(force),
    {"touching", OF_WALL, I32, offsetof(struct wall, touching), IN_PLACE, 1, true},
    WALL(x_list),
    LIST(i, I32, ONE_ARRAY),
    LIST(j, I32, ONE_ARRAY),
    LIST(reach, F64, ONE_ARRAY),
    LIST(history, F64, IF_HYSTERETIC),
    LIST(spring, F64, PER_SPRING),
    LIST(rest, F64, PER_SPRING),
    LIST(sliding, F64, IF_FRICTIONAL),
};

/* One dataset. */
struct item {
    char path[64];
    enum checkpoint_type type;
    size_t count;
    void *data;
    bool late;
};

enum { ITEMS_MAX = 512 };
struct items {
    int n;
    struct item item[ITEMS_MAX];
};

/* What an owner's arrays are sized by. */
struct model {
    size_t count; /* members of an array */
    int axes, rotations, springs;
    bool hysteretic, single;
};

static int components(const struct entry *entry, const struct model *model)
{
    const int n[] = {[IN_PLACE] = 1,
                     [ONE_ARRAY] = 1,
                     [PER_AXIS] = model->axes,
                     [PER_ROTATION] = model->rotations,
                     [PER_SPRING] = model->springs,
                     [PER_AXIS_IF_SINGLE] = model->single ? model->axes : 0,
                     [PER_ROTATION_IF_SINGLE] = model->single ? model->rotations : 0,
                     [IF_ROTATIONS] = model->rotations > 0,
                     [IF_FRICTIONAL] = model->springs > 0,
                     [IF_HYSTERETIC] = model->hysteretic};
    return n[entry->extent];
}

static void collect_entry(struct items *items, const struct entry *entry, const char *group, void *owner,
                          const struct model *model)
{
    unsigned char *at = (unsigned char *)owner + entry->offset;
    bool many = entry->extent >= PER_AXIS && entry->extent <= PER_ROTATION_IF_SINGLE;
    for (int c = 0; c < components(entry, model) && items->n < ITEMS_MAX; c++) {
        struct item *item = &items->item[items->n++];
        *item = (struct item){.type = entry->type, .count = entry->count, .data = at, .late = entry->late};
        if (entry->extent != IN_PLACE) {
            item->count = model->count;
            memcpy(&item->data, at + (size_t)c * sizeof item->data, sizeof item->data);
        }
        snprintf(item->path, sizeof item->path, many ? "%s/%s/%d" : "%s/%s", group, entry->name, c);
    }
}

static void collect_owner(struct items *items, enum owner of, const char *group, void *owner, const struct model *model)
{
    for (size_t k = 0; k < sizeof table / sizeof *table; k++)
        if (table[k].owner == of)
            collect_entry(items, &table[k], group, owner, model);
}

static struct contact_list *list_of(struct sample *sample, int l)
{
    return l == 0 ? &sample->pairs : &sample->walls[l - 1].contacts;
}

static void list_group(char group[32], int l)
{
    snprintf(group, 32, l == 0 ? "contacts/pairs" : "contacts/wall%d", l - 1);
}

/* Every item of a run; `progress` NULL: of the sample alone. */
static void collect(struct items *items, struct sample *sample, struct run_progress *progress)
{
    char group[32];
    const struct particles *p = &sample->particles;
    sample_complete(sample);
    const struct model particles = {
        .count = (size_t)p->count, .axes = p->dimension, .rotations = p->n_rotations, .single = p->single};
    items->n = 0;
    if (progress)
        collect_owner(items, OF_PROGRESS, "progress", progress, &particles);
    collect_owner(items, OF_SAMPLE, "sample", sample, &particles);
    collect_owner(items, OF_PARTICLES, "particles", &sample->particles, &particles);
    for (int w = 0; w < sample->n_walls; w++) {
        snprintf(group, sizeof group, "walls/%d", w);
        collect_owner(items, OF_WALL, group, &sample->walls[w], &particles);
    }
    for (int l = 0; l <= sample->n_walls; l++) {
        struct contact_list *list = list_of(sample, l);
        contact_list_read(list);
        const struct model model = {.count = (size_t)list->count,
                                    .axes = p->dimension,
                                    .springs = list->n_springs,
                                    .hysteretic = list->hysteretic};
        list_group(group, l);
        collect_owner(items, OF_LIST, group, list, &model);
    }
}

/* Items of a sample that is only read through them. */
static struct items *items_of(const struct sample *sample, const struct run_progress *progress)
{
    struct items *items = malloc(sizeof *items);
    if (items)
        collect(items, (struct sample *)(uintptr_t)sample, (struct run_progress *)(uintptr_t)progress);
    return items;
}

static enum status no_memory(void)
{
    return status_fail(STATUS_NO_MEMORY, "no memory for a checkpoint");
}

/* The effective configuration; to be freed. */
static char *effective_config(const struct scene *scene)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    scene_print(out, scene);
    if (fclose(out) == 0)
        return text;
    free(text);
    return NULL;
}

static enum status put_texts(hid_t file, const struct sample *sample)
{
    char kernel_set[64];
    char *config = effective_config(sample->scene);
    if (!config)
        return no_memory();
    records_kernel_set(sample, kernel_set, sizeof kernel_set);
    enum status status = checkpoint_put_text(file, "effective_config", config);
    free(config);
    TRY(status);
    TRY(checkpoint_put_text(file, "version", SHAKEDOWN_VERSION));
    return checkpoint_put_text(file, "kernel_set", kernel_set);
}

static enum status put_items(hid_t file, const struct items *items)
{
    for (int k = 0; k < items->n; k++) {
        const struct item *item = &items->item[k];
        TRY(checkpoint_put(file, item->path, item->type, item->count, item->data));
    }
    return STATUS_OK;
}

enum status checkpoint_write(const char *path, const struct sample *sample, const struct run_progress *progress)
{
    hid_t file;
    struct items *items = items_of(sample, progress);
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
        struct contact_list *list = list_of(sample, l);
        size_t count;
        list_group(group, l);
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
        const struct contact_list *list = list_of(sample, l);
        for (int k = 0; k < list->count; k++)
            if (list->i[k] < 0 || list->i[k] >= n || list->j[k] <= list->i[k] || list->j[k] > n - (l == 0))
                return status_fail(STATUS_FORMAT, "checkpoint: contact %d of list %d is between no particles", k, l);
    }
    return STATUS_OK;
}

/* What is called for with a sample alone need not be in the file if it was late. */
static enum status get_item(hid_t file, const struct item *item, enum purpose purpose)
{
    if (item->late && !checkpoint_has(file, item->path)) {
        if (purpose == FOR_SAMPLE)
            return STATUS_OK;
        return status_fail(STATUS_FORMAT,
                           "checkpoint: %s is missing, an older version wrote it; a run can start from it as a sample "
                           "(sample.initial), but not go on",
                           item->path);
    }
    return checkpoint_get(file, item->path, item->type, item->count, item->data);
}

static enum status get_items(hid_t file, struct sample *sample, struct run_progress *progress, enum purpose purpose)
{
    TRY(lists_reserve(file, sample));
    struct items *items = items_of(sample, progress);
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

/* A checkpoint as it was written, with the scene it was written for. */
struct content {
    struct scene scene;
    struct sample *sample;
    struct run_progress progress;
    char *config, *kernel_set;
};

static void content_free(struct content *content)
{
    if (!content)
        return;
    sample_free(content->sample);
    scene_free(&content->scene);
    free(content->config);
    free(content->kernel_set);
    free(content);
}

static enum status content_fill(struct content *content, hid_t file, const char *path, enum purpose purpose)
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

static enum status content_load(struct content **content, const char *path, enum purpose purpose)
{
    hid_t file;
    *content = NULL;
    TRY(checkpoint_image_load(path, &file));
    *content = calloc(1, sizeof **content);
    enum status status = *content ? content_fill(*content, file, path, purpose) : no_memory();
    checkpoint_image_close(file);
    if (status == STATUS_OK)
        return STATUS_OK;
    content_free(*content);
    *content = NULL;
    return status;
}

/* Says so if the kernels are others: the state has the same bits in all of them, the energy ledger has not. */
static void warn_of_kernels(const char *path, const struct content *content)
{
    char now[64];
    records_kernel_set(content->sample, now, sizeof now);
    if (strcmp(now, content->kernel_set) != 0)
        fprintf(stderr,
                "sim: warning: %s was written by the kernels \"%s\", these are \"%s\": energies may differ in the last "
                "digits\n",
                path, content->kernel_set, now);
}

static enum status check_scene(const char *path, const struct content *content, const struct scene *scene)
{
    char difference[512];
    char *config = effective_config(scene);
    if (!config)
        return no_memory();
    bool same = config_is_same(content->config, config, difference, sizeof difference);
    free(config);
    return same ? STATUS_OK : status_fail(STATUS_CONFIG, "%s belongs to another scene: %s", path, difference);
}

enum status checkpoint_resume(const char *path, const struct scene *scene, struct sample **sample,
                              struct run_progress *progress)
{
    struct content *content;
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
    content_free(content);
    return status;
}

static double overlap(const struct sample *sample, int l, int k)
{
    const struct particles *p = &sample->particles;
    const struct contact_list *list = l == 0 ? &sample->pairs : &sample->walls[l - 1].contacts;
    int i = list->i[k], j = list->j[k];
    double d2 = 0;
    if (l > 0) {
        const struct wall *wall = &sample->walls[l - 1];
        return p->radius[i] - wall->inward * (p->x[wall->axis][i] - wall->x);
    }
    for (int c = 0; c < p->dimension; c++)
        d2 += (p->x[c][i] - p->x[c][j]) * (p->x[c][i] - p->x[c][j]);
    return p->radius[i] + p->radius[j] - sqrt(d2);
}

/* Contacts of another model, unpadded: the lists are built anew from them. */
static enum status take_list(struct sample *to, struct sample *from, int l)
{
    const struct contact_list *old = list_of(from, l);
    struct contact_list *list = list_of(to, l);
    TRY(contact_list_reserve(list, old->count, to->particles.dimension));
    list->count = old->count;
    for (int k = 0; k < old->count; k++) {
        double delta = overlap(from, l, k);
        list->i[k] = old->i[k];
        list->j[k] = old->j[k];
        if (list->hysteretic)
            list->history[k] = old->hysteretic ? old->history[k] : delta > 0 ? delta : 0;
        if (list->n_springs)
            list->sliding[k] = old->n_springs ? old->sliding[k] : 0;
        for (int c = 0; c < list->n_springs; c++) {
            list->spring[c][k] = old->n_springs ? old->spring[c][k] : 0;
            list->rest[c][k] = old->n_springs ? old->rest[c][k] : 0;
        }
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

static enum status take_sample(const char *path, struct sample *to, struct sample *from)
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

enum status checkpoint_start(const char *path, struct sample *sample)
{
    struct content *content;
    TRY(content_load(&content, path, FOR_SAMPLE));
    enum status status = take_sample(path, sample, content->sample);
    content_free(content);
    return status;
}

bool checkpoint_equal(const struct sample *a, const struct sample *b, char *difference, size_t size)
{
    struct items *of_a = items_of(a, NULL), *of_b = items_of(b, NULL);
    bool same = of_a && of_b && of_a->n == of_b->n;
    snprintf(difference, size, "%s", same ? "" : "the models");
    for (int k = 0; same && k < of_a->n; k++) {
        const struct item *x = &of_a->item[k], *y = &of_b->item[k];
        same = strcmp(x->path, y->path) == 0 && x->count == y->count &&
               (x->count == 0 || memcmp(x->data, y->data, x->count * checkpoint_type_size(x->type)) == 0);
        if (!same)
            snprintf(difference, size, "%s", x->path);
    }
    free(of_a);
    free(of_b);
    return same;
}
