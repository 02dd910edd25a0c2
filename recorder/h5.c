#include "recorder/h5.h"

#include <stdlib.h>
#include <string.h>

/* The innermost entry of HDF5's stack says what the system said. */
static herr_t keep_reason(unsigned depth, const H5E_error2_t *entry, void *reason)
{
    (void)depth;
    snprintf(reason, 256, "%s", entry->desc ? entry->desc : "");
    return 1;
}

static enum status fail(const char *what, const char *path)
{
    char reason[256] = "";
    if (H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_reason, reason) < 0)
        snprintf(reason, sizeof reason, "HDF5 gives no reason");
    return status_fail(STATUS_IO, "cannot %s %s: %s", what, path, reason);
}

/* STATUS_OK if `ok`. */
static enum status check(bool ok, const char *what, const char *path)
{
    return ok ? STATUS_OK : fail(what, path);
}

/* The cache writes metadata when it likes; a kill in between would leave nodes of different ages. */
static bool keep_metadata_until_flush(hid_t access)
{
    H5AC_cache_config_t cache = {.version = H5AC__CURR_CACHE_CONFIG_VERSION};
    if (H5Pget_mdc_config(access, &cache) < 0)
        return false;
    cache.evictions_enabled = 0;
    cache.incr_mode = H5C_incr__off;
    cache.flash_incr_mode = H5C_flash_incr__off;
    cache.decr_mode = H5C_decr__off;
    return H5Pset_mdc_config(access, &cache) >= 0;
}

enum status h5_file_create(const char *path, hid_t *file)
{
    *file = H5I_INVALID_HID;
    (void)H5dont_atexit(); /* fails if HDF5 is in use already, which does no harm */
    if (H5Eset_auto2(H5E_DEFAULT, NULL, NULL) < 0)
        return fail("set up HDF5 for", path);
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    if (access < 0)
        return fail("set up HDF5 for", path);
    bool set = keep_metadata_until_flush(access);
    if (set)
        *file = H5Fcreate(path, H5F_ACC_EXCL, H5P_DEFAULT, access);
    enum status status = check(*file >= 0, "create", path);
    return H5Pclose(access) < 0 && status == STATUS_OK ? fail("create", path) : status;
}

enum status h5_file_flush(hid_t file)
{
    return check(H5Fflush(file, H5F_SCOPE_LOCAL) >= 0, "flush", "run.h5");
}

enum status h5_file_close(hid_t file)
{
    return check(H5Fclose(file) >= 0, "close", "run.h5");
}

/* Link properties that make the groups on the way; negative on failure. */
static hid_t link_with_groups(void)
{
    hid_t properties = H5Pcreate(H5P_LINK_CREATE);
    if (properties >= 0 && H5Pset_create_intermediate_group(properties, 1) < 0) {
        (void)H5Pclose(properties);
        return H5I_INVALID_HID;
    }
    return properties;
}

enum status h5_group_create(hid_t file, const char *path)
{
    hid_t links = link_with_groups();
    hid_t group = links < 0 ? links : H5Gcreate2(file, path, links, H5P_DEFAULT, H5P_DEFAULT);
    enum status status = check(group >= 0, "create the group", path);
    if (group >= 0 && H5Gclose(group) < 0 && status == STATUS_OK)
        status = fail("close the group", path);
    if (links >= 0 && H5Pclose(links) < 0 && status == STATUS_OK)
        status = fail("create the group", path);
    return status;
}

enum status h5_link(hid_t file, const char *target, const char *name)
{
    return check(H5Lcreate_hard(file, target, file, name, H5P_DEFAULT, H5P_DEFAULT) >= 0, "link", name);
}

static hid_t dataset_create(hid_t file, const char *path, hid_t type, hid_t space, hid_t properties)
{
    hid_t links = link_with_groups();
    if (links < 0)
        return links;
    hid_t id = H5Dcreate2(file, path, type, space, links, properties, H5P_DEFAULT);
    return H5Pclose(links) < 0 ? H5I_INVALID_HID : id;
}

/* Dataset properties of a layout; negative on failure. */
static hid_t layout_properties(int rank, const struct h5_layout *layout)
{
    hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
    if (properties < 0)
        return properties;
    bool ok = H5Pset_chunk(properties, rank, layout->chunk) >= 0;
    if (ok && layout->deflate > 0)
        ok = H5Pset_shuffle(properties) >= 0 && H5Pset_deflate(properties, (unsigned)layout->deflate) >= 0;
    if (ok)
        return properties;
    (void)H5Pclose(properties);
    return H5I_INVALID_HID;
}

enum status h5_series_create(hid_t file, const char *path, hid_t type, int rank, const hsize_t *row_dims,
                             const struct h5_layout *layout, const char *unit, struct h5_series *series)
{
    *series = (struct h5_series){.id = H5I_INVALID_HID, .type = type, .rank = rank};
    hsize_t limits[H5_RANK_MAX] = {H5S_UNLIMITED};
    for (int k = 1; k < rank; k++)
        limits[k] = series->dims[k] = row_dims[k - 1];
    hid_t space = H5Screate_simple(rank, series->dims, limits);
    hid_t properties = layout_properties(rank, layout);
    if (space >= 0 && properties >= 0)
        series->id = dataset_create(file, path, type, space, properties);
    enum status status = check(series->id >= 0, "create", path);
    if (properties >= 0 && H5Pclose(properties) < 0 && status == STATUS_OK)
        status = fail("create", path);
    if (space >= 0 && H5Sclose(space) < 0 && status == STATUS_OK)
        status = fail("create", path);
    TRY(status);
    return h5_attribute_text(file, path, "unit_si", unit);
}

