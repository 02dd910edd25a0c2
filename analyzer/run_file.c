#include "analyzer/run_file.h"
#include "common/config_literals.h"
#include "common/scene_file.h"

#include <errno.h>
#include <hdf5.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const struct observable_info {
    const char *name;
    enum observable_shape shape;
} observables[OBSERVABLES] = {
#define OBSERVABLE_INFO(id, name, shape) {name, shape},
    OBSERVABLE_LIST(OBSERVABLE_INFO)
#undef OBSERVABLE_INFO
};

/* Deflate makes no more of a byte than 1032 (RFC 1951): a dataset that claims more values does not hold them. */
enum { RECORDS_MAX = 100000000, PER_STORED_BYTE_MAX = 1032, TEXT_MAX = 1 << 20 };

static enum status missing(const char *path, const char *object, const char *what)
{
    return status_fail(STATUS_FORMAT, "%s: %s: %s", path, object, what);
}

/* Fixed and variable length strings are both legal in H5MD. Cuts at `size` only where `owned` is not asked for. */
static char *attribute_text(hid_t attribute)
{
    char *text = NULL;
    hid_t stored = H5Aget_type(attribute);
    if (stored < 0)
        return NULL;
    if (H5Tget_class(stored) == H5T_STRING && H5Tis_variable_str(stored) > 0) {
        char *borrowed = NULL;
        if (H5Aread(attribute, stored, &borrowed) >= 0 && borrowed) {
            text = strdup(borrowed);
            if (H5free_memory(borrowed) < 0) {
                free(text);
                text = NULL;
            }
        }
    } else if (H5Tget_class(stored) == H5T_STRING) {
        const size_t size = H5Tget_size(stored);
        text = size <= TEXT_MAX ? calloc(size + 1, 1) : NULL;
        if (text && H5Aread(attribute, stored, text) < 0) {
            free(text);
            text = NULL;
        }
    }
    if (H5Tclose(stored) < 0) {
        free(text);
        return NULL;
    }
    return text;
}

static bool is_single(hid_t attribute)
{
    hid_t space = H5Aget_space(attribute);
    bool single = space >= 0 && H5Sget_simple_extent_npoints(space) == 1;
    return single && H5Sclose(space) >= 0;
}

/* An owned string; STATUS_FORMAT if it is not there. */
static enum status text_read(hid_t file, const char *path, const char *group, const char *name, char **text)
{
    char object[160];
    snprintf(object, sizeof object, "%s attribute %s", group, name);
    hid_t attribute = H5Aopen_by_name(file, group, name, H5P_DEFAULT, H5P_DEFAULT);
    if (attribute < 0)
        return missing(path, object, "missing");
    *text = is_single(attribute) ? attribute_text(attribute) : NULL;
    if (H5Aclose(attribute) < 0 || !*text) {
        free(*text);
        *text = NULL;
        return missing(path, object, "is not a string");
    }
    return STATUS_OK;
}

static enum status short_text_read(hid_t file, const char *path, const char *group, const char *name, char *target,
                                   size_t size)
{
    char *text = NULL;
    TRY(text_read(file, path, group, name, &text));
    snprintf(target, size, "%s", text);
    free(text);
    return STATUS_OK;
}

/* `type` is the native type of *value. */
static enum status number_read(hid_t file, const char *path, const char *group, const char *name, hid_t type,
                               void *value)
{
    char object[160];
    snprintf(object, sizeof object, "%s attribute %s", group, name);
    hid_t attribute = H5Aopen_by_name(file, group, name, H5P_DEFAULT, H5P_DEFAULT);
    if (attribute < 0)
        return missing(path, object, "missing");
    bool good = is_single(attribute) && H5Aread(attribute, type, value) >= 0;
    if (H5Aclose(attribute) < 0 || !good)
        return missing(path, object, "is not a number");
    return STATUS_OK;
}

static bool attribute_exists(hid_t file, const char *name)
{
    return H5Aexists(file, name) > 0;
}

