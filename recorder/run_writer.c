#include "recorder/run_writer.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "recorder/frame_observables.h"
#include "recorder/h5.h"
#include "recorder/message_table.h"

/* Wall rows come at up to 20 kHz: compressed fast, in whole chunks. Sample rows are few and are wanted after a kill. */
enum { SAMPLE_BLOCK = 256, WALL_BLOCK = 1024, CONTACT_BLOCK = 4096, FRAME_BLOCK = 64 };
enum { NOTE_BLOCK = 8, NOTE_BYTES = 512 };
enum { WALL_DEFLATE = 1, FRAME_DEFLATE = 4, FRAME_CHUNK_PARTICLES = 16384 };

#define TRAJECTORY  "/particles/trajectory"
#define OBSERVABLES "/observables"
#define SAMPLES     "/samples"
#define CONTACTS    "/connectivity/contacts"

/* Series other than tables, with one row per frame or per contact. */
enum series_id {
    SERIES_STEP,
    SERIES_TIME,
    SERIES_STAGE,
    SERIES_EDGES,
    SERIES_ORIGIN,
    SERIES_POSITION,
    SERIES_VELOCITY,
    SERIES_ANGULAR_VELOCITY,
    SERIES_CONTACT_STEP,
    SERIES_CONTACT_TIME,
    SERIES_CONTACT_OFFSET,
    SERIES_CONTACT_PAIR,
    SERIES_CONTACT_OVERLAP,
    SERIES_CONTACT_NORMAL_FORCE,
    SERIES_CONTACT_NORMAL,
    SERIES_CONTACT_TANGENTIAL_FORCE,
    SERIES_CONTACT_SLIDING,
    N_SERIES
};

enum series_type { TYPE_I8, TYPE_I32, TYPE_I64, TYPE_F64 };
enum series_shape { PER_FRAME, PER_FRAME_MATRIX /* [F][3][3] */, PER_PARTICLE /* [F][N][3] */, PER_CONTACT };

static const struct {
    const char *path;
    const char *unit;
    enum series_type type;
    enum series_shape shape;
    hsize_t width; /* 0: [F] or [C], else [F][width] or [C][width] */
    bool only_with_friction;
} series_table[N_SERIES] = {
    [SERIES_STEP] = {TRAJECTORY "/position/step", "1", TYPE_I64, PER_FRAME, 0, false},
    [SERIES_TIME] = {TRAJECTORY "/position/time", "s", TYPE_F64, PER_FRAME, 0, false},
    [SERIES_STAGE] = {"/frames/stage", "1", TYPE_I32, PER_FRAME, 0, false},
    [SERIES_EDGES] = {TRAJECTORY "/box/edges/value", "m", TYPE_F64, PER_FRAME_MATRIX, 3, false},
    [SERIES_ORIGIN] = {"/frames/box_lo", "m", TYPE_F64, PER_FRAME, 3, false},
    [SERIES_POSITION] = {TRAJECTORY "/position/value", "m", TYPE_F64, PER_PARTICLE, 3, false},
    [SERIES_VELOCITY] = {TRAJECTORY "/velocity/value", "m/s", TYPE_F64, PER_PARTICLE, 3, false},
    [SERIES_ANGULAR_VELOCITY] = {TRAJECTORY "/angular_velocity/value", "rad/s", TYPE_F64, PER_PARTICLE, 3, true},
    [SERIES_CONTACT_STEP] = {CONTACTS "/step", "1", TYPE_I64, PER_FRAME, 0, false},
    [SERIES_CONTACT_TIME] = {CONTACTS "/time", "s", TYPE_F64, PER_FRAME, 0, false},
    [SERIES_CONTACT_OFFSET] = {CONTACTS "/offset", "1", TYPE_I64, PER_FRAME, 0, false},
    [SERIES_CONTACT_PAIR] = {CONTACTS "/pair", "1", TYPE_I32, PER_CONTACT, 2, false},
    [SERIES_CONTACT_OVERLAP] = {CONTACTS "/overlap", "m", TYPE_F64, PER_CONTACT, 0, false},
    [SERIES_CONTACT_NORMAL_FORCE] = {CONTACTS "/normal_force", "N", TYPE_F64, PER_CONTACT, 0, false},
    [SERIES_CONTACT_NORMAL] = {CONTACTS "/normal", "1", TYPE_F64, PER_CONTACT, 3, false},
    [SERIES_CONTACT_TANGENTIAL_FORCE] = {CONTACTS "/tangential_force", "N", TYPE_F64, PER_CONTACT, 3, true},
    [SERIES_CONTACT_SLIDING] = {CONTACTS "/sliding", "1", TYPE_I8, PER_CONTACT, 0, true},
};

