#include "hdf5_mutation.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum { OBJECTS_MAX = 512, NAME_MAX_LENGTH = 128, ATTRIBUTES_MAX = 256 };

struct objects {
    int n;
    bool is_dataset[OBJECTS_MAX];
    char name[OBJECTS_MAX][NAME_MAX_LENGTH];
};

/* One change: what to whom, with a number. */
struct mutation {
    unsigned kind, object, number, more;
};

static herr_t object_note(hid_t file, const char *name, const H5O_info_t *info, void *user)
{
    struct objects *objects = user;
    (void)file;
    if (objects->n < OBJECTS_MAX && strlen(name) < NAME_MAX_LENGTH) {
        objects->is_dataset[objects->n] = info->type == H5O_TYPE_DATASET;
        snprintf(objects->name[objects->n++], NAME_MAX_LENGTH, "%s", name);
    }
    return 0;
}

static double odd_number(unsigned k)
{
    const double numbers[] = {
        0, -1, 1,   NAN,   INFINITY,     -INFINITY,    1e300,         -1e300,       DBL_MIN, 0.5,     2,
        3, 6,  255, 65536, 2147483647.0, 2147483648.0, -2147483649.0, 4294967296.0, 9.3e18,  -9.3e18, 1e-30};
    return numbers[k % (sizeof numbers / sizeof *numbers)];
}

static hsize_t odd_extent(unsigned k)
{
    static const hsize_t extents[] = {
        0, 1, 2, 3, 7, 100, 65536, 100000001, 1ull << 31, 1ull << 32, 1ull << 40, 1ull << 61, (1ull << 61) + 1};
    return extents[k % (sizeof extents / sizeof *extents)];
}

static hid_t odd_type(unsigned k)
{
    switch (k % 6) {
    case 0:
        return H5Tcopy(H5T_NATIVE_DOUBLE);
    case 1:
        return H5Tcopy(H5T_NATIVE_INT8);
    case 2:
        return H5Tcopy(H5T_NATIVE_UINT64);
    default: {
        hid_t type = H5Tcopy(H5T_C_S1);
        const size_t sizes[] = {1, 700, H5T_VARIABLE};
        if (type >= 0 && H5Tset_size(type, sizes[k % 3]) < 0)
            return type;
        return type;
    }
    }
}

/* Another number somewhere. */
static void value_change(hid_t file, const char *name, const struct mutation *of)
{
    hid_t id = H5Dopen2(file, name, H5P_DEFAULT), space = id < 0 ? id : H5Dget_space(id),
          memory = H5Screate(H5S_SCALAR);
    hsize_t dims[H5S_MAX_RANK] = {0}, at[H5S_MAX_RANK];
    int rank = space < 0 ? -1 : H5Sget_simple_extent_dims(space, dims, NULL);
    bool inside = rank >= 0;
    for (int k = 0; k < rank; k++) {
        inside = inside && dims[k] > 0;
        at[k] = inside ? (k == 0 ? of->more : of->more / 7 + (unsigned)k) % dims[k] : 0;
    }
    const double value = odd_number(of->number);
    if (inside && memory >= 0 && (rank == 0 || H5Sselect_elements(space, H5S_SELECT_SET, 1, at) >= 0))
        (void)(H5Dwrite(id, H5T_NATIVE_DOUBLE, memory, rank == 0 ? H5S_ALL : space, H5P_DEFAULT, &value) >= 0);
    (void)(memory >= 0 && H5Sclose(memory) >= 0);
    (void)(space >= 0 && H5Sclose(space) >= 0);
    (void)(id >= 0 && H5Dclose(id) >= 0);
}

/* HDF5 looks at each chunk of the old extent when one shrinks, whether or not it is in the file: hours, of 1e12. */
static bool may_shrink(const hsize_t *dims, int rank)
{
    double elements = 1;
    for (int k = 0; k < rank; k++)
        elements *= (double)dims[k];
    return elements < 1e6;
}

static void extent_change(hid_t file, const char *name, const struct mutation *of)
{
    hid_t id = H5Dopen2(file, name, H5P_DEFAULT), space = id < 0 ? id : H5Dget_space(id);
    hsize_t dims[H5S_MAX_RANK] = {0};
    const int rank = space < 0 ? -1 : H5Sget_simple_extent_dims(space, dims, NULL);
    if (rank > 0 && may_shrink(dims, rank)) {
        dims[0] = of->number % 4 == 3 ? dims[0] - 1 : odd_extent(of->number);
        (void)(H5Dset_extent(id, dims) >= 0);
    }
    (void)(space >= 0 && H5Sclose(space) >= 0);
    (void)(id >= 0 && H5Dclose(id) >= 0);
}

