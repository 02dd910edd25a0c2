#include "recorder/run_frames.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define TRAJECTORY "/particles/trajectory"
#define CONTACTS   "/connectivity/contacts"
#define HISTORY    CONTACTS "/history"

/* What this program takes of a file that claims more than any run has. */
static const hsize_t ROWS_MAX = 1000000000;
/* Deflate makes no more of a byte than this many (RFC 1951): what claims more is not there. */
static const hsize_t PER_STORED_BYTE_MAX = 1032;

static enum status wrong(const char *object, const char *what)
{
    return status_fail(STATUS_FORMAT, "%s: %s", object, what);
}

/* The extents of a dataset; rank -1 if they cannot be had or are beyond all reason. */
static int extents(hid_t dataset, hsize_t size[3])
{
    hsize_t all[H5S_MAX_RANK] = {0};
    hid_t space = H5Dget_space(dataset);
    int rank = space < 0 ? -1 : H5Sget_simple_extent_dims(space, all, NULL);
    if (space >= 0 && H5Sclose(space) < 0)
        return -1;
    if (rank < 1 || rank > 3)
        return -1;
    for (int k = 0; k < 3; k++) {
        size[k] = k < rank ? all[k] : 1;
        if (size[k] > ROWS_MAX)
            return -1;
    }
    const hsize_t values_max = PER_STORED_BYTE_MAX * H5Dget_storage_size(dataset);
    return size[0] == 0 || size[1] * size[2] <= values_max / size[0] ? rank : -1;
}

/* ---- what there is one of per frame ---- */

static enum status dataset_values(hid_t dataset, const char *path, hsize_t width, double **values, int64_t *rows)
{
    hsize_t size[3];
    if (extents(dataset, size) < 0 || size[1] * size[2] != width)
        return wrong(path, "has another shape");
    *values = malloc((size_t)(size[0] * width + 1) * sizeof **values);
    if (!*values)
        return status_fail(STATUS_NO_MEMORY, "%s: out of memory", path);
    if (H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, *values) < 0)
        return wrong(path, "cannot be read (damaged?)");
    *rows = (int64_t)size[0];
    return STATUS_OK;
}

/* Reads all of [rows][width] as numbers; *values is to be freed, also on failure. */
static enum status values_read(hid_t file, const char *path, hsize_t width, double **values, int64_t *rows)
{
    hid_t dataset = H5Dopen2(file, path, H5P_DEFAULT);
    if (dataset < 0)
        return wrong(path, "missing");
    enum status status = dataset_values(dataset, path, width, values, rows);
    return H5Dclose(dataset) >= 0 || status != STATUS_OK ? status : wrong(path, "cannot be closed");
}

/* The same where the number of rows is known. */
static enum status rows_read(hid_t file, const char *path, hsize_t width, int64_t rows, double **values)
{
    int64_t found = 0;
    TRY(values_read(file, path, width, values, &found));
    return found == rows ? STATUS_OK : wrong(path, "has not as many rows as there are frames");
}

static enum status offsets_check(const struct run_frames *run, int64_t contacts)
{
    const double *offset = run->offset;
    bool good = offset[0] == 0.0 && offset[run->n_contact_frames] <= (double)contacts;
    for (int64_t f = 0; good && f < run->n_contact_frames; f++)
        good = offset[f + 1] >= offset[f] && offset[f + 1] - offset[f] <= (double)ROWS_MAX;
    return good ? STATUS_OK : wrong(CONTACTS "/offset", "does not count the contacts");
}

/* In a file that was cut short there may be a frame of contacts without its particles, or the other way round. */
static enum status contact_frames_read(struct run_frames *run)
{
    double *step = NULL;
    int64_t found = 0;
    enum status status = values_read(run->file, CONTACTS "/step", 1, &step, &found);
    if (status == STATUS_OK)
        status = rows_read(run->file, CONTACTS "/offset", 1, found + 1, &run->offset);
    run->n_contact_frames = found < run->n_frames ? found : run->n_frames;
    for (int64_t f = 0; status == STATUS_OK && f < run->n_contact_frames; f++) {
        if (step[f] != run->step[f])
            status = wrong(CONTACTS "/step", "is not the step of the particles' frame");
    }
    free(step);
    return status;
}

