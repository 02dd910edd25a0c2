#include "sim/run/records.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "shakedown_checkpoint_t.h"
#include "shakedown_end_t.h"
#include "shakedown_frame_contacts_t.h"
#include "shakedown_frame_particles_t.h"
#include "shakedown_note_t.h"
#include "shakedown_particles_t.h"
#include "shakedown_run_info_t.h"
#include "shakedown_sample_t.h"
#include "sim/grains/particle_order.h"
#include "sim/measure/measure.h"

/* Chunks stay below this, headers included: one message is at most BUS_MESSAGE_MAX. */
enum { CHUNK_BYTES = 55000, PARTICLES_PER_CHUNK = CHUNK_BYTES / (2 * (int)sizeof(double)) };

/* Encodes `message` of type shakedown_<type> with the next seq of the channel and hands it to the stream. */
#define SEND(records, sample, channel, type, message)                                                                  \
    do {                                                                                                               \
        static uint8_t buffer_[BUS_MESSAGE_MAX];                                                                       \
        (message)->run_id = (records)->run_id;                                                                         \
        (message)->seq = record_sender_next_seq((records)->stream, channel);                                           \
        (message)->step = (sample)->step;                                                                              \
        (message)->time_s = (sample)->time_s;                                                                          \
        int size_ = shakedown_##type##_encode(buffer_, 0, sizeof buffer_, message);                                    \
        if (size_ < 0)                                                                                                 \
            return status_fail(STATUS_LIMIT, #type ": the message is larger than %d bytes", BUS_MESSAGE_MAX);          \
        return record_sender_publish((records)->stream, channel, buffer_, (size_t)size_);                              \
    } while (0)

void records_init(struct records *records, struct record_sender *stream, int64_t run_id)
{
    *records = (struct records){.stream = stream, .run_id = run_id, .last_sample_step = -1, .last_frame_step = -1};
}

/* The fields of the contacts' history that frames hold. */
struct history_fields {
    int n, values; /* fields; values of a contact */
    int column[HISTORY_FIELDS_MAX];
    char *name[HISTORY_FIELDS_MAX], *unit[HISTORY_FIELDS_MAX];
    int8_t kind[HISTORY_FIELDS_MAX];
};

static void history_fields_find(const struct sample *sample, struct history_fields *fields)
{
    const struct contact_model *model = &sample->pairs.model;
    *fields = (struct history_fields){0};
    fields->n = sample->scene->record.contact_history ? history_shown(model, fields->column) : 0;
    for (int f = 0; f < fields->n; f++) {
        const struct history_field *field = history_field(fields->column[f]);
        fields->name[f] = (char *)field->name;
        fields->unit[f] = (char *)field->unit;
        fields->kind[f] = (int8_t)field->kind;
        fields->values += history_kind_values(field->kind, model->dimension);
    }
}

static enum status send_run_info(struct records *records, const struct sample *sample, const char *controller,
                                 const struct records_resumed *resumed, char *effective)
{
    char kernel_set[64];
    sample_kernel_set(sample, kernel_set, sizeof kernel_set);
    const struct scene *scene = sample->scene;
    struct history_fields history;
    history_fields_find(sample, &history);
    shakedown_run_info_t message = {
        .name = (char *)scene->name,
        .version = SHAKEDOWN_VERSION,
        .kernel_set = kernel_set,
        .scene_text = scene->text,
        .effective_config = effective,
        .controller = controller ? (char *)(uintptr_t)controller : "",
        .seed = scene->seed,
        .dimension = (int32_t)scene->dimension,
        .n_particles = sample->particles.count,
        .n_stages = (int32_t)scene->n_stages,
        .frictional = sample->pairs.model.frictional,
        .hysteretic = history_has(&sample->pairs.model, HISTORY_MAX_OVERLAP),
        .n_history = history.n,
        .history_name = history.name,
        .history_unit = history.unit,
        .history_kind = history.kind,
    };
    if (resumed) {
        message.n_resumed = RECORD_CHANNELS;
        message.resumed_total = (int64_t *)(uintptr_t)resumed->total;
        message.resumed_frames = resumed->frames;
        message.resumed_wall_states = resumed->wall_states;
    }
    SEND(records, sample, RECORD_RUN_INFO, run_info_t, &message);
}

static enum status send_particles_chunk(struct records *records, const struct sample *sample, int chunk, int n_chunks,
                                        int first, int count)
{
    static double radius[PARTICLES_PER_CHUNK], mass[PARTICLES_PER_CHUNK];
    particles_gather_by_id(&sample->particles, sample->particles.radius, first, count, radius);
    particles_gather_by_id(&sample->particles, sample->particles.mass, first, count, mass);
    shakedown_particles_t message = {
        .chunk = chunk,
        .n_chunks = n_chunks,
        .first = first,
        .count = count,
        .radius_m = radius,
        .mass_kg = mass,
    };
    SEND(records, sample, RECORD_PARTICLES, particles_t, &message);
}

static int chunks_of(int count, int per_chunk)
{
    return count > 0 ? (count + per_chunk - 1) / per_chunk : 1;
}

static int at_most(int a, int b)
{
    return a < b ? a : b;
}

enum status records_send_start(struct records *records, const struct sample *sample, const char *controller,
                               const struct records_resumed *resumed)
{
    char *effective = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&effective, &size);
    if (!out)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    scene_print(out, sample->scene);
    enum status status = STATUS_NO_MEMORY;
    if (fclose(out) == 0)
        status = send_run_info(records, sample, controller, resumed, effective);
    free(effective);
    const int per_chunk = PARTICLES_PER_CHUNK, count = sample->particles.count;
    const int n_chunks = chunks_of(count, per_chunk);
    for (int k = 0; status == STATUS_OK && k < n_chunks; k++)
        status = send_particles_chunk(records, sample, k, n_chunks, k * per_chunk,
                                      at_most(per_chunk, count - k * per_chunk));
    return status;
}