/* Another dataset in its place: no room is taken for it until something is written. */
static void dataset_replace(hid_t file, const char *name, const struct mutation *of)
{
    const int rank = (int)(of->more % 5);
    const hsize_t dims[4] = {odd_extent(of->number), odd_extent(of->number / 3), of->more % 7, of->more % 3};
    const hsize_t chunk[4] = {1, 1, 1, 1};
    hid_t space = rank == 0   ? H5Screate(H5S_SCALAR)
                  : rank == 4 ? H5Screate(H5S_NULL)
                              : H5Screate_simple(rank, dims, NULL);
    hid_t type = odd_type(of->more / 5), layout = H5Pcreate(H5P_DATASET_CREATE);
    if (layout >= 0 && rank > 0 && rank < 4)
        (void)(H5Pset_chunk(layout, rank, chunk) >= 0);
    if (space >= 0 && type >= 0 && H5Ldelete(file, name, H5P_DEFAULT) >= 0) {
        hid_t id = H5Dcreate2(file, name, type, space, H5P_DEFAULT, layout, H5P_DEFAULT);
        (void)(id >= 0 && H5Dclose(id) >= 0);
    }
    (void)(layout >= 0 && H5Pclose(layout) >= 0);
    (void)(type >= 0 && H5Tclose(type) >= 0);
    (void)(space >= 0 && H5Sclose(space) >= 0);
}

/* An attribute goes, becomes another number, or another text. */
static void attribute_change(hid_t file, const char *name, const struct mutation *of)
{
    char found[NAME_MAX_LENGTH] = "";
    hid_t object = H5Oopen(file, name, H5P_DEFAULT);
    if (object < 0)
        return;
    const int count = H5Aget_num_attrs(object);
    if (count > 0 &&
        H5Aget_name_by_idx(object, ".", H5_INDEX_NAME, H5_ITER_INC, of->more % (unsigned)count, found, sizeof found,
                           H5P_DEFAULT) > 0 &&
        H5Adelete(object, found) >= 0 && of->number % 4 != 0) {
        const hsize_t n = odd_extent(of->number % 5);
        hid_t space = of->number & 8 ? H5Screate_simple(1, &n, NULL) : H5Screate(H5S_SCALAR);
        hid_t type = of->number & 1 ? odd_type(of->number / 2) : H5Tcopy(H5T_NATIVE_DOUBLE);
        hid_t id = type < 0 || space < 0 ? -1 : H5Acreate2(object, found, type, space, H5P_DEFAULT, H5P_DEFAULT);
        const double value = odd_number(of->number / 4);
        if (id >= 0 && n <= 1 && type >= 0 && H5Tget_class(type) == H5T_FLOAT)
            (void)(H5Awrite(id, H5T_NATIVE_DOUBLE, &value) >= 0);
        (void)(id >= 0 && H5Aclose(id) >= 0);
        (void)(type >= 0 && H5Tclose(type) >= 0);
        (void)(space >= 0 && H5Sclose(space) >= 0);
    }
    (void)(H5Oclose(object) >= 0);
}

static void mutation_apply(hid_t file, const struct objects *objects, const struct mutation *of)
{
    const int k = (int)(of->object % (unsigned)objects->n);
    const char *name = objects->name[k];
    if (H5Lexists(file, name, H5P_DEFAULT) <= 0)
        return;
    const unsigned kind = objects->is_dataset[k] ? of->kind % 5 : of->kind % 8 < 6 ? 4 : 3;
    if (kind == 0)
        value_change(file, name, of);
    else if (kind == 1)
        extent_change(file, name, of);
    else if (kind == 2)
        dataset_replace(file, name, of);
    else if (kind == 3)
        (void)(H5Ldelete(file, name, H5P_DEFAULT) >= 0);
    else
        attribute_change(file, name, of);
}

void hdf5_mutate(hid_t file, const uint8_t *data, size_t size)
{
    static struct objects objects;
    objects = (struct objects){.n = 1, .name = {"/"}};
    if (H5Ovisit(file, H5_INDEX_NAME, H5_ITER_INC, object_note, &objects) < 0)
        return;
    for (size_t k = 0; k < MUTATIONS_MAX && (k + 1) * MUTATION_BYTES <= size; k++) {
        const uint8_t *at = data + k * MUTATION_BYTES;
        const struct mutation of = {at[0], at[1] | (unsigned)at[2] << 8, at[3], at[4] | (unsigned)at[5] << 8};
        mutation_apply(file, &objects, &of);
    }
}