static enum status frames_read(struct run_frames *run)
{
    hid_t file = run->file;
    TRY(values_read(file, TRAJECTORY "/position/step", 1, &run->step, &run->n_frames));
    TRY(rows_read(file, TRAJECTORY "/position/time", 1, run->n_frames, &run->time_s));
    TRY(rows_read(file, "/frames/stage", 1, run->n_frames, &run->stage));
    TRY(rows_read(file, "/frames/box_lo", 3, run->n_frames, &run->box_lo_m));
    TRY(rows_read(file, TRAJECTORY "/box/edges/value", 9, run->n_frames, &run->box_edges_m));
    return contact_frames_read(run);
}

/* ---- columns ---- */

static bool is_word(const char *name)
{
    size_t length = strlen(name);
    for (size_t k = 0; k < length; k++) {
        if (!isalnum((unsigned char)name[k]) && name[k] != '_')
            return false;
    }
    return length > 0 && length < COLUMN_NAME_MAX;
}

/* Attribute unit_si, a text of fixed length; "" if there is none. */
static void unit_read(hid_t dataset, char unit[COLUMN_UNIT_MAX])
{
    char text[256] = "";
    unit[0] = '\0';
    hid_t attribute = H5Aexists(dataset, "unit_si") > 0 ? H5Aopen(dataset, "unit_si", H5P_DEFAULT) : H5I_INVALID_HID;
    hid_t type = attribute < 0 ? H5I_INVALID_HID : H5Aget_type(attribute);
    const bool fits = type >= 0 && H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0 &&
                      H5Aget_storage_size(attribute) < sizeof text && H5Tget_size(type) < sizeof text;
    if (fits && H5Aread(attribute, type, text) >= 0 && strcmp(text, "1") != 0)
        snprintf(unit, COLUMN_UNIT_MAX, "%.*s", COLUMN_UNIT_MAX - 1, text);
    if ((type >= 0 && H5Tclose(type) < 0) || (attribute >= 0 && H5Aclose(attribute) < 0))
        unit[0] = '\0';
}

static bool type_is_number(hid_t dataset, bool *integer)
{
    hid_t type = H5Dget_type(dataset);
    H5T_class_t class = type < 0 ? H5T_NO_CLASS : H5Tget_class(type);
    *integer = class == H5T_INTEGER;
    return (type < 0 || H5Tclose(type) >= 0) && (class == H5T_INTEGER || class == H5T_FLOAT);
}

/* Adds the dataset at `path` as a column if it is one, of numbers: [rows][width], or [frames][rows][width]. */
static enum status column_add(struct columns *columns, hid_t file, const char *path, const char *name, int64_t frames,
                              int64_t rows)
{
    hsize_t size[3];
    bool integer;
    if (columns->n == COLUMNS_MAX - 1) /* one is kept for the force */
        return wrong(path, "is one column too many");
    struct column *column = &columns->column[columns->n];
    hid_t dataset = H5Dopen2(file, path, H5P_DEFAULT);
    if (dataset < 0)
        return wrong(path, "cannot be opened");
    column->dataset = dataset;
    columns->n++;
    const int rank = extents(dataset, size), first = frames > 0 ? 1 : 0;
    if (rank <= first || !type_is_number(dataset, &integer) || (first && size[0] != (hsize_t)frames) ||
        size[first] != (hsize_t)rows)
        return wrong(path, "is not as long as the others");
    const hsize_t width = first ? size[2] : size[1] * size[2];
    if (width < 1 || width > COLUMN_WIDTH_MAX)
        return wrong(path, "has rows of another length");
    column->width = (int)width;
    column->integer = integer;
    snprintf(column->name, sizeof column->name, "%s", name);
    unit_read(dataset, column->unit);
    return STATUS_OK;
}

struct listing {
    struct run_frames *run;
    int64_t contacts;
    enum status status;
};

static bool is_group(hid_t parent, const char *name)
{
    H5O_info_t info;
    return H5Oget_info_by_name(parent, name, &info, H5P_DEFAULT) >= 0 && info.type == H5O_TYPE_GROUP;
}

