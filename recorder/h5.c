#include "recorder/h5.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { REASON_MAX = 512 };

/* The innermost entry of HDF5's stack says what the system said. */
static herr_t keep_reason(unsigned depth, const H5E_error2_t *entry, void *reason)
{
    (void)depth;
    snprintf(reason, REASON_MAX, "%s", entry->desc ? entry->desc : "");
    return 1;
}

/* Keeps the system's message of a reason like "file write failed: time = ..., error message = 'File too large', ...".
 */
static void shorten(char reason[REASON_MAX])
{
    static const char mark[] = "error message = '";
    char *start = strstr(reason, mark);
    char *end = start ? strchr(start + sizeof mark - 1, '\'') : NULL;
    if (!end)
        return;
    *end = '\0';
    memmove(reason, start + sizeof mark - 1, (size_t)(end - start) - sizeof mark + 2);
}

/* To be called right after what failed: the next call into HDF5 forgets the reason. */
static enum status fail(const char *what, const char *path)
{
    char reason[REASON_MAX] = "";
    if (H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_reason, reason) < 0 || !reason[0])
        snprintf(reason, sizeof reason, "HDF5 gives no reason");
    shorten(reason);
    return status_fail(STATUS_IO, "cannot %s %s: %s", what, path, reason);
}

/* STATUS_OK if `ok`. */
static enum status check(bool ok, const char *what, const char *path)
{
    return ok ? STATUS_OK : fail(what, path);
}

/* Closes `id` if it is open; a failure before it stays the one that is told. */
static enum status release(enum status status, hid_t id, herr_t (*close)(hid_t), const char *path)
{
    if (id < 0 || close(id) >= 0 || status != STATUS_OK)
        return status;
    return fail("close", path);
}

enum status h5_file_create(const char *path, hid_t *file)
{
    *file = H5I_INVALID_HID;
    (void)H5dont_atexit(); /* fails if it was called before, which does no harm */
    TRY(check(H5Eset_auto2(H5E_DEFAULT, NULL, NULL) >= 0, "set up HDF5 for", path));
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    enum status status = check(access >= 0 && H5Pset_file_locking(access, 0, 1) >= 0, "set up HDF5 for", path);
    if (status == STATUS_OK) {
        *file = H5Fcreate(path, H5F_ACC_EXCL, H5P_DEFAULT, access);
        status = check(*file >= 0, "create", path);
    }
    return release(status, access, H5Pclose, path);
}

enum status h5_file_flush(hid_t file)
{
    return check(H5Fflush(file, H5F_SCOPE_LOCAL) >= 0, "flush", "run.h5");
}

void h5_file_abandon(hid_t file)
{
    void *handle; /* a descriptor, with the default driver */
    if (file >= 0 && H5Fget_vfd_handle(file, H5P_DEFAULT, &handle) >= 0 && ftruncate(*(int *)handle, 0) != 0)
        fprintf(stderr, "recorder: warning: the room of run.h5.part cannot be given back: %s\n", strerror(errno));
}

enum status h5_file_close(hid_t file)
{
    return check(H5Fclose(file) >= 0, "close", "run.h5");
}

/* Link properties that make the groups on the way; to be closed also on failure. */
static enum status link_with_groups(hid_t *links, const char *path)
{
    *links = H5Pcreate(H5P_LINK_CREATE);
    return check(*links >= 0 && H5Pset_create_intermediate_group(*links, 1) >= 0, "create", path);
}

enum status h5_group_create(hid_t file, const char *path)
{
    hid_t links, group = H5I_INVALID_HID;
    enum status status = link_with_groups(&links, path);
    if (status == STATUS_OK) {
        group = H5Gcreate2(file, path, links, H5P_DEFAULT, H5P_DEFAULT);
        status = check(group >= 0, "create", path);
    }
    status = release(status, group, H5Gclose, path);
    return release(status, links, H5Pclose, path);
}

enum status h5_link(hid_t file, const char *target, const char *name)
{
    return check(H5Lcreate_hard(file, target, file, name, H5P_DEFAULT, H5P_DEFAULT) >= 0, "link", name);
}

static enum status dataset_create(hid_t file, const char *path, hid_t type, hid_t space, hid_t properties, hid_t *id)
{
    hid_t links;
    *id = H5I_INVALID_HID;
    enum status status = link_with_groups(&links, path);
    if (status == STATUS_OK) {
        *id = H5Dcreate2(file, path, type, space, links, properties, H5P_DEFAULT);
        status = check(*id >= 0, "create", path);
    }
    return release(status, links, H5Pclose, path);
}