/* Second names: H5MD wants step and time beside every value. */
static const struct {
    const char *target, *name;
    bool only_with_friction;
} frame_links[] = {
    {TRAJECTORY "/position/step", TRAJECTORY "/velocity/step", false},
    {TRAJECTORY "/position/time", TRAJECTORY "/velocity/time", false},
    {TRAJECTORY "/position/step", TRAJECTORY "/box/edges/step", false},
    {TRAJECTORY "/position/time", TRAJECTORY "/box/edges/time", false},
    {TRAJECTORY "/position/step", "/frames/step", false},
    {TRAJECTORY "/position/time", "/frames/time", false},
    {TRAJECTORY "/position/step", TRAJECTORY "/angular_velocity/step", true},
    {TRAJECTORY "/position/time", TRAJECTORY "/angular_velocity/time", true},
};

struct run_writer {
    hid_t file;
    bool has_particles;
    struct run_facts facts;
    double radius_max_m;
    struct h5_series series[N_SERIES];
    struct h5_series history[HISTORY_FIELDS_MAX]; /* of contacts */
    struct message_table *samples;
    struct message_table *observables; /* of the samples, those at the frames */
    struct frame_observables observed;
    struct message_table *wall_states, *wall_commands; /* NULL: not recorded */
    int64_t contacts;
    struct h5_series notes;
    hid_t note_type; /* its texts */
};

static hid_t series_memory_type(enum series_type type)
{
    const hid_t types[] = {[TYPE_I8] = H5T_NATIVE_INT8,
                           [TYPE_I32] = H5T_NATIVE_INT32,
                           [TYPE_I64] = H5T_NATIVE_INT64,
                           [TYPE_F64] = H5T_NATIVE_DOUBLE};
    return types[type];
}

static enum status series_create(struct run_writer *writer, enum series_id id)
{
    hsize_t n = (hsize_t)writer->facts.n_particles, width = series_table[id].width;
    hsize_t row[H5_RANK_MAX - 1] = {width};
    struct h5_layout layout = {.chunk = {FRAME_BLOCK, width}};
    int rank = width > 0 ? 2 : 1;
    if (series_table[id].shape == PER_CONTACT)
        layout.chunk[0] = CONTACT_BLOCK;
    if (series_table[id].shape == PER_FRAME_MATRIX) {
        rank = 3;
        row[1] = 3;
        layout.chunk[2] = 3;
    }
    if (series_table[id].shape == PER_PARTICLE) {
        rank = 3;
        row[0] = n;
        row[1] = 3;
        hsize_t particles = n < FRAME_CHUNK_PARTICLES ? n : FRAME_CHUNK_PARTICLES;
        layout = (struct h5_layout){.chunk = {1, particles, 3}, .deflate = FRAME_DEFLATE};
    }
    return h5_series_create(writer->file, series_table[id].path, series_memory_type(series_table[id].type), rank, row,
                            &layout, series_table[id].unit, &writer->series[id]);
}

/* A dataset for each field of the contacts' history. */
static enum status history_create(struct run_writer *writer)
{
    for (int k = 0; k < writer->facts.n_history; k++) {
        const struct contact_field *column = &writer->facts.history[k];
        const hsize_t width = (hsize_t)history_width(column);
        const struct h5_layout layout = {.chunk = {CONTACT_BLOCK, width}};
        char path[sizeof CONTACTS "/history/" + HISTORY_NAME_MAX];
        snprintf(path, sizeof path, CONTACTS "/history/%s", column->name);
        TRY(h5_series_create(writer->file, path, H5T_NATIVE_DOUBLE, width > 1 ? 2 : 1, &width, &layout, column->unit,
                             &writer->history[k]));
    }
    return STATUS_OK;
}