static herr_t particle_column(hid_t parent, const char *name, const H5L_info_t *link, void *user)
{
    struct listing *listing = user;
    struct run_frames *run = listing->run;
    struct columns *columns = &run->particles;
    char path[160];
    if (link->type != H5L_TYPE_HARD || !is_word(name) || strcmp(name, "box") == 0)
        return 0;
    const bool series = is_group(parent, name);
    snprintf(path, sizeof path, TRAJECTORY "/%s%s", name, series ? "/value" : "");
    if (series && run->n_frames == 0)
        return 0;
    listing->status = column_add(columns, run->file, path, name, series ? run->n_frames : 0, run->n_particles);
    if (listing->status == STATUS_OK)
        columns->column[columns->n - 1].fixed = !series;
    return listing->status == STATUS_OK ? 0 : 1;
}

/* What contacts remember: history_NAME. */
static herr_t remembered_column(hid_t parent, const char *name, const H5L_info_t *link, void *user)
{
    struct listing *listing = user;
    char path[160], own[COLUMN_NAME_MAX];
    (void)parent;
    if (link->type != H5L_TYPE_HARD || !is_word(name) || strlen(name) + sizeof "history_" > sizeof own)
        return 0;
    snprintf(path, sizeof path, HISTORY "/%s", name);
    snprintf(own, sizeof own, "history_%.*s", (int)(sizeof own - sizeof "history_"), name);
    listing->status = column_add(&listing->run->contacts, listing->run->file, path, own, 0, listing->contacts);
    return listing->status == STATUS_OK ? 0 : 1;
}

static herr_t contact_column(hid_t parent, const char *name, const H5L_info_t *link, void *user)
{
    struct listing *listing = user;
    char path[160];
    if (link->type != H5L_TYPE_HARD || !is_word(name) || strcmp(name, "step") == 0 || strcmp(name, "time") == 0 ||
        strcmp(name, "offset") == 0 || is_group(parent, name))
        return 0;
    snprintf(path, sizeof path, CONTACTS "/%s", name);
    listing->status = column_add(&listing->run->contacts, listing->run->file, path, name, 0, listing->contacts);
    return listing->status == STATUS_OK ? 0 : 1;
}

static enum status group_list(hid_t file, const char *path, H5L_iterate_t each, struct listing *listing)
{
    hsize_t index = 0;
    hid_t group = H5Gopen2(file, path, H5P_DEFAULT);
    if (group < 0)
        return wrong(path, "missing");
    const herr_t ended = H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, &index, each, listing);
    if (H5Gclose(group) < 0 || ended < 0)
        return wrong(path, "cannot be listed (damaged?)");
    return listing->status;
}

static enum status rows_of(hid_t file, const char *path, int64_t *rows)
{
    hsize_t size[3] = {0};
    hid_t dataset = H5Dopen2(file, path, H5P_DEFAULT);
    if (dataset < 0)
        return wrong(path, "missing");
    const int rank = extents(dataset, size);
    *rows = (int64_t)size[0];
    return H5Dclose(dataset) >= 0 && rank > 0 ? STATUS_OK : wrong(path, "has another shape");
}

/* What names a row comes first. */
static void column_first(struct columns *columns, const char *name)
{
    for (int k = 1; k < columns->n; k++) {
        if (strcmp(columns->column[k].name, name) != 0)
            continue;
        const struct column found = columns->column[k];
        memmove(&columns->column[1], &columns->column[0], (size_t)k * sizeof found);
        columns->column[0] = found;
    }
}

static enum status want(const struct columns *columns, const char *group, const char *name, int width)
{
    const struct column *column = columns_find(columns, name);
    if (column && column->width == width)
        return STATUS_OK;
    return status_fail(STATUS_FORMAT, "%s/%s: %s", group, name, column ? "has another shape" : "missing");
}

static enum status particles_open(struct run_frames *run)
{
    struct listing listing = {.run = run};
    TRY(rows_of(run->file, TRAJECTORY "/radius", &run->n_particles));
    TRY(group_list(run->file, TRAJECTORY, particle_column, &listing));
    column_first(&run->particles, "id");
    if (run->n_frames > 0)
        TRY(want(&run->particles, TRAJECTORY, "position", 3));
    return want(&run->particles, TRAJECTORY, "radius", 1);
}

