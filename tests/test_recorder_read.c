#include "test_recorder_read.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

hid_t read_open(const char *directory)
{
    char path[128];
    snprintf(path, sizeof path, "%s/run.h5", directory);
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file < 0) {
        fprintf(stderr, "%s does not open\n", path);
        abort();
    }
    return file;
}

static bool exists(hid_t file, const char *path)
{
    char part[256];
    for (const char *slash = strchr(path + 1, '/');; slash = strchr(slash + 1, '/')) {
        snprintf(part, sizeof part, "%.*s", slash ? (int)(slash - path) : (int)strlen(path), path);
        if (H5Lexists(file, part, H5P_DEFAULT) <= 0)
            return false;
        if (!slash)
            return true;
    }
}

long read_rows(hid_t file, const char *path)
{
    hsize_t dims[4];
    if (!exists(file, path))
        return -1;
    hid_t id = H5Dopen2(file, path, H5P_DEFAULT);
    hid_t space = H5Dget_space(id);
    if (space < 0 || H5Sget_simple_extent_dims(space, dims, NULL) < 0)
        abort();
    H5Sclose(space);
    H5Dclose(id);
    return (long)dims[0];
}

double *read_values(hid_t file, const char *path)
{
    hid_t id = H5Dopen2(file, path, H5P_DEFAULT);
    hid_t space = H5Dget_space(id);
    hssize_t n = H5Sget_simple_extent_npoints(space);
    double *values = malloc((size_t)(n > 0 ? n : 1) * sizeof *values);
    if (n < 0 || !values || H5Dread(id, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) {
        fprintf(stderr, "%s cannot be read\n", path);
        abort();
    }
    H5Sclose(space);
    H5Dclose(id);
    return values;
}

double read_attribute(hid_t file, const char *object, const char *name)
{
    double value = NAN;
    if (H5Aexists_by_name(file, object, name, H5P_DEFAULT) <= 0)
        return value;
    hid_t id = H5Aopen_by_name(file, object, name, H5P_DEFAULT, H5P_DEFAULT);
    if (id < 0 || H5Aread(id, H5T_NATIVE_DOUBLE, &value) < 0)
        abort();
    H5Aclose(id);
    return value;
}

bool read_text_is(hid_t file, const char *object, const char *name, const char *expected)
{
    char text[4096] = "";
    hid_t id = H5Aopen_by_name(file, object, name, H5P_DEFAULT, H5P_DEFAULT);
    hid_t type = H5Aget_type(id);
    if (type < 0 || H5Tget_size(type) >= sizeof text || H5Aread(id, type, text) < 0)
        abort();
    H5Tclose(type);
    H5Aclose(id);
    return strcmp(text, expected) == 0;
}
