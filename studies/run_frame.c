#include "studies/run_frame.h"

#include <hdf5.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static enum status no_memory(void)
{
    return status_fail(STATUS_NO_MEMORY, "out of memory");
}

static enum status wrong(const char *name)
{
    return status_fail(STATUS_FORMAT, "run.h5: %s is missing or not as it should be", name);
}

/* Rows [first, first + rows) of a dataset of `width` numbers a row, whatever they are stored as. */
static enum status rows_read(hid_t file, const char *name, hid_t type, hsize_t first, hsize_t rows, hsize_t width,
                             void *values)
{
    hsize_t start[2] = {first, 0}, count[2] = {rows, width}, extent[2] = {0, 1};
    hid_t data = H5Dopen2(file, name, H5P_DEFAULT);
    hid_t space = data < 0 ? -1 : H5Dget_space(data), memory = H5Screate_simple(2, count, NULL);
    int rank = space < 0 ? -1 : H5Sget_simple_extent_ndims(space);
    herr_t failed = rank < 1 || rank > 3 ? -1 : 0;
    hsize_t sizes[3] = {0, 1, 1}, starts[3] = {0}, counts[3];
    if (failed == 0 && H5Sget_simple_extent_dims(space, sizes, NULL) < 0)
        failed = -1;
    extent[0] = sizes[0];
    extent[1] = sizes[1] * sizes[2];
    memcpy(counts, sizes, sizeof counts);
    starts[0] = start[0];
    counts[0] = count[0];
    if (failed == 0 && (extent[1] != width || first > extent[0] || rows > extent[0] - first))
        failed = -1;
    if (failed == 0 && rows > 0)
        failed = H5Sselect_hyperslab(space, H5S_SELECT_SET, starts, NULL, counts, NULL) < 0
                     ? -1
                     : H5Dread(data, type, memory, space, H5P_DEFAULT, values);
    if (memory >= 0)
        (void)H5Sclose(memory);
    if (space >= 0)
        (void)H5Sclose(space);
    if (data >= 0)
        (void)H5Dclose(data);
    return failed < 0 ? wrong(name) : STATUS_OK;
}

static hsize_t rows_of(hid_t file, const char *name)
{
    hsize_t sizes[3] = {0};
    hid_t data = H5Dopen2(file, name, H5P_DEFAULT), space = data < 0 ? -1 : H5Dget_space(data);
    if (space >= 0 && H5Sget_simple_extent_ndims(space) <= 3 && H5Sget_simple_extent_dims(space, sizes, NULL) < 0)
        sizes[0] = 0;
    if (space >= 0)
        (void)H5Sclose(space);
    if (data >= 0)
        (void)H5Dclose(data);
    return sizes[0];
}

/* The number of the frame; its strain. */
static enum status frame_choose(hid_t file, int stage, int axis, double peak, enum frame_moment moment, hsize_t *chosen,
                                double *strain)
{
    hsize_t n = rows_of(file, "/frames/stage");
    int *stages = calloc(n + 1, sizeof *stages);
    double *edges = calloc(9 * n + 1, sizeof *edges), nearest = INFINITY, first = NAN;
    enum status status = stages && edges ? STATUS_OK : no_memory();
    if (status == STATUS_OK)
        status = rows_read(file, "/frames/stage", H5T_NATIVE_INT, 0, n, 1, stages);
    if (status == STATUS_OK)
        status = rows_read(file, "/particles/trajectory/box/edges/value", H5T_NATIVE_DOUBLE, 0, n, 9, edges);
    for (hsize_t k = 0; status == STATUS_OK && k < n; k++) {
        if (stages[k] != stage)
            continue;
        if (isnan(first))
            first = edges[9 * k + 4 * (hsize_t)axis];
        double at = 1 - edges[9 * k + 4 * (hsize_t)axis] / first;
        double off = moment == MOMENT_START ? (double)k : moment == MOMENT_END ? -(double)k : fabs(at - peak);
        if (off < nearest) {
            nearest = off;
            *chosen = k;
            *strain = at;
        }
    }
    free(stages);
    free(edges);
    if (status == STATUS_OK && !isfinite(nearest))
        return status_fail(STATUS_FORMAT, "there is no such frame of the stage");
    return status;
}

static enum status particles_read(hid_t file, hsize_t k, struct frame *frame)
{
    hsize_t n = rows_of(file, "/particles/trajectory/radius");
    double edges[9]; /* of the box, along the diagonal */
    frame->n_particles = (int)n;
    frame->position_m = calloc(3 * n + 1, sizeof *frame->position_m);
    frame->radius_m = calloc(n + 1, sizeof *frame->radius_m);
    frame->force_n = calloc(n + 1, sizeof *frame->force_n);
    if (!frame->position_m || !frame->radius_m || !frame->force_n)
        return no_memory();
    TRY(rows_read(file, "/particles/trajectory/radius", H5T_NATIVE_DOUBLE, 0, n, 1, frame->radius_m));
    TRY(rows_read(file, "/particles/trajectory/position/value", H5T_NATIVE_DOUBLE, k, 1, 3 * n, frame->position_m));
    TRY(rows_read(file, "/frames/box_lo", H5T_NATIVE_DOUBLE, k, 1, 3, frame->lower_m));
    TRY(rows_read(file, "/particles/trajectory/box/edges/value", H5T_NATIVE_DOUBLE, k, 1, 9, edges));
    for (int d = 0; d < 3; d++)
        frame->upper_m[d] = frame->lower_m[d] + edges[4 * d];
    return STATUS_OK;
}

