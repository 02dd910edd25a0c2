#include "sim/run/checkpoint_items.h"

#include <stdlib.h>
#include <string.h>

#include "sim/sample/step_completion.h"

/* What an entry of the table is a member of. */
enum owner { OF_PROGRESS, OF_SAMPLE, OF_PARTICLES, OF_WALL, OF_LIST };

/* Where its values are: in the owner itself, or behind as many pointers as the model has components. */
enum extent {
    IN_PLACE,
    ONE_ARRAY,
    PER_AXIS,
    PER_ROTATION,
    PER_AXIS_IF_SINGLE,
    PER_ROTATION_IF_SINGLE,
    PER_AXIS_IF_TURNING, /* double, with rotations */
    PER_ROTATION_IF_DOUBLE,
    IF_ROTATIONS,
    IN_PLACE_IF_SINGLE
};

struct entry {
    const char *name; /* of the dataset in the owner's group */
    enum owner owner;
    enum checkpoint_type type;
    size_t offset;
    enum extent extent;
    size_t count; /* IN_PLACE */
    bool late;    /* files of older versions do not have it */
    bool view;    /* of the views of particles, in blocks */
};

#define I32 CHECKPOINT_I32
#define I64 CHECKPOINT_I64
#define F32 CHECKPOINT_F32
#define F64 CHECKPOINT_F64
#define VALUES(owner, type_, member, value_type, count)                                                                \
    {                                                                                                                  \
#member, owner, value_type, offsetof(struct type_, member), IN_PLACE, count, false, false                      \
    }
#define PROGRESS(member, value_type)      VALUES(OF_PROGRESS, run_progress, member, value_type, 1)
#define SAMPLE(member, value_type, count) VALUES(OF_SAMPLE, sample, member, value_type, count)
#define WALL(member)                      VALUES(OF_WALL, wall, member, F64, 1)
#define PARTICLES(member, extent)                                                                                      \
    {                                                                                                                  \
#member, OF_PARTICLES, F64, offsetof(struct particles, member), extent, 0, false, false                        \
    }
#define STEPS(member, value_type, extent)                                                                              \
    {                                                                                                                  \
#member, OF_PARTICLES, value_type, offsetof(struct particles, member), extent, 0, true, false                  \
    }
#define VIEW(name, member, value_type, extent)                                                                         \
    {                                                                                                                  \
#name, OF_PARTICLES, value_type, offsetof(struct particles, member), extent, 0, true, true                     \
    }
#define LIST(member, value_type, extent)                                                                               \
    {                                                                                                                  \
#member, OF_LIST, value_type, offsetof(struct contact_list, member), extent, 0, false, false                   \
    }

/* A new member that decides later bits is one line here. What every step makes anew before it is used (forces,
 * records of particles) is left out. */