/* Attributes of the root come with END: a run that was cut off has none but `complete`. */
static enum status root_read(hid_t file, const char *path, struct run *run)
{
    int complete = 0;
    run->elapsed_s = NAN;
    if (attribute_exists(file, "complete"))
        TRY(number_read(file, path, "/", "complete", H5T_NATIVE_INT, &complete));
    run->complete = complete == 1;
    if (run->complete || attribute_exists(file, "elapsed_s"))
        TRY(number_read(file, path, "/", "elapsed_s", H5T_NATIVE_DOUBLE, &run->elapsed_s));
    if (attribute_exists(file, "status"))
        TRY(number_read(file, path, "/", "status", H5T_NATIVE_INT, &run->status));
    if (attribute_exists(file, "reason"))
        TRY(short_text_read(file, path, "/", "reason", run->reason, sizeof run->reason));
    return STATUS_OK;
}

/* The text with assignments applied; owned by the caller. */
static enum status text_set(const char *text, const char *const *settings, int n, char **result)
{
    config_t config;
    size_t size = 0;
    char *checked;
    TRY(config_literals(text, "effective_config", &checked)); /* no includes either */
    config_init(&config);
    enum status status = STATUS_OK;
    if (config_read_string(&config, checked) != CONFIG_TRUE)
        status = status_fail(STATUS_CONFIG, "effective_config:%d: %s", config_error_line(&config),
                             config_error_text(&config));
    free(checked);
    for (int k = 0; status == STATUS_OK && k < n; k++)
        status = config_override(&config, settings[k]);
    FILE *out = status == STATUS_OK ? open_memstream(result, &size) : NULL;
    if (out)
        config_write(&config, out);
    if (status == STATUS_OK && (!out || fclose(out) != 0))
        status = status_fail(STATUS_NO_MEMORY, "out of memory");
    config_destroy(&config);
    return status;
}

static enum status scene_read(hid_t file, const char *path, struct run *run, const char *const *settings, int n)
{
    char *text = NULL, *changed = NULL;
    char where[512];
    TRY(text_read(file, path, "/parameters", "effective_config", &text));
    run->scene = calloc(1, sizeof *run->scene);
    snprintf(where, sizeof where, "%s: effective_config", path);
    enum status status = run->scene ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "out of memory");
    if (status == STATUS_OK && n > 0)
        status = text_set(text, settings, n, &changed);
    if (status == STATUS_OK)
        status = scene_parse(run->scene, changed ? changed : text, where);
    free(text);
    free(changed);
    return status;
}

static enum status parameters_read(hid_t file, const char *path, struct run *run, const char *const *settings, int n)
{
    static const char group[] = "/parameters";
    if (H5Lexists(file, group, H5P_DEFAULT) <= 0)
        return missing(path, group, "missing");
    TRY(short_text_read(file, path, group, "name", run->name, sizeof run->name));
    TRY(short_text_read(file, path, group, "version", run->version, sizeof run->version));
    TRY(short_text_read(file, path, group, "kernel_set", run->kernel_set, sizeof run->kernel_set));
    if (H5Aexists_by_name(file, group, "controller", H5P_DEFAULT) > 0) /* not in files of earlier versions */
        TRY(short_text_read(file, path, group, "controller", run->controller, sizeof run->controller));
    TRY(number_read(file, path, group, "seed", H5T_NATIVE_INT64, &run->seed));
    TRY(number_read(file, path, group, "dimension", H5T_NATIVE_INT, &run->dimension));
    TRY(scene_read(file, path, run, settings, n));
    if (run->dimension != run->scene->dimension || run->dimension < 2 || run->dimension > 3)
        return status_fail(STATUS_FORMAT, "%s: %s: dimension %d does not fit the scene's %d", path, group,
                           run->dimension, (int)run->scene->dimension);
    return STATUS_OK;
}

