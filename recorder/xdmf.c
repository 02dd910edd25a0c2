#include "recorder/xdmf.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "recorder/file_placement.h"

#define TRAJECTORY "run.h5:/particles/trajectory/"

enum status xdmf_frame_add(struct xdmf *xdmf, double time_s)
{
    if (xdmf->n_frames == xdmf->capacity) {
        size_t capacity = xdmf->capacity ? 2 * xdmf->capacity : 64;
        double *grown = realloc(xdmf->time_s, capacity * sizeof *grown);
        if (!grown)
            return status_fail(STATUS_NO_MEMORY, "no memory for %zu frames", capacity);
        xdmf->time_s = grown;
        xdmf->capacity = capacity;
    }
    xdmf->time_s[xdmf->n_frames++] = time_s;
    return STATUS_OK;
}

void xdmf_free(struct xdmf *xdmf)
{
    free(xdmf->time_s);
    *xdmf = (struct xdmf){0};
}

/* The part of a frame, [N][3]. No slice of a dataset: each of ParaView's two readers knows another way to write one. */
static void print_slab(FILE *out, int n, size_t frame, const char *name)
{
    fprintf(out,
            "          <DataItem Dimensions=\"%d 3\" NumberType=\"Float\" Precision=\"8\" "
            "Format=\"HDF\">run.h5:/xdmf/%zu/%s</DataItem>\n",
            n, frame, name);
}

static void print_vector(FILE *out, int n, size_t frame, const char *name)
{
    fprintf(out, "        <Attribute Name=\"%s\" AttributeType=\"Vector\" Center=\"Node\">\n", name);
    print_slab(out, n, frame, name);
    fprintf(out, "        </Attribute>\n");
}

/* An [N] dataset, the same in every frame. */
static void print_constant(FILE *out, int n, const char *name, const char *number)
{
    fprintf(out,
            "        <Attribute Name=\"%s\" AttributeType=\"Scalar\" Center=\"Node\">\n"
            "          <DataItem Dimensions=\"%d\" %s Format=\"HDF\">" TRAJECTORY "%s</DataItem>\n"
            "        </Attribute>\n",
            name, n, number, name);
}

static void print_frame(FILE *out, const struct xdmf *xdmf, const struct run_facts *facts, size_t frame)
{
    int n = facts->n_particles;
    fprintf(out,
            "      <Grid Name=\"frame %zu\" GridType=\"Uniform\">\n"
            "        <Time Value=\"%.17g\"/>\n"
            "        <Topology TopologyType=\"Polyvertex\" NumberOfElements=\"%d\" NodesPerElement=\"1\">\n"
            "          <DataItem Dimensions=\"%d\" NumberType=\"Int\" Precision=\"4\" Format=\"HDF\">" TRAJECTORY
            "id</DataItem>\n"
            "        </Topology>\n"
            "        <Geometry GeometryType=\"XYZ\">\n",
            frame, xdmf->time_s[frame], n, n);
    print_slab(out, n, frame, "position");
    fprintf(out, "        </Geometry>\n");
    print_constant(out, n, "radius", "NumberType=\"Float\" Precision=\"8\"");
    print_constant(out, n, "mass", "NumberType=\"Float\" Precision=\"8\"");
    print_constant(out, n, "id", "NumberType=\"Int\" Precision=\"4\"");
    print_vector(out, n, frame, "velocity");
    if (facts->frictional)
        print_vector(out, n, frame, "angular_velocity");
    fprintf(out, "      </Grid>\n");
}

enum status xdmf_write(const struct xdmf *xdmf, const struct run_facts *facts, const char *path)
{
    char new_path[PATH_MAX];
    if (snprintf(new_path, sizeof new_path, "%s.new", path) >= (int)sizeof new_path)
        return status_fail(STATUS_IO, "the path %s is too long", path);
    FILE *out = fopen(new_path, "w");
    if (!out)
        return status_fail(STATUS_IO, "cannot create %s: %s", new_path, strerror(errno));
    fprintf(out, "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n"
                 "    <Grid Name=\"trajectory\" GridType=\"Collection\" CollectionType=\"Temporal\">\n");
    for (size_t frame = 0; frame < xdmf->n_frames; frame++) {
        const bool is_last_of_its_time = frame + 1 == xdmf->n_frames || xdmf->time_s[frame + 1] > xdmf->time_s[frame];
        if (is_last_of_its_time) /* two of one time show no points in one of the readers */
            print_frame(out, xdmf, facts, frame);
    }
    fprintf(out, "    </Grid>\n  </Domain>\n</Xdmf>\n");
    bool failed = ferror(out) != 0;
    failed |= fclose(out) != 0;
    return failed ? status_fail(STATUS_IO, "cannot write %s: %s", new_path, strerror(errno))
                  : file_into_place(new_path, path);
}