static enum status contacts_open(struct run_frames *run)
{
    struct columns *contacts = &run->contacts;
    struct listing listing = {.run = run};
    TRY(rows_of(run->file, CONTACTS "/pair", &listing.contacts));
    TRY(offsets_check(run, listing.contacts));
    TRY(group_list(run->file, CONTACTS, contact_column, &listing));
    if (H5Lexists(run->file, HISTORY, H5P_DEFAULT) > 0)
        TRY(group_list(run->file, HISTORY, remembered_column, &listing));
    column_first(contacts, "pair");
    TRY(want(contacts, CONTACTS, "pair", 2));
    TRY(want(contacts, CONTACTS, "overlap", 1));
    TRY(want(contacts, CONTACTS, "normal_force", 1));
    TRY(want(contacts, CONTACTS, "normal", 3));
    if (columns_find(contacts, "tangential_force"))
        TRY(want(contacts, CONTACTS, "tangential_force", 3));
    contacts->column[contacts->n++] =
        (struct column){.name = "force", .unit = "N", .width = 3, .dataset = H5I_INVALID_HID};
    return STATUS_OK;
}

static bool complete_read(hid_t file)
{
    int complete = 0;
    hid_t id = H5Aexists(file, "complete") > 0 ? H5Aopen(file, "complete", H5P_DEFAULT) : H5I_INVALID_HID;
    if (id < 0)
        return false;
    hid_t space = H5Aget_space(id);
    const bool single = space >= 0 && H5Sget_simple_extent_npoints(space) == 1;
    const bool good = single && H5Aread(id, H5T_NATIVE_INT, &complete) >= 0;
    return (space < 0 || H5Sclose(space) >= 0) && H5Aclose(id) >= 0 && good && complete == 1;
}

static enum status contents_open(struct run_frames *run)
{
    run->complete = complete_read(run->file);
    TRY(frames_read(run));
    TRY(particles_open(run));
    return contacts_open(run);
}

enum status run_frames_open(struct run_frames *run, const char *path)
{
    *run = (struct run_frames){.file = H5I_INVALID_HID};
    if (access(path, R_OK) != 0)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    hid_t properties = H5Pcreate(H5P_FILE_ACCESS);
    if (H5Eset_auto2(H5E_DEFAULT, NULL, NULL) < 0 || properties < 0 || H5Pset_file_locking(properties, 0, 1) < 0)
        return status_fail(STATUS_IO, "cannot set up HDF5");
    run->file = H5Fopen(path, H5F_ACC_RDONLY, properties);
    if (H5Pclose(properties) < 0 || run->file < 0)
        return status_fail(STATUS_FORMAT, "%s: is not HDF5, or is damaged", path);
    enum status status = contents_open(run);
    if (status == STATUS_OK)
        return STATUS_OK;
    char reason[512];
    snprintf(reason, sizeof reason, "%s", status_message());
    run_frames_close(run);
    return status_fail(status, "%s: %s", path, reason);
}

/* ---- a frame ---- */

static enum status column_read(struct column *column, hsize_t start, hsize_t rows, bool in_frame)
{
    const hsize_t width = (hsize_t)column->width;
    const hsize_t from[3] = {start}, wide[3] = {in_frame ? 1 : rows, in_frame ? rows : width, width};
    double *grown = realloc(column->value, (size_t)(rows * width + 1) * sizeof *grown);
    if (!grown)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    column->value = grown;
    if (rows == 0)
        return STATUS_OK;
    const hsize_t values = rows * width;
    hid_t space = H5Dget_space(column->dataset), memory = H5Screate_simple(1, &values, NULL);
    bool good = space >= 0 && memory >= 0 && H5Sselect_hyperslab(space, H5S_SELECT_SET, from, NULL, wide, NULL) >= 0 &&
                H5Dread(column->dataset, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, grown) >= 0;
    good = (space < 0 || H5Sclose(space) >= 0) && (memory < 0 || H5Sclose(memory) >= 0) && good;
    return good ? STATUS_OK : wrong(column->name, "cannot be read (damaged?)");
}

static bool pair_is_good(const double *pair, int64_t n_particles)
{
    const double n = (double)n_particles;
    return pair[0] >= 0.0 && pair[0] < n && pair[1] >= -6.0 && pair[1] < n;
}