static size_t shape_width(enum observable_shape shape, int dimension)
{
    size_t d = (size_t)dimension;
    return shape == SHAPE_SCALAR ? 1 : shape == SHAPE_VECTOR ? d : d * d;
}

/* Number of records of an open dataset of shape [n] or [n][width]; a scalar may also be stored as [n][1]. The extents
 * are the file's word: they are checked before anything is multiplied or allocated. */
static enum status records_count(hid_t dataset, const char *path, const char *object, size_t width, size_t *count)
{
    hsize_t size[H5S_MAX_RANK] = {0};
    hid_t space = H5Dget_space(dataset);
    int rank = space < 0 ? -1 : H5Sget_simple_extent_ndims(space);
    bool good = rank > 0 && H5Sget_simple_extent_dims(space, size, NULL) == rank;
    if (space >= 0 && H5Sclose(space) < 0)
        good = false;
    hsize_t row = 1;
    for (int k = 1; good && k < rank; k++) {
        good = size[k] <= width; /* so that no product of what follows overflows */
        row *= good ? size[k] : 0;
        good = good && row <= width;
    }
    if (!good || row != width)
        return status_fail(STATUS_FORMAT, "%s: %s: wrong shape, expected [samples]%s of %zu", path, object,
                           width > 1 ? " rows" : "", width);
    if (size[0] > RECORDS_MAX)
        return status_fail(STATUS_FORMAT, "%s: %s: claims %llu records; at most %d are read", path, object,
                           (unsigned long long)size[0], (int)RECORDS_MAX);
    if (size[0] * width > PER_STORED_BYTE_MAX * H5Dget_storage_size(dataset))
        return missing(path, object, "claims more records than the file holds (damaged?)");
    *count = (size_t)size[0];
    return STATUS_OK;
}

static enum status values_read(hid_t dataset, const char *path, const char *object, size_t width, double **values,
                               size_t *count)
{
    TRY(records_count(dataset, path, object, width, count));
    *values = malloc((*count * width + 1) * sizeof **values);
    if (!*values)
        return status_fail(STATUS_NO_MEMORY, "%s: %s: out of memory", path, object);
    if (H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, *values) < 0)
        return missing(path, object, "cannot be read (damaged?)");
    return STATUS_OK;
}

/* A whole dataset as double, owned by the caller also on failure. */
static enum status dataset_read(hid_t file, const char *path, const char *object, size_t width, double **values,
                                size_t *count)
{
    hid_t dataset = H5Dopen2(file, object, H5P_DEFAULT);
    if (dataset < 0)
        return missing(path, object, "missing");
    enum status status = values_read(dataset, path, object, width, values, count);
    if (H5Dclose(dataset) < 0 && status == STATUS_OK)
        return missing(path, object, "cannot be closed");
    return status;
}

/* The recorder extends dataset by dataset, so a run that was cut off may have one row more in some than in others. */
static enum status length_take(struct run *run, const char *path, const char *object, size_t count)
{
    if (run->complete && count != run->n_samples && run->n_samples != SIZE_MAX)
        return status_fail(STATUS_FORMAT, "%s: %s: %zu records where the others have %zu", path, object, count,
                           run->n_samples);
    if (count < run->n_samples)
        run->n_samples = count;
    return STATUS_OK;
}

/* Files of earlier versions have none of these. */
static bool is_optional(enum observable observable)
{
    return observable == OBSERVABLE_CONTROLLER_RESIDUAL || observable == OBSERVABLE_ELASTIC_NORMAL ||
           observable == OBSERVABLE_ELASTIC_TANGENTIAL;
}

/* In files of earlier versions the samples stand where the frames' now do. */
static const char *samples_root(hid_t file)
{
    return H5Lexists(file, "/samples", H5P_DEFAULT) > 0 ? "/samples" : "/observables";
}

static bool is_absent(hid_t file, enum observable observable)
{
    char group[160];
    snprintf(group, sizeof group, "%s/%s", samples_root(file), observables[observable].name);
    return is_optional(observable) && H5Lexists(file, group, H5P_DEFAULT) == 0;
}