static enum status frames_create(struct run_writer *writer)
{
    const int64_t zero = 0;
    bool frictional = writer->facts.frictional;
    for (int id = 0; id < N_SERIES; id++) {
        if (frictional || !series_table[id].only_with_friction)
            TRY(series_create(writer, (enum series_id)id));
    }
    for (size_t k = 0; k < sizeof frame_links / sizeof *frame_links; k++) {
        if (frictional || !frame_links[k].only_with_friction)
            TRY(h5_link(writer->file, frame_links[k].target, frame_links[k].name));
    }
    TRY(history_create(writer));
    return h5_series_append(&writer->series[SERIES_CONTACT_OFFSET], 1, &zero);
}

static enum status box_create(hid_t file)
{
    static const char *const boundary[] = {"none", "none", "none"};
    const int32_t dimension = 3;
    TRY(h5_attribute_numbers(file, TRAJECTORY "/box", "dimension", H5T_NATIVE_INT32, 0, &dimension));
    return h5_attribute_texts(file, TRAJECTORY "/box", "boundary", boundary, 3);
}

static enum status h5md_create(hid_t file)
{
    const int32_t version[] = {1, 1};
    const char *user = getenv("USER");
    TRY(h5_group_create(file, "/h5md/author"));
    TRY(h5_group_create(file, "/h5md/creator"));
    TRY(h5_attribute_numbers(file, "/h5md", "version", H5T_NATIVE_INT32, 2, version));
    TRY(h5_attribute_text(file, "/h5md/author", "name", user ? user : "unknown"));
    TRY(h5_attribute_text(file, "/h5md/creator", "name", "shakedown"));
    return h5_attribute_text(file, "/h5md/creator", "version", SHAKEDOWN_VERSION);
}

static enum status parameters_write(hid_t file, const shakedown_run_info_t *info)
{
    const struct {
        const char *name, *text;
    } texts[] = {{"name", info->name},
                 {"version", info->version},
                 {"kernel_set", info->kernel_set},
                 {"controller", info->controller},
                 {"scene_text", info->scene_text},
                 {"effective_config", info->effective_config}};
    const struct {
        const char *name;
        int64_t value;
    } numbers[] = {{"run_id", info->run_id},           {"seed", info->seed},         {"dimension", info->dimension},
                   {"n_particles", info->n_particles}, {"n_stages", info->n_stages}, {"frictional", info->frictional},
                   {"hysteretic", info->hysteretic}};
    TRY(h5_group_create(file, "/parameters"));
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++)
        TRY(h5_attribute_text(file, "/parameters", texts[k].name, texts[k].text));
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++)
        TRY(h5_attribute_numbers(file, "/parameters", numbers[k].name, H5T_NATIVE_INT64, 0, &numbers[k].value));
    return STATUS_OK;
}

/* What a user must know also as datasets, for readers without attributes (Octave). */
static enum status complete_write(hid_t file, int32_t complete)
{
    TRY(h5_vector_write(file, "/run/complete", H5T_NATIVE_INT32, 0, &complete, "1"));
    return h5_attribute_numbers(file, "/", "complete", H5T_NATIVE_INT32, 0, &complete);
}

static enum status run_create(hid_t file, const shakedown_run_info_t *info)
{
    const int32_t unknown = -1;
    TRY(h5_vector_write(file, "/run/status", H5T_NATIVE_INT32, 0, &unknown, "1"));
    TRY(h5_vector_write(file, "/run/seed", H5T_NATIVE_INT64, 0, &info->seed, "1"));
    TRY(h5_text_write(file, "/run/name", info->name));
    TRY(h5_text_write(file, "/run/scene_text", info->scene_text));
    return h5_text_write(file, "/run/effective_config", info->effective_config);
}