static bool write_rows(const struct h5_series *series, hid_t file_space, hsize_t rows, const void *data)
{
    hsize_t start[H5_RANK_MAX] = {series->rows};
    hsize_t count[H5_RANK_MAX] = {rows, series->dims[1], series->dims[2]};
    if (H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start, NULL, count, NULL) < 0)
        return false;
    hid_t memory = H5Screate_simple(series->rank, count, NULL);
    if (memory < 0)
        return false;
    bool ok = H5Dwrite(series->id, series->type, memory, file_space, H5P_DEFAULT, data) >= 0;
    return H5Sclose(memory) >= 0 && ok;
}

enum status h5_series_append(struct h5_series *series, hsize_t rows, const void *data)
{
    if (rows == 0)
        return STATUS_OK;
    hsize_t dims[H5_RANK_MAX] = {series->rows + rows, series->dims[1], series->dims[2]};
    if (H5Dset_extent(series->id, dims) < 0)
        return fail("extend a dataset of", "run.h5");
    hid_t space = H5Dget_space(series->id);
    if (space < 0)
        return fail("write", "run.h5");
    bool ok = write_rows(series, space, rows, data);
    enum status status = check(ok, "write", "run.h5");
    if (H5Sclose(space) < 0 && status == STATUS_OK)
        status = fail("write", "run.h5");
    series->rows += ok ? rows : 0;
    return status;
}

enum status h5_series_close(struct h5_series *series)
{
    hid_t id = series->id;
    series->id = H5I_INVALID_HID;
    return check(id < 0 || H5Dclose(id) >= 0, "close a dataset of", "run.h5");
}

enum status h5_vector_write(hid_t file, const char *path, hid_t type, hsize_t n, const void *data, const char *unit)
{
    hid_t space = H5Screate_simple(1, &n, NULL);
    hid_t id = space < 0 ? space : dataset_create(file, path, type, space, H5P_DEFAULT);
    bool ok = id >= 0 && H5Dwrite(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0;
    enum status status = check(ok, "write", path);
    if (id >= 0 && H5Dclose(id) < 0 && status == STATUS_OK)
        status = fail("write", path);
    if (space >= 0 && H5Sclose(space) < 0 && status == STATUS_OK)
        status = fail("write", path);
    TRY(status);
    return h5_attribute_text(file, path, "unit_si", unit);
}

static bool write_attribute(hid_t file, const char *path, const char *name, hid_t type, hid_t space, const void *data)
{
    htri_t exists = H5Aexists_by_name(file, path, name, H5P_DEFAULT);
    if (exists < 0 || (exists > 0 && H5Adelete_by_name(file, path, name, H5P_DEFAULT) < 0))
        return false;
    hid_t id = H5Acreate_by_name(file, path, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    if (id < 0)
        return false;
    bool ok = H5Awrite(id, type, data) >= 0;
    return H5Aclose(id) >= 0 && ok;
}

enum status h5_attribute_numbers(hid_t file, const char *path, const char *name, hid_t type, hsize_t n,
                                 const void *data)
{
    hid_t space = n == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &n, NULL);
    enum status status = check(space >= 0 && write_attribute(file, path, name, type, space, data), "write", name);
    if (space >= 0 && H5Sclose(space) < 0 && status == STATUS_OK)
        status = fail("write", name);
    return status;
}

/* A type of texts of `size` bytes, the zero included; negative on failure. */
static hid_t text_type(size_t size)
{
    hid_t type = H5Tcopy(H5T_C_S1);
    if (type >= 0 && (H5Tset_size(type, size) < 0 || H5Tset_cset(type, H5T_CSET_UTF8) < 0)) {
        (void)H5Tclose(type);
        return H5I_INVALID_HID;
    }
    return type;
}

enum status h5_attribute_text(hid_t file, const char *path, const char *name, const char *text)
{
    hid_t type = text_type(strlen(text) + 1);
    if (type < 0)
        return fail("write", name);
    enum status status = h5_attribute_numbers(file, path, name, type, 0, text);
    return H5Tclose(type) < 0 && status == STATUS_OK ? fail("write", name) : status;
}

enum status h5_attribute_texts(hid_t file, const char *path, const char *name, const char *const *texts, size_t n)
{
    size_t size = 1;
    for (size_t k = 0; k < n; k++)
        size = strlen(texts[k]) + 1 > size ? strlen(texts[k]) + 1 : size;
    char *packed = calloc(n, size);
    hid_t type = text_type(size);
    enum status status = STATUS_OK;
    if (!packed)
        status = status_fail(STATUS_NO_MEMORY, "no memory for the attribute %s", name);
    for (size_t k = 0; packed && k < n; k++)
        memcpy(packed + k * size, texts[k], strlen(texts[k]));
    if (status == STATUS_OK)
        status = check(type >= 0, "write", name);
    if (status == STATUS_OK)
        status = h5_attribute_numbers(file, path, name, type, n, packed);
    if (type >= 0 && H5Tclose(type) < 0 && status == STATUS_OK)
        status = fail("write", name);
    free(packed);
    return status;
}