/* NaN for each sample, so that what is made from it is undefined. */
static enum status fill_absent(struct run *run, const char *path, int observable)
{
    const size_t count = run->n_samples * run->width[observable];
    double *value = run->value[observable] = malloc((count + 1) * sizeof *value);
    if (!value)
        return status_fail(STATUS_NO_MEMORY, "%s: out of memory", path);
    for (size_t k = 0; k < count; k++)
        value[k] = NAN;
    return STATUS_OK;
}

/* Steps and times are what all else is ordered by. */
static enum status times_check(const char *path, const struct run *run)
{
    static const double step_max = 9e15; /* a double counts steps up to there */
    for (size_t k = 0; k < run->n_samples; k++) {
        const double stage_time = run->value[OBSERVABLE_STAGE_TIME][k];
        if (!(fabs(run->step[k]) < step_max) || !isfinite(run->time_s[k]) || !isfinite(stage_time))
            return status_fail(STATUS_FORMAT, "%s: /samples/stage: record %zu has no step or no time", path, k);
    }
    return STATUS_OK;
}

static enum status observables_read(hid_t file, const char *path, struct run *run)
{
    const char *root = samples_root(file);
    char object[160];
    size_t count = 0;
    run->n_samples = SIZE_MAX;
    snprintf(object, sizeof object, "%s/stage/step", root);
    TRY(dataset_read(file, path, object, 1, &run->step, &count));
    TRY(length_take(run, path, object, count));
    snprintf(object, sizeof object, "%s/stage/time", root);
    TRY(dataset_read(file, path, object, 1, &run->time_s, &count));
    TRY(length_take(run, path, object, count));
    for (int k = 0; k < OBSERVABLES; k++) {
        snprintf(object, sizeof object, "%s/%s/value", root, observables[k].name);
        run->width[k] = shape_width(observables[k].shape, run->dimension);
        if (is_absent(file, k))
            continue;
        TRY(dataset_read(file, path, object, run->width[k], &run->value[k], &count));
        TRY(length_take(run, path, object, count));
    }
    for (int k = 0; k < OBSERVABLES; k++)
        if (!run->value[k])
            TRY(fill_absent(run, path, k));
    TRY(times_check(path, run));
    run->steps = run->n_samples ? (int64_t)run->step[run->n_samples - 1] : 0;
    return STATUS_OK;
}

/* A box without a positive length has no strain. */
static enum status boxes_check(const char *path, const struct run *run)
{
    for (size_t k = 0; k < run->n_samples * run->width[OBSERVABLE_BOX_LENGTH]; k++)
        if (!(run->value[OBSERVABLE_BOX_LENGTH][k] > 0) || !isfinite(run->value[OBSERVABLE_BOX_LENGTH][k]))
            return status_fail(STATUS_FORMAT, "%s: /samples/box_length_m/value: record %zu is not positive", path,
                               k / run->width[OBSERVABLE_BOX_LENGTH]);
    return STATUS_OK;
}

/* "stage;severity;text" */
static void note_parse(const char *line, struct run_note *note)
{
    static const char *const severities[] = {"note", "doubtful", "failed"};
    const char *first = strchr(line, ';'), *second = first ? strchr(first + 1, ';') : NULL;
    if (!second) {
        snprintf(note->text, sizeof note->text, "%s", line);
        return;
    }
    snprintf(note->stage, sizeof note->stage, "%.*s", (int)(first - line < 127 ? first - line : 127), line);
    snprintf(note->text, sizeof note->text, "%s", second + 1);
    const size_t length = (size_t)(second - first - 1);
    for (int k = 0; k < 3; k++)
        if (strlen(severities[k]) == length && strncmp(first + 1, severities[k], length) == 0)
            note->severity = k;
}