/* A group per field; step and time are those of the stage, and have a second name in every group. */
static void sample_path_in(const char *root, const char *field_name, char path[TABLE_PATH_MAX])
{
    if (strcmp(field_name, "step") == 0)
        snprintf(path, TABLE_PATH_MAX, "%s/stage/step", root);
    else if (strcmp(field_name, "time_s") == 0)
        snprintf(path, TABLE_PATH_MAX, "%s/stage/time", root);
    else
        snprintf(path, TABLE_PATH_MAX, "%s/%s/value", root, field_name);
}

static void sample_path(const char *field_name, char path[TABLE_PATH_MAX])
{
    sample_path_in(SAMPLES, field_name, path);
}

static void observable_path(const char *field_name, char path[TABLE_PATH_MAX])
{
    sample_path_in(OBSERVABLES, field_name, path);
}

static void wall_state_path(const char *field_name, char path[TABLE_PATH_MAX])
{
    snprintf(path, TABLE_PATH_MAX, "/walls/state/%s", field_name);
}

static void wall_command_path(const char *field_name, char path[TABLE_PATH_MAX])
{
    snprintf(path, TABLE_PATH_MAX, "/walls/command/%s", field_name);
}

static enum status sample_links_create(hid_t file, const char *root, const char *field_name)
{
    char path[TABLE_PATH_MAX], target[TABLE_PATH_MAX];
    sample_path_in(root, "step", target);
    snprintf(path, sizeof path, "%s/%s/step", root, field_name);
    TRY(h5_link(file, target, path));
    sample_path_in(root, "time_s", target);
    snprintf(path, sizeof path, "%s/%s/time", root, field_name);
    return h5_link(file, target, path);
}

static enum status samples_links_create(hid_t file, const char *root)
{
    for (const struct field *field = sample_fields; field->name; field++) {
        bool is_own =
            strcmp(field->name, "step") == 0 || strcmp(field->name, "time_s") == 0 || strcmp(field->name, "stage") == 0;
        if (!is_own)
            TRY(sample_links_create(file, root, field->name));
    }
    return STATUS_OK;
}

static enum status samples_create(struct run_writer *writer)
{
    struct message_table_options options = {
        .fields = sample_fields, .dimension = writer->facts.dimension, .block = SAMPLE_BLOCK, .path = sample_path};
    TRY(message_table_create(&writer->samples, writer->file, &options));
    TRY(samples_links_create(writer->file, SAMPLES));
    options.path = observable_path;
    options.block = FRAME_BLOCK;
    TRY(message_table_create(&writer->observables, writer->file, &options));
    return samples_links_create(writer->file, OBSERVABLES);
}

static struct message_table_options walls_options(const struct run_writer *writer, bool commands)
{
    return (struct message_table_options){.fields = commands ? wall_command_fields : wall_state_fields,
                                          .dimension = writer->facts.dimension,
                                          .block = WALL_BLOCK,
                                          .deflate = WALL_DEFLATE,
                                          .path = commands ? wall_command_path : wall_state_path};
}

static enum status walls_create(struct run_writer *writer)
{
    struct message_table_options options = walls_options(writer, false);
    TRY(message_table_create(&writer->wall_states, writer->file, &options));
    options = walls_options(writer, true);
    return message_table_create(&writer->wall_commands, writer->file, &options);
}

/* A text of NOTE_BYTES, ended by a zero; to be closed. */
static enum status note_type(hid_t *type)
{
    *type = H5Tcopy(H5T_C_S1);
    if (*type < 0 || H5Tset_size(*type, NOTE_BYTES) < 0 || H5Tset_cset(*type, H5T_CSET_UTF8) < 0)
        return status_fail(STATUS_NO_MEMORY, "no type for notes");
    return STATUS_OK;
}

static enum status notes_create(struct run_writer *writer)
{
    const struct h5_layout layout = {.chunk = {NOTE_BLOCK}};
    TRY(note_type(&writer->note_type));
    return h5_series_create(writer->file, "/notes", writer->note_type, 1, NULL, &layout, "1", &writer->notes);
}