enum status records_send_checkpoint(struct records *records, const struct sample *sample, int64_t wall_states)
{
    int64_t total[RECORD_CHANNELS], hash[RECORD_CHANNELS];
    for (int c = 0; c < RECORD_CHANNELS; c++) {
        total[c] = record_sender_total(records->stream, c);
        hash[c] = record_sender_hash(records->stream, c);
    }
    shakedown_checkpoint_t message = {.n_channels = RECORD_CHANNELS,
                                      .total = total,
                                      .hash = hash,
                                      .n_frames = records->n_frames,
                                      .wall_states = wall_states};
    SEND(records, sample, RECORD_CHECKPOINT, checkpoint_t, &message);
}

enum status records_send_note(struct records *records, const struct sample *sample, enum note_severity severity,
                              const char *text)
{
    shakedown_note_t message = {.stage = sample->stage,
                                .stage_name =
                                    (char *)(sample->stage < 0 ? "" : sample->scene->stage[sample->stage].name),
                                .severity = (int8_t)severity,
                                .text = (char *)text};
    SEND(records, sample, RECORD_NOTE, note_t, &message);
}

static void fill_ledger(shakedown_sample_t *message, const struct sample *sample, const struct measurement *m)
{
    message->kinetic_energy_j = m->kinetic_j;
    message->elastic_energy_normal_j = m->elastic_normal_j;
    message->elastic_energy_tangential_j = m->elastic_tangential_j;
    message->work_walls_j = sample->ledger.work_walls;
    message->work_gravity_j = m->work_gravity_j;
    message->work_material_j = sample->ledger.work_material;
    message->dissipated_hysteresis_j = sample->ledger.contacts.hysteresis;
    message->dissipated_viscous_normal_j = sample->ledger.contacts.viscous_normal;
    message->dissipated_viscous_tangential_j = sample->ledger.contacts.viscous_tangential;
    message->dissipated_friction_j = sample->ledger.contacts.friction;
    message->dissipated_stiffness_j = sample->ledger.contacts.stiffness;
    message->dissipated_rolling_j = sample->ledger.contacts.rolling;
    message->dissipated_viscous_rolling_j = sample->ledger.contacts.viscous_rolling;
    message->dissipated_background_j = sample->ledger.background;
    message->energy_residual_j = m->residual_j;
}

static enum status send_sample(struct records *records, const struct sample *sample, struct measurement *m)
{
    double x[SCENE_WALLS_MAX], v[SCENE_WALLS_MAX], force[SCENE_WALLS_MAX];
    for (int w = 0; w < sample->n_walls; w++) {
        x[w] = sample->walls[w].x;
        v[w] = sample->walls[w].v;
        force[w] = sample->walls[w].force;
    }
    const int dim = sample->particles.dimension;
    shakedown_sample_t message = {
        .stage = sample->stage,
        .stage_end_before = sample->stage_step == 0 ? records->stage_end : 0,
        .stage_time_s = (double)sample->stage_step * sample->dt,
        .dimension = dim,
        .box_length_m = m->box_length_m,
        .strain = m->strain,
        .stress_wall_pa = m->stress_wall_pa,
        .n_stress = dim * dim,
        .stress_contact_pa = m->stress_contact_pa,
        .fabric = m->fabric,
        .n_walls = sample->n_walls,
        .wall_position_m = x,
        .wall_velocity_m_per_s = v,
        .wall_force_n = force,
        .solid_fraction = m->solid_fraction,
        .coordination = m->coordination,
        .coordination_no_rattlers = m->coordination_no_rattlers,
        .rattler_fraction = m->rattler_fraction,
        .n_contacts = m->n_contacts,
        .n_wall_contacts = m->n_wall_contacts,
        .sliding_fraction = m->sliding_fraction,
        .max_overlap_ratio = m->max_overlap_ratio,
        .inertial_number = m->inertial_number,
        .interface_residual_j = sample->audit.residual_j,
        .controller_residual_j = sample->audit.controller_residual_j,
    };
    fill_ledger(&message, sample, m);
    SEND(records, sample, RECORD_SAMPLE, sample_t, &message);
}