/* The force on i: the normal one from j to i, and the tangential. */
static enum status forces_set(struct columns *contacts)
{
    struct column *force = &contacts->column[contacts->n - 1];
    const double *normal_force = columns_find(contacts, "normal_force")->value;
    const double *normal = columns_find(contacts, "normal")->value;
    const struct column *tangential = columns_find(contacts, "tangential_force");
    double *grown = realloc(force->value, (size_t)(3 * contacts->rows + 1) * sizeof *grown);
    if (!grown)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    force->value = grown;
    for (int64_t k = 0; k < 3 * contacts->rows; k++)
        grown[k] = normal_force[k / 3] * normal[k] + (tangential ? tangential->value[k] : 0.0);
    return STATUS_OK;
}

static enum status contacts_read(struct run_frames *run, int64_t frame)
{
    struct columns *contacts = &run->contacts;
    const bool has = frame < run->n_contact_frames;
    const double first = has ? run->offset[frame] : 0.0;
    contacts->rows = has ? (int64_t)(run->offset[frame + 1] - first) : 0;
    for (int k = 0; k < contacts->n - 1; k++)
        TRY(column_read(&contacts->column[k], (hsize_t)first, (hsize_t)contacts->rows, false));
    const double *pair = columns_find(contacts, "pair")->value;
    for (int64_t c = 0; c < contacts->rows; c++) {
        if (!pair_is_good(pair + 2 * c, run->n_particles))
            return wrong(CONTACTS "/pair", "names a particle or a wall that there is not");
    }
    return forces_set(contacts);
}

enum status run_frames_read(struct run_frames *run, int64_t frame)
{
    struct columns *particles = &run->particles;
    particles->rows = run->n_particles;
    for (int k = 0; k < particles->n; k++) {
        struct column *column = &particles->column[k];
        const bool fixed = column->fixed;
        if (!fixed || !column->value)
            TRY(column_read(column, fixed ? 0 : (hsize_t)frame, (hsize_t)run->n_particles, !fixed));
    }
    return contacts_read(run, frame);
}

const struct column *columns_find(const struct columns *columns, const char *name)
{
    for (int k = 0; k < columns->n; k++) {
        if (strcmp(columns->column[k].name, name) == 0)
            return &columns->column[k];
    }
    return NULL;
}

void run_frames_contact_ends(const struct run_frames *run, int64_t row, double end_m[2][3])
{
    const struct columns *contacts = &run->contacts;
    const double *pair = columns_find(contacts, "pair")->value + 2 * row;
    const double *normal = columns_find(contacts, "normal")->value + 3 * row;
    const double *position_m = columns_find(&run->particles, "position")->value;
    const size_t i = (size_t)pair[0];
    const double reach_m =
        columns_find(&run->particles, "radius")->value[i] - columns_find(contacts, "overlap")->value[row];
    for (int axis = 0; axis < 3; axis++) {
        end_m[0][axis] = position_m[3 * i + (size_t)axis];
        end_m[1][axis] =
            pair[1] < 0.0 ? end_m[0][axis] - reach_m * normal[axis] : position_m[3 * (size_t)pair[1] + (size_t)axis];
    }
}

bool run_frames_is_superseded(const struct run_frames *run, int64_t frame)
{
    return frame + 1 < run->n_frames && run->step[frame + 1] == run->step[frame];
}

static void columns_close(struct columns *columns)
{
    for (int k = 0; k < columns->n; k++) {
        free(columns->column[k].value);
        if (columns->column[k].dataset >= 0 && H5Dclose(columns->column[k].dataset) < 0)
            fprintf(stderr, "export: warning: %s cannot be closed\n", columns->column[k].name);
    }
}

void run_frames_close(struct run_frames *run)
{
    columns_close(&run->particles);
    columns_close(&run->contacts);
    free(run->step);
    free(run->time_s);
    free(run->stage);
    free(run->box_lo_m);
    free(run->box_edges_m);
    free(run->offset);
    if (run->file >= 0 && H5Fclose(run->file) < 0)
        fprintf(stderr, "export: warning: run.h5 cannot be closed\n");
    *run = (struct run_frames){.file = H5I_INVALID_HID};
}