static const struct entry members[] = {
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
    VALUES(OF_PROGRESS, run_progress, record_hash, I64, RECORD_CHANNELS),
    PROGRESS(log_bytes, I64),
    PROGRESS(elapsed_s, F64),
    VALUES(OF_PROGRESS, run_progress, watch, F64, sizeof(struct stability_watch) / sizeof(double)),
    {"hurry_steps", OF_PROGRESS, I32, offsetof(struct run_progress, hurry_steps), IN_PLACE, 1, true, false},
    {"passing_noted", OF_PROGRESS, I32, offsetof(struct run_progress, passing_noted), IN_PLACE, 1, true, false},
    PROGRESS(doubts, I64),
    PROGRESS(has_command, I32),
    PROGRESS(command.step, I64),
    PROGRESS(command.stage, I32),
    PROGRESS(command.measure, I32),
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
    {"kicked_s", OF_SAMPLE, F64, offsetof(struct sample, kicked_s), IN_PLACE, 1, true, false},
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
    SAMPLE(ledger.work_material, F64, 1),
    SAMPLE(ledger.background, F64, 1),
    SAMPLE(ledger.contacts.hysteresis, F64, 1),
    SAMPLE(ledger.contacts.viscous_normal, F64, 1),
    SAMPLE(ledger.contacts.viscous_tangential, F64, 1),
    SAMPLE(ledger.contacts.friction, F64, 1),
    SAMPLE(ledger.contacts.stiffness, F64, 1),
    SAMPLE(ledger.contacts.rolling, F64, 1),
    SAMPLE(ledger.contacts.viscous_rolling, F64, 1),
    SAMPLE(verlet.skin, F64, 1),
    SAMPLE(pairs.search_max, I32, 1),
    SAMPLE(verlet.rebuilds, I64, 1),
    SAMPLE(verlet.built_step, I64, 1),
    {"id", OF_PARTICLES, I32, offsetof(struct particles, id), ONE_ARRAY, 0, false, false},
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
    {"speed_unit", OF_PARTICLES, F64, offsetof(struct particles, speed_unit), IN_PLACE_IF_SINGLE, 1, true, false},
    {"force_unit", OF_PARTICLES, F64, offsetof(struct particles, force_unit), IN_PLACE_IF_SINGLE, 1, true, false},
    VIEW(view_u, view_u, I32, PER_AXIS_IF_SINGLE),
    VIEW(view_v, view_v, F32, PER_AXIS_IF_SINGLE),
    VIEW(view_omega, view_omega, F32, PER_ROTATION_IF_SINGLE),
    VIEW(predicted_v, view_v, F64, PER_AXIS_IF_TURNING),
    VIEW(predicted_omega, view_omega, F64, PER_ROTATION_IF_DOUBLE),
    STEPS(u_rest, F32, PER_AXIS_IF_SINGLE),
    STEPS(v_rest, F32, PER_AXIS_IF_SINGLE),
    STEPS(omega_rest, F32, PER_ROTATION_IF_SINGLE),
    WALL(x),
    WALL(v),
    WALL(force),
    {"touching", OF_WALL, I32, offsetof(struct wall, touching), IN_PLACE, 1, true, false},
    WALL(x_list),
    LIST(i, I32, ONE_ARRAY),
    LIST(j, I32, ONE_ARRAY),
    LIST(reach, F64, ONE_ARRAY),
};

/* What an owner's arrays are sized by. */
struct model {
    size_t count; /* members of an array */
    int axes, rotations;
    bool mixed;
    int view_columns;
};

static int components(const struct entry *entry, const struct model *model)
{
    const int n[] = {[IN_PLACE] = 1,
                     [ONE_ARRAY] = 1,
                     [PER_AXIS] = model->axes,
                     [PER_ROTATION] = model->rotations,
                     [PER_AXIS_IF_SINGLE] = model->mixed ? model->axes : 0,
                     [PER_ROTATION_IF_SINGLE] = model->mixed ? model->rotations : 0,
                     [PER_AXIS_IF_TURNING] = !model->mixed && model->rotations > 0 ? model->axes : 0,
                     [PER_ROTATION_IF_DOUBLE] = !model->mixed ? model->rotations : 0,
                     [IF_ROTATIONS] = model->rotations > 0,
                     [IN_PLACE_IF_SINGLE] = model->mixed};
    return n[entry->extent];
}

static void collect_entry(struct checkpoint_items *items, const struct entry *entry, const char *group, void *owner,
                          const struct model *model)
{
    unsigned char *at = (unsigned char *)owner + entry->offset;
    bool many = entry->extent >= PER_AXIS && entry->extent < IF_ROTATIONS;
    for (int c = 0; c < components(entry, model) && items->n < CHECKPOINT_ITEMS_MAX; c++) {
        struct checkpoint_item *item = &items->item[items->n++];
        *item = (struct checkpoint_item){
            .type = entry->type, .count = entry->count, .data = at, .late = entry->late, .columns = 1};
        if (entry->extent != IN_PLACE && entry->extent != IN_PLACE_IF_SINGLE) {
            item->count = model->count;
            item->columns = entry->view ? model->view_columns : 1;
            memcpy(&item->data, at + (size_t)c * sizeof item->data, sizeof item->data);
        }
        snprintf(item->path, sizeof item->path, many ? "%s/%s/%d" : "%s/%s", group, entry->name, c);
    }
}