/* Texts of one fixed length, as the recorder writes them. */
static enum status note_texts_read(hid_t dataset, hid_t type, const char *path, struct run *run)
{
    size_t count;
    TRY(records_count(dataset, path, "/notes", 1, &count));
    const size_t size = H5Tget_size(type);
    if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0 || size > TEXT_MAX)
        return missing(path, "/notes", "are no texts of a fixed length");
    if (count > RUN_NOTES_MAX)
        return status_fail(STATUS_FORMAT, "%s: /notes: %zu texts; at most %d are read", path, count,
                           (int)RUN_NOTES_MAX);
    char *texts = calloc(count + 1, size + 1), *line = calloc(size + 1, 1);
    run->note = calloc(count + 1, sizeof *run->note);
    enum status status = STATUS_OK;
    if (!texts || !line || !run->note)
        status = status_fail(STATUS_NO_MEMORY, "%s: out of memory", path);
    else if (H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts) < 0)
        status = missing(path, "/notes", "cannot be read (damaged?)");
    for (size_t k = 0; status == STATUS_OK && k < count; k++) {
        memcpy(line, texts + k * size, size);
        note_parse(line, &run->note[run->n_notes++]);
    }
    free(texts);
    free(line);
    return status;
}

/* Files of earlier versions have none. */
static enum status notes_read(hid_t file, const char *path, struct run *run)
{
    if (H5Lexists(file, "/notes", H5P_DEFAULT) <= 0)
        return STATUS_OK;
    hid_t dataset = H5Dopen2(file, "/notes", H5P_DEFAULT);
    hid_t type = dataset < 0 ? -1 : H5Dget_type(dataset);
    enum status status =
        type < 0 ? missing(path, "/notes", "cannot be opened") : note_texts_read(dataset, type, path, run);
    const bool closed = (type < 0 || H5Tclose(type) >= 0) && (dataset < 0 || H5Dclose(dataset) >= 0);
    return closed || status != STATUS_OK ? status : missing(path, "/notes", "cannot be closed");
}

static enum status file_read(hid_t file, const char *path, struct run *run, const char *const *settings, int n)
{
    TRY(root_read(file, path, run));
    TRY(parameters_read(file, path, run, settings, n));
    TRY(observables_read(file, path, run));
    TRY(notes_read(file, path, run));
    return boxes_check(path, run);
}

enum status run_read(struct run *run, const char *path)
{
    return run_read_set(run, path, NULL, 0);
}

enum status run_read_set(struct run *run, const char *path, const char *const *settings, int n)
{
    memset(run, 0, sizeof *run);
    if (access(path, R_OK) != 0)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    /* errors are reported through status, not printed by the library */
    if (H5Eset_auto2(H5E_DEFAULT, NULL, NULL) < 0)
        return status_fail(STATUS_IO, "%s: the HDF5 library failed", path);
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file < 0)
        return missing(path, "file", "is not HDF5, is truncated, or is still being written");
    enum status status = file_read(file, path, run, settings, n);
    if (H5Fclose(file) < 0 && status == STATUS_OK)
        status = missing(path, "file", "cannot be closed");
    if (status != STATUS_OK)
        run_free(run);
    return status;
}

void run_free(struct run *run)
{
    if (run->scene)
        scene_free(run->scene);
    free(run->scene);
    free(run->note);
    free(run->step);
    free(run->time_s);
    for (int k = 0; k < OBSERVABLES; k++)
        free(run->value[k]);
    memset(run, 0, sizeof *run);
}

const double *run_record(const struct run *run, enum observable observable, size_t sample)
{
    return run->value[observable] + sample * run->width[observable];
}

void run_stage_range(const struct run *run, int stage, size_t *begin, size_t *end)
{
    const double *of = run->value[OBSERVABLE_STAGE];
    size_t k = 0;
    while (k < run->n_samples && of[k] != stage)
        k++;
    *begin = k;
    while (k < run->n_samples && of[k] == stage)
        k++;
    *end = k;
}