/* Dataset properties of a layout; to be closed also on failure. */
static enum status layout_properties(int rank, const struct h5_layout *layout, const char *path, hid_t *properties)
{
    *properties = H5Pcreate(H5P_DATASET_CREATE);
    bool ok = *properties >= 0 && H5Pset_chunk(*properties, rank, layout->chunk) >= 0;
    if (ok && layout->deflate > 0)
        ok = H5Pset_shuffle(*properties) >= 0 && H5Pset_deflate(*properties, (unsigned)layout->deflate) >= 0;
    ok = ok && H5Pset_fletcher32(*properties) >= 0; /* a changed byte is found by whoever reads it */
    return check(ok, "create", path);
}

enum status h5_series_create(hid_t file, const char *path, hid_t type, int rank, const hsize_t *row_dims,
                             const struct h5_layout *layout, const char *unit, struct h5_series *series)
{
    *series = (struct h5_series){.id = H5I_INVALID_HID, .type = type, .rank = rank};
    hsize_t limits[H5_RANK_MAX] = {H5S_UNLIMITED};
    for (int k = 1; k < rank; k++)
        limits[k] = series->dims[k] = row_dims[k - 1];
    hid_t properties = H5I_INVALID_HID;
    hid_t space = H5Screate_simple(rank, series->dims, limits);
    enum status status = check(space >= 0, "create", path);
    if (status == STATUS_OK)
        status = layout_properties(rank, layout, path, &properties);
    if (status == STATUS_OK)
        status = dataset_create(file, path, type, space, properties, &series->id);
    status = release(status, properties, H5Pclose, path);
    TRY(release(status, space, H5Sclose, path));
    return h5_attribute_text(file, path, "unit_si", unit);
}

/* Writes into the selection of the last `rows` rows. */
static enum status write_rows(const struct h5_series *series, hid_t file_space, hsize_t rows, const void *data)
{
    hsize_t start[H5_RANK_MAX] = {series->rows};
    hsize_t count[H5_RANK_MAX] = {rows, series->dims[1], series->dims[2]};
    TRY(check(H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start, NULL, count, NULL) >= 0, "write", "run.h5"));
    hid_t memory = H5Screate_simple(series->rank, count, NULL);
    TRY(check(memory >= 0, "write", "run.h5"));
    enum status status =
        check(H5Dwrite(series->id, series->type, memory, file_space, H5P_DEFAULT, data) >= 0, "write", "run.h5");
    return release(status, memory, H5Sclose, "run.h5");
}

enum status h5_series_append(struct h5_series *series, hsize_t rows, const void *data)
{
    if (rows == 0)
        return STATUS_OK;
    hsize_t dims[H5_RANK_MAX] = {series->rows + rows, series->dims[1], series->dims[2]};
    TRY(check(H5Dset_extent(series->id, dims) >= 0, "extend", "run.h5"));
    hid_t space = H5Dget_space(series->id);
    TRY(check(space >= 0, "write", "run.h5"));
    enum status status = write_rows(series, space, rows, data);
    TRY(release(status, space, H5Sclose, "run.h5"));
    series->rows += rows;
    return STATUS_OK;
}

enum status h5_series_row_read(const struct h5_series *series, hsize_t row, void *data)
{
    const hsize_t start[H5_RANK_MAX] = {row}, count[H5_RANK_MAX] = {1, series->dims[1], series->dims[2]};
    hid_t space = H5Dget_space(series->id), memory = H5Screate_simple(series->rank, count, NULL);
    bool ok = space >= 0 && memory >= 0 && H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) >= 0 &&
              H5Dread(series->id, series->type, memory, space, H5P_DEFAULT, data) >= 0;
    enum status status = release(check(ok, "read", "run.h5"), memory, H5Sclose, "run.h5");
    return release(status, space, H5Sclose, "run.h5");
}

enum status h5_series_close(struct h5_series *series)
{
    hid_t id = series->id;
    series->id = H5I_INVALID_HID;
    return release(STATUS_OK, id, H5Dclose, "run.h5");
}

/* Properties of a dataset that shows one row of another in the same file. */
static bool row_link_properties(hid_t properties, const struct h5_series *series, const char *series_path, hsize_t row,
                                hid_t space)
{
    const hsize_t dims[H5_RANK_MAX] = {series->rows, series->dims[1], series->dims[2]};
    const hsize_t start[H5_RANK_MAX] = {row}, count[H5_RANK_MAX] = {1, series->dims[1], series->dims[2]};
    hid_t source = H5Screate_simple(H5_RANK_MAX, dims, NULL);
    bool ok = source >= 0 && H5Sselect_hyperslab(source, H5S_SELECT_SET, start, NULL, count, NULL) >= 0 &&
              H5Pset_virtual(properties, space, ".", series_path, source) >= 0;
    return source < 0 || (H5Sclose(source) >= 0 && ok);
}