enum status records_send_sample(struct records *records, const struct sample *sample, struct measurement *m)
{
    double work_j = fabs(sample->ledger.work_walls) + fabs(m->work_gravity_j);
    records->residual_ratio = work_j > 0 ? m->residual_j / work_j : 0;
    records->last_sample_step = sample->step;
    return send_sample(records, sample, m);
}

/* Row-major copy of the `n` components of particles [first, first + count), in the order of ids. */
static void interleave(const struct particles *p, double *const *component, int n, int first, int count, double *out)
{
    for (int i = 0; i < count; i++)
        for (int c = 0; c < n; c++)
            out[i * n + c] = component[c][p->slot[first + i]];
}

struct chunk {
    int index, n, first, count;
};

static enum status send_frame_particles(struct records *records, const struct sample *sample, const struct chunk *chunk,
                                        double *scratch)
{
    const struct particles *p = &sample->particles;
    const int dim = p->dimension;
    double lo[3], hi[3];
    double *v = scratch + chunk->count * dim, *omega = v + chunk->count * dim;
    interleave(p, p->x, dim, chunk->first, chunk->count, scratch);
    interleave(p, p->v, dim, chunk->first, chunk->count, v);
    interleave(p, p->omega, p->n_rotations, chunk->first, chunk->count, omega);
    /* in 2D the particles turn about x cross z = -y: report about +y */
    for (int k = 0; dim == 2 && k < chunk->count * p->n_rotations; k++)
        omega[k] = -omega[k];
    for (int c = 0; c < dim; c++) {
        lo[c] = sample->walls[2 * c].x;
        hi[c] = sample->walls[2 * c + 1].x;
    }
    shakedown_frame_particles_t message = {
        .frame = records->n_frames,
        .chunk = chunk->index,
        .n_chunks = chunk->n,
        .stage = sample->stage,
        .dimension = dim,
        .box_lo_m = lo,
        .box_hi_m = hi,
        .first = chunk->first,
        .count = chunk->count,
        .n_values = chunk->count * dim,
        .position_m = scratch,
        .velocity_m_per_s = v,
        .n_angular = chunk->count * p->n_rotations,
        .angular_velocity_rad_per_s = omega,
    };
    SEND(records, sample, RECORD_FRAME_PARTICLES, frame_particles_t, &message);
}

/* Columns of a chunk of contacts. */
struct contact_columns {
    int32_t *i, *j;
    double *overlap, *normal_force, *normal, *tangential;
    int8_t *sliding;
};

static void fill_columns(const struct contact_measurement *contacts, int count, int dim, struct contact_columns *to)
{
    for (int k = 0; k < count; k++) {
        to->i[k] = contacts[k].i;
        to->j[k] = contacts[k].j;
        to->overlap[k] = contacts[k].overlap_m;
        to->normal_force[k] = contacts[k].normal_force_n;
        to->sliding[k] = contacts[k].sliding;
        for (int c = 0; c < dim; c++) {
            to->normal[k * dim + c] = contacts[k].normal[c];
            to->tangential[k * dim + c] = contacts[k].tangential_force_n[c];
        }
    }
}

/* Field by field, contact by contact; returns the number of values. */
static int fill_history(const struct sample *sample, const struct contact_measurement *contacts, int count,
                        double *value)
{
    struct history_fields fields;
    int n = 0;
    history_fields_find(sample, &fields);
    for (int f = 0; f < fields.n; f++)
        for (int k = 0; k < count; k++)
            n += measure_contact_history(sample, &contacts[k], fields.column[f], &value[n]);
    return n;
}