/* Ids are 1 ... N or 0 ... N - 1 in the order of the particles' arrays: looked up. */
static enum status index_make(hid_t file, int n, int **index, int *most)
{
    int *id = calloc((size_t)n + 1, sizeof *id);
    enum status status =
        id ? rows_read(file, "/particles/trajectory/id", H5T_NATIVE_INT, 0, (hsize_t)n, 1, id) : no_memory();
    *most = 0;
    for (int k = 0; status == STATUS_OK && k < n; k++) {
        if (id[k] < 0 || id[k] > 2 * n)
            status = wrong("/particles/trajectory/id");
        *most = id[k] > *most ? id[k] : *most;
    }
    *index = status == STATUS_OK ? calloc((size_t)*most + 1, sizeof **index) : NULL;
    if (status == STATUS_OK && !*index)
        status = no_memory();
    for (int k = 0; status == STATUS_OK && k < n; k++)
        (*index)[id[k]] = k;
    free(id);
    return status;
}

static enum status contact_set(struct frame *frame, int c, const int pair[2], const double *normal, double force,
                               const int *index, int most)
{
    if (pair[0] < 0 || pair[0] > most || pair[1] > most)
        return wrong("/connectivity/contacts/pair");
    int i = index[pair[0]], j = pair[1] < 0 ? -1 : index[pair[1]];
    frame->contact[c] = (struct frame_contact){i, j, {normal[0], normal[1], normal[2]}, force};
    frame->force_n[i] += fabs(force);
    if (j >= 0)
        frame->force_n[j] += fabs(force);
    return STATUS_OK;
}

static enum status contacts_read(hid_t file, hsize_t k, struct frame *frame)
{
    long long offset[2];
    int *index = NULL, most = 0;
    TRY(rows_read(file, "/connectivity/contacts/offset", H5T_NATIVE_LLONG, k, 2, 1, offset));
    if (offset[0] < 0 || offset[1] < offset[0] || offset[1] - offset[0] > 1000LL * frame->n_particles)
        return wrong("/connectivity/contacts/offset");
    hsize_t first = (hsize_t)offset[0], n = (hsize_t)(offset[1] - offset[0]);
    int *pair = calloc(2 * n + 1, sizeof *pair);
    double *normal = calloc(3 * n + 1, sizeof *normal), *force = calloc(n + 1, sizeof *force);
    frame->contact = calloc(n + 1, sizeof *frame->contact);
    enum status status =
        pair && normal && force && frame->contact ? index_make(file, frame->n_particles, &index, &most) : no_memory();
    if (status == STATUS_OK)
        status = rows_read(file, "/connectivity/contacts/pair", H5T_NATIVE_INT, first, n, 2, pair);
    if (status == STATUS_OK)
        status = rows_read(file, "/connectivity/contacts/normal", H5T_NATIVE_DOUBLE, first, n, 3, normal);
    if (status == STATUS_OK)
        status = rows_read(file, "/connectivity/contacts/normal_force", H5T_NATIVE_DOUBLE, first, n, 1, force);
    for (int c = 0; status == STATUS_OK && c < (int)n; c++)
        status = contact_set(frame, c, pair + 2 * c, normal + 3 * c, force[c], index, most);
    frame->n_contacts = (int)n;
    free(index);
    free(pair);
    free(normal);
    free(force);
    return status;
}

static bool is_flat(const struct frame *frame)
{
    for (int k = 1; k < frame->n_particles; k++)
        if (frame->position_m[3 * k + 1] != frame->position_m[1])
            return false;
    return true;
}

enum status frame_read(struct frame *frame, const char *path, int stage, int axis, double peak,
                       enum frame_moment moment)
{
    hsize_t k = 0;
    memset(frame, 0, sizeof *frame);
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file < 0)
        return status_fail(STATUS_IO, "%s: cannot be opened", path);
    enum status status = frame_choose(file, stage, axis, peak, moment, &k, &frame->strain);
    if (status == STATUS_OK)
        status = particles_read(file, k, frame);
    if (status == STATUS_OK)
        status = contacts_read(file, k, frame);
    (void)H5Fclose(file);
    if (status == STATUS_OK)
        frame->dimension = is_flat(frame) ? 2 : 3;
    else
        frame_free(frame);
    return status;
}

void frame_free(struct frame *frame)
{
    free(frame->position_m);
    free(frame->radius_m);
    free(frame->force_n);
    free(frame->contact);
    memset(frame, 0, sizeof *frame);
}