static void collect_owner(struct checkpoint_items *items, enum owner of, const char *group, void *owner,
                          const struct model *model)
{
    for (size_t k = 0; k < sizeof members / sizeof *members; k++)
        if (members[k].owner == of)
            collect_entry(items, &members[k], group, owner, model);
}

struct contact_list *checkpoint_list(struct sample *sample, int l)
{
    return l == 0 ? &sample->pairs : &sample->walls[l - 1].contacts;
}

void checkpoint_list_group(char group[32], int l)
{
    snprintf(group, 32, l == 0 ? "contacts/pairs" : "contacts/wall%d", l - 1);
}

/* The columns of the history that the model has. */
static void collect_history(struct checkpoint_items *items, const char *group, struct contact_list *list)
{
    for (int c = 0; c < HISTORY_COLUMNS && items->n < CHECKPOINT_ITEMS_MAX; c++) {
        const struct history_field *field = history_field(c);
        if (!history_has(&list->model, c))
            continue;
        struct checkpoint_item *item = &items->item[items->n++];
        *item = (struct checkpoint_item){.type = F64,
                                         .count = (size_t)list->count,
                                         .data = list->history[c],
                                         .columns = 1,
                                         .list = list,
                                         .column = c};
        if (field->component >= 0)
            snprintf(item->path, sizeof item->path, "%s/%s/%d", group, field->name, field->component);
        else
            snprintf(item->path, sizeof item->path, "%s/%s", group, field->name);
    }
}

static void collect(struct checkpoint_items *items, struct sample *sample, struct run_progress *progress)
{
    char group[32];
    const struct particles *p = &sample->particles;
    (void)sample_complete(sample);
    const struct model particles = {.count = (size_t)p->count,
                                    .axes = p->dimension,
                                    .rotations = p->n_rotations,
                                    .mixed = p->mixed,
                                    .view_columns = particles_view_columns(p)};
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
        struct contact_list *list = checkpoint_list(sample, l);
        const struct model model = {.count = (size_t)list->count, .axes = p->dimension};
        checkpoint_list_group(group, l);
        collect_owner(items, OF_LIST, group, list, &model);
        collect_history(items, group, list);
    }
}

bool checkpoint_item_equal(const struct checkpoint_item *a, const struct checkpoint_item *b)
{
    const size_t size = checkpoint_type_size(a->type);
    const unsigned char *x = a->data, *y = b->data;
    bool same = a->count == b->count;
    for (size_t k = 0; same && k < a->count; k++)
        same = memcmp(x + size * COLUMN_AT(a->columns, k), y + size * COLUMN_AT(b->columns, k), size) == 0;
    return same;
}

void *checkpoint_item_gather(const struct checkpoint_item *item)
{
    const size_t size = checkpoint_type_size(item->type);
    unsigned char *values = malloc(item->count * size);
    for (size_t k = 0; values && k < item->count; k++)
        memcpy(values + size * k, (const unsigned char *)item->data + size * COLUMN_AT(item->columns, k), size);
    return values;
}

void checkpoint_item_scatter(const struct checkpoint_item *item, const void *values)
{
    const size_t size = checkpoint_type_size(item->type);
    for (size_t k = 0; k < item->count; k++)
        memcpy((unsigned char *)item->data + size * COLUMN_AT(item->columns, k),
               (const unsigned char *)values + size * k, size);
}

void checkpoint_item_read(const struct checkpoint_item *item)
{
    if (item->list)
        contact_list_read_column(item->list, item->column);
}

void checkpoint_item_forget(const struct checkpoint_item *item)
{
    if (item->list)
        contact_list_forget_column(item->list, item->column);
}

struct checkpoint_items *checkpoint_items_of(struct sample *sample, struct run_progress *progress)
{
    struct checkpoint_items *items = malloc(sizeof *items);
    if (items)
        collect(items, sample, progress);
    return items;
}