static enum status contents_create(struct run_writer *writer, const shakedown_run_info_t *info, bool walls)
{
    TRY(h5md_create(writer->file));
    TRY(parameters_write(writer->file, info));
    TRY(complete_write(writer->file, 0));
    TRY(run_create(writer->file, info));
    TRY(frames_create(writer));
    TRY(box_create(writer->file));
    TRY(samples_create(writer));
    TRY(notes_create(writer));
    if (walls)
        TRY(walls_create(writer));
    return h5_file_flush(writer->file);
}

/* A writer without a file. */
static enum status writer_new(struct run_writer **result, const shakedown_run_info_t *info)
{
    struct run_writer *writer = *result = calloc(1, sizeof *writer);
    if (!writer)
        return status_fail(STATUS_NO_MEMORY, "no memory for the writer");
    writer->file = H5I_INVALID_HID;
    writer->facts = run_facts_of(info);
    for (int id = 0; id < N_SERIES; id++)
        writer->series[id].id = H5I_INVALID_HID;
    for (int k = 0; k < HISTORY_FIELDS_MAX; k++)
        writer->history[k].id = H5I_INVALID_HID;
    writer->notes.id = writer->note_type = H5I_INVALID_HID;
    return STATUS_OK;
}

enum status run_writer_create(struct run_writer **result, const char *path, const shakedown_run_info_t *info,
                              bool walls)
{
    TRY(writer_new(result, info));
    TRY(h5_file_create(path, &(*result)->file));
    return contents_create(*result, info, walls);
}

static enum status particles_write(struct run_writer *writer, const struct particle_set *set, int32_t *ids)
{
    hsize_t n = (hsize_t)writer->facts.n_particles;
    for (int32_t k = 0; k < writer->facts.n_particles; k++)
        ids[k] = k;
    TRY(h5_vector_write(writer->file, TRAJECTORY "/radius", H5T_NATIVE_DOUBLE, n, set->radius_m, "m"));
    TRY(h5_vector_write(writer->file, TRAJECTORY "/mass", H5T_NATIVE_DOUBLE, n, set->mass_kg, "kg"));
    return h5_vector_write(writer->file, TRAJECTORY "/id", H5T_NATIVE_INT32, n, ids, "1");
}

enum status run_writer_particles(struct run_writer *writer, const struct particle_set *set)
{
    if (writer->has_particles)
        return STATUS_OK;
    int32_t *ids = malloc((size_t)writer->facts.n_particles * sizeof *ids);
    if (!ids)
        return status_fail(STATUS_NO_MEMORY, "no memory for %d ids", writer->facts.n_particles);
    writer->radius_max_m = set->radius_max_m;
    writer->has_particles = true;
    enum status status = particles_write(writer, set, ids);
    free(ids);
    return status;
}

enum status run_writer_sample(struct run_writer *writer, const shakedown_sample_t *sample)
{
    TRY(frame_observables_sample(&writer->observed, (struct moment){sample->step, sample->stage}));
    return message_table_append(writer->samples, sample);
}

enum status run_writer_wall_state(struct run_writer *writer, const shakedown_wall_state_t *state)
{
    return message_table_append(writer->wall_states, state);
}

enum status run_writer_wall_command(struct run_writer *writer, const shakedown_wall_command_t *command)
{
    return message_table_append(writer->wall_commands, command);
}

/* "stage;severity;text"; a semicolon in the name of a stage becomes a comma. */
enum status run_writer_note(struct run_writer *writer, const shakedown_note_t *message)
{
    static const char *const severities[NOTE_SEVERITIES] = {"note", "doubtful", "failed"};
    char text[NOTE_BYTES] = "", stage[NOTE_BYTES] = "";
    snprintf(stage, sizeof stage, "%s", message->stage_name);
    for (char *sign = strchr(stage, ';'); sign; sign = strchr(sign, ';'))
        *sign = ',';
    snprintf(text, sizeof text, "%.200s;%s;%s", stage, severities[message->severity], message->text);
    return h5_series_append(&writer->notes, 1, text);
}

/* One row to each series; data NULL: that series is not in this run. Ends at N_SERIES. */
struct row {
    enum series_id id;
    const void *data;
};

static enum status rows_append(struct run_writer *writer, const struct row *rows, hsize_t count)
{
    for (; rows->id != N_SERIES; rows++) {
        if (writer->series[rows->id].id >= 0)
            TRY(h5_series_append(&writer->series[rows->id], count, rows->data));
    }
    return STATUS_OK;
}