enum status h5_series_row_link(hid_t file, const struct h5_series *series, const char *series_path, hsize_t row,
                               const char *path)
{
    hid_t id = H5I_INVALID_HID, properties = H5Pcreate(H5P_DATASET_CREATE);
    hid_t space = H5Screate_simple(H5_RANK_MAX - 1, series->dims + 1, NULL);
    bool ok = properties >= 0 && space >= 0 && row_link_properties(properties, series, series_path, row, space);
    enum status status = check(ok, "create", path);
    if (status == STATUS_OK)
        status = dataset_create(file, path, series->type, space, properties, &id);
    status = release(status, id, H5Dclose, path);
    status = release(status, space, H5Sclose, path);
    return release(status, properties, H5Pclose, path);
}

/* Creates and writes a dataset, or writes over the one that is there. */
static enum status whole_write(hid_t file, const char *path, hid_t type, hid_t space, const void *data)
{
    hid_t id = H5I_INVALID_HID;
    enum status status = STATUS_OK;
    if (H5Oexists_by_name(file, path, H5P_DEFAULT) > 0)
        status = check((id = H5Dopen2(file, path, H5P_DEFAULT)) >= 0, "open", path);
    else
        status = dataset_create(file, path, type, space, H5P_DEFAULT, &id);
    if (status == STATUS_OK)
        status = check(H5Dwrite(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0, "write", path);
    return release(status, id, H5Dclose, path);
}

static enum status vector_write(hid_t file, const char *path, hid_t type, hsize_t n, const void *data)
{
    hid_t space = n == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &n, NULL);
    enum status status = check(space >= 0, "create", path);
    if (status == STATUS_OK)
        status = whole_write(file, path, type, space, data);
    return release(status, space, H5Sclose, path);
}

enum status h5_vector_write(hid_t file, const char *path, hid_t type, hsize_t n, const void *data, const char *unit)
{
    TRY(vector_write(file, path, type, n, data));
    return h5_attribute_text(file, path, "unit_si", unit);
}

/* A type of texts of `size` bytes, the zero included; to be closed also on failure. */
static enum status text_type(size_t size, H5T_cset_t letters, const char *name, hid_t *type)
{
    *type = H5Tcopy(H5T_C_S1);
    bool ok = *type >= 0 && H5Tset_size(*type, size) >= 0 && H5Tset_cset(*type, letters) >= 0;
    return check(ok, "create", name);
}

enum status h5_text_write(hid_t file, const char *path, const char *text)
{
    hid_t type;
    enum status status = text_type(strlen(text) + 1, H5T_CSET_ASCII, path, &type);
    if (status == STATUS_OK)
        status = vector_write(file, path, type, 0, text);
    return release(status, type, H5Tclose, path);
}

static enum status write_attribute(hid_t file, const char *path, const char *name, hid_t type, hid_t space,
                                   const void *data)
{
    htri_t exists = H5Aexists_by_name(file, path, name, H5P_DEFAULT);
    TRY(check(exists >= 0, "look for the attribute", name));
    if (exists > 0)
        TRY(check(H5Adelete_by_name(file, path, name, H5P_DEFAULT) >= 0, "replace the attribute", name));
    hid_t id = H5Acreate_by_name(file, path, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    TRY(check(id >= 0, "create the attribute", name));
    enum status status = check(H5Awrite(id, type, data) >= 0, "write the attribute", name);
    return release(status, id, H5Aclose, name);
}

enum status h5_attribute_numbers(hid_t file, const char *path, const char *name, hid_t type, hsize_t n,
                                 const void *data)
{
    hid_t space = n == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &n, NULL);
    TRY(check(space >= 0, "create the attribute", name));
    enum status status = write_attribute(file, path, name, type, space, data);
    return release(status, space, H5Sclose, name);
}

enum status h5_attribute_text(hid_t file, const char *path, const char *name, const char *text)
{
    hid_t type;
    enum status status = text_type(strlen(text) + 1, H5T_CSET_UTF8, name, &type);
    if (status == STATUS_OK)
        status = h5_attribute_numbers(file, path, name, type, 0, text);
    return release(status, type, H5Tclose, name);
}

enum status h5_attribute_texts(hid_t file, const char *path, const char *name, const char *const *texts, size_t n)
{
    size_t size = 1;
    hid_t type;
    for (size_t k = 0; k < n; k++)
        size = strlen(texts[k]) + 1 > size ? strlen(texts[k]) + 1 : size;
    char *packed = calloc(n, size);
    if (!packed)
        return status_fail(STATUS_NO_MEMORY, "no memory for the attribute %s", name);
    for (size_t k = 0; k < n; k++)
        memcpy(packed + k * size, texts[k], strlen(texts[k]));
    enum status status = text_type(size, H5T_CSET_UTF8, name, &type);
    if (status == STATUS_OK)
        status = h5_attribute_numbers(file, path, name, type, n, packed);
    free(packed);
    return release(status, type, H5Tclose, name);
}