static enum status send_frame_contacts(struct records *records, const struct sample *sample, const struct chunk *chunk,
                                       const struct contact_measurement *contacts)
{
    enum { MAX = CHUNK_BYTES / 40 };
    static int32_t i[MAX], j[MAX];
    static double overlap[MAX], normal_force[MAX], normal[3 * MAX], tangential[3 * MAX];
    static double history[CHUNK_BYTES / sizeof(double)];
    static int8_t sliding[MAX];
    const int dim = sample->particles.dimension, frictional = sample->pairs.model.frictional;
    struct contact_columns columns = {i, j, overlap, normal_force, normal, tangential, sliding};
    fill_columns(contacts + chunk->first, chunk->count, dim, &columns);
    shakedown_frame_contacts_t message = {
        .frame = records->n_frames,
        .chunk = chunk->index,
        .n_chunks = chunk->n,
        .dimension = dim,
        .count = chunk->count,
        .i = i,
        .j = j,
        .overlap_m = overlap,
        .normal_force_n = normal_force,
        .n_values = chunk->count * dim,
        .normal = normal,
        .n_tangential = frictional ? chunk->count * dim : 0,
        .tangential_force_n = tangential,
        .n_sliding = frictional ? chunk->count : 0,
        .sliding = sliding,
        .n_history = fill_history(sample, contacts + chunk->first, chunk->count, history),
        .history = history,
    };
    SEND(records, sample, RECORD_FRAME_CONTACTS, frame_contacts_t, &message);
}

static enum status send_particle_frames(struct records *records, const struct sample *sample)
{
    const struct particles *p = &sample->particles;
    const int values = 2 * p->dimension + p->n_rotations;
    const int per_chunk = CHUNK_BYTES / (values * (int)sizeof(double));
    double *scratch = malloc((size_t)per_chunk * (size_t)values * sizeof *scratch);
    if (!scratch)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    struct chunk chunk = {.n = chunks_of(p->count, per_chunk)};
    enum status status = STATUS_OK;
    for (; status == STATUS_OK && chunk.index < chunk.n; chunk.index++) {
        chunk.first = chunk.index * per_chunk;
        chunk.count = at_most(per_chunk, p->count - chunk.first);
        status = send_frame_particles(records, sample, &chunk, scratch);
    }
    free(scratch);
    return status;
}

static enum status send_contact_frames(struct records *records, struct complete_sample whole)
{
    const struct sample *sample = whole.sample;
    const int dim = sample->particles.dimension, frictional = sample->pairs.model.frictional;
    struct history_fields history;
    history_fields_find(sample, &history);
    const int per_contact = 24 + 8 * (dim + history.values) + (frictional ? 8 * dim + 1 : 0);
    const int per_chunk = CHUNK_BYTES / per_contact;
    int count = measure_contacts(whole, NULL);
    struct contact_measurement *contacts = malloc((size_t)(count + 1) * sizeof *contacts);
    if (!contacts)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    measure_contacts(whole, contacts);
    struct chunk chunk = {.n = chunks_of(count, per_chunk)};
    enum status status = STATUS_OK;
    for (; status == STATUS_OK && chunk.index < chunk.n; chunk.index++) {
        chunk.first = chunk.index * per_chunk;
        chunk.count = at_most(per_chunk, count - chunk.first);
        status = send_frame_contacts(records, sample, &chunk, contacts);
    }
    free(contacts);
    return status;
}

enum status records_send_frame(struct records *records, struct complete_sample whole)
{
    TRY(send_particle_frames(records, whole.sample));
    TRY(send_contact_frames(records, whole));
    records->last_frame_step = whole.sample->step;
    records->n_frames++;
    return STATUS_OK;
}

enum status records_send_end(struct records *records, struct complete_sample whole, enum status why,
                             const struct run_totals *totals)
{
    int64_t total[RECORD_CHANNELS], hash[RECORD_CHANNELS];
    for (int c = 0; c < RECORD_CHANNELS; c++) {
        total[c] = record_sender_total(records->stream, c) + (c == RECORD_END);
        hash[c] = record_sender_hash(records->stream, c);
    }
    shakedown_end_t message = {
        .status = why,
        .reason = (char *)(why == STATUS_OK ? "" : status_message()),
        .state_hash = (int64_t)sample_hash(whole),
        .stage_end = why == STATUS_OK ? records->stage_end : 0,
        .elapsed_s = totals->elapsed_s,
        .n_channels = RECORD_CHANNELS,
        .channel = (char **)record_channel_name,
        .total = total,
        .hash = hash,
        .wall_states = totals->wall_states,
        .wall_commands = totals->wall_commands,
        .commands_repeated = totals->commands_repeated,
        .records_repeated = record_sender_repeated(records->stream),
    };
    SEND(records, whole.sample, RECORD_END, end_t, &message);
}