/* For ParaView, which reads no slices: the parts of the last frame under names of their own. */
static enum status frame_link(struct run_writer *writer)
{
    static const struct {
        enum series_id id;
        const char *name;
    } parts[] = {
        {SERIES_POSITION, "position"}, {SERIES_VELOCITY, "velocity"}, {SERIES_ANGULAR_VELOCITY, "angular_velocity"}};
    const hsize_t row = writer->series[SERIES_STEP].rows - 1;
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++) {
        char path[64];
        const enum series_id id = parts[k].id;
        if (writer->series[id].id < 0)
            continue;
        snprintf(path, sizeof path, "/xdmf/%llu/%s", (unsigned long long)row, parts[k].name);
        TRY(h5_series_row_link(writer->file, &writer->series[id], series_table[id].path, row, path));
    }
    return STATUS_OK;
}

enum status run_writer_particle_frame(struct run_writer *writer, const struct particle_frame *frame)
{
    double lo_m[3], edges_m[3][3] = {{0}}; /* a triclinic box, as some readers take a vector of lengths for no box */
    for (int axis = 0; axis < 3; axis++) {
        lo_m[axis] = frame->box_lo_m[axis];
        edges_m[axis][axis] = frame->box_hi_m[axis] - frame->box_lo_m[axis];
    }
    if (writer->facts.dimension == 2) { /* one layer of discs seen as spheres */
        lo_m[1] = -writer->radius_max_m;
        edges_m[1][1] = 2.0 * writer->radius_max_m;
    }
    const int32_t stage = frame->stage;
    /* step last: a frame counts when its step is there */
    const struct row rows[] = {{SERIES_POSITION, frame->position_m},
                               {SERIES_VELOCITY, frame->velocity_m_per_s},
                               {SERIES_ANGULAR_VELOCITY, frame->angular_velocity_rad_per_s},
                               {SERIES_EDGES, edges_m},
                               {SERIES_ORIGIN, lo_m},
                               {SERIES_STAGE, &stage},
                               {SERIES_TIME, &frame->place.time_s},
                               {SERIES_STEP, &frame->place.step},
                               {N_SERIES, NULL}};
    TRY(rows_append(writer, rows, 1));
    TRY(frame_observables_frame(&writer->observed, (struct moment){frame->place.step, frame->stage}));
    return frame_link(writer);
}

enum status run_writer_contact_frame(struct run_writer *writer, const struct contact_frame *frame)
{
    const int64_t offset = writer->contacts + frame->count;
    const struct row contacts[] = {{SERIES_CONTACT_PAIR, frame->pair},
                                   {SERIES_CONTACT_OVERLAP, frame->overlap_m},
                                   {SERIES_CONTACT_NORMAL_FORCE, frame->normal_force_n},
                                   {SERIES_CONTACT_NORMAL, frame->normal},
                                   {SERIES_CONTACT_TANGENTIAL_FORCE, frame->tangential_force_n},
                                   {SERIES_CONTACT_SLIDING, frame->sliding},
                                   {N_SERIES, NULL}};
    const struct row place[] = {{SERIES_CONTACT_TIME, &frame->place.time_s},
                                {SERIES_CONTACT_STEP, &frame->place.step},
                                {SERIES_CONTACT_OFFSET, &offset},
                                {N_SERIES, NULL}};
    TRY(rows_append(writer, contacts, (hsize_t)frame->count));
    for (int k = 0; k < writer->facts.n_history; k++)
        TRY(h5_series_append(&writer->history[k], (hsize_t)frame->count, frame->history[k]));
    TRY(rows_append(writer, place, 1));
    writer->contacts = offset;
    return STATUS_OK;
}

static enum status observables_write(struct run_writer *writer, bool last)
{
    int64_t sample;
    while (frame_observables_next(&writer->observed, last, &sample))
        TRY(message_table_row_copy(writer->observables, writer->samples, sample));
    return STATUS_OK;
}

static enum status tables_flush(struct run_writer *writer, bool last)
{
    struct message_table *tables[] = {writer->samples, writer->observables, writer->wall_states, writer->wall_commands};
    TRY(observables_write(writer, last));
    for (size_t k = 0; k < sizeof tables / sizeof *tables; k++) {
        if (tables[k])
            TRY(message_table_flush(tables[k], last));
    }
    return h5_file_flush(writer->file);
}

enum status run_writer_flush(struct run_writer *writer)
{
    return tables_flush(writer, false);
}

static enum status end_write(hid_t file, const shakedown_end_t *end)
{
    const int32_t status = end->status, stage_end = end->stage_end;
    const struct {
        const char *name;
        int64_t value;
    } numbers[] = {{"state_hash", end->state_hash},
                   {"wall_states", end->wall_states},
                   {"wall_commands", end->wall_commands},
                   {"commands_repeated", end->commands_repeated},
                   {"records_repeated", end->records_repeated}};
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++)
        TRY(h5_attribute_numbers(file, "/", numbers[k].name, H5T_NATIVE_INT64, 0, &numbers[k].value));
    TRY(h5_vector_write(file, "/run/status", H5T_NATIVE_INT32, 0, &status, "1"));
    TRY(h5_attribute_numbers(file, "/", "status", H5T_NATIVE_INT32, 0, &status));
    TRY(h5_attribute_numbers(file, "/", "stage_end", H5T_NATIVE_INT32, 0, &stage_end));
    TRY(h5_attribute_numbers(file, "/", "elapsed_s", H5T_NATIVE_DOUBLE, 0, &end->elapsed_s));
    TRY(h5_attribute_text(file, "/", "reason", end->reason));
    TRY(h5_attribute_texts(file, "/", "channels", (const char *const *)end->channel, (size_t)end->n_channels));
    return h5_attribute_numbers(file, "/", "totals", H5T_NATIVE_INT64, (hsize_t)end->n_channels, end->total);
}

enum status run_writer_end(struct run_writer *writer, const shakedown_end_t *end)
{
    return end_write(writer->file, end);
}

struct run_counts run_writer_counts(const struct run_writer *writer)
{
    return (struct run_counts){.samples = message_table_rows(writer->samples),
                               .frames = (int64_t)writer->series[SERIES_STEP].rows,
                               .contact_frames = (int64_t)writer->series[SERIES_CONTACT_STEP].rows,
                               .wall_states = writer->wall_states ? message_table_rows(writer->wall_states) : 0,
                               .wall_commands = writer->wall_commands ? message_table_rows(writer->wall_commands) : 0};
}

static enum status all_close(struct run_writer *writer)
{
    for (int id = 0; id < N_SERIES; id++)
        TRY(h5_series_close(&writer->series[id]));
    for (int k = 0; k < HISTORY_FIELDS_MAX; k++)
        TRY(h5_series_close(&writer->history[k]));
    TRY(h5_series_close(&writer->notes));
    if (H5Tclose(writer->note_type) < 0)
        return status_fail(STATUS_IO, "run.h5: a type cannot be closed");
    TRY(message_table_close(writer->samples));
    TRY(message_table_close(writer->observables));
    TRY(message_table_close(writer->wall_states));
    TRY(message_table_close(writer->wall_commands));
    return h5_file_close(writer->file);
}

static void writer_free(struct run_writer *writer)
{
    message_table_free(writer->samples);
    message_table_free(writer->observables);
    frame_observables_free(&writer->observed);
    message_table_free(writer->wall_states);
    message_table_free(writer->wall_commands);
    free(writer);
}

enum status run_writer_close(struct run_writer *writer, bool complete)
{
    if (!writer)
        return STATUS_OK;
    enum status status = tables_flush(writer, true);
    if (status == STATUS_OK && complete)
        status = complete_write(writer->file, 1);
    if (status != STATUS_OK) {
        run_writer_abandon(writer);
        return status;
    }
    status = all_close(writer);
    writer_free(writer);
    return status;
}

void run_writer_abandon(struct run_writer *writer)
{
    if (!writer)
        return;
    h5_file_abandon(writer->file);
    writer_free(writer);
}
