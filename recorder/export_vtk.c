/* VTK's XML files: particles_F.vtp (points) and contacts_F.vtp (lines from i to j, or to the point on the wall) for
 * every frame F, and particles.pvd, contacts.pvd, which give them their times; of frames of one time the last. Numbers
 * are base64 within their element: files with appended data are refused by ParaView 5.11 with Debian's updates of
 * libexpat. */
#include <glib.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "recorder/export.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the byte order that the files name");

enum { PARTICLES, CONTACTS };

struct array {
    const char *name;
    int width;
    bool integer;
    const double *value; /* [rows][width] */
    int64_t rows;
};

/* Its size in bytes, and its values. */
static void numbers_write(FILE *file, const struct array *array)
{
    char text[64];
    gint state = 0, save = 0;
    const int64_t values = array->rows * array->width;
    const uint64_t size = sizeof(double) * (uint64_t)values;
    size_t n = g_base64_encode_step((const guchar *)&size, sizeof size, FALSE, text, &state, &save);
    for (int64_t v = 0; v < values; v++) {
        const int64_t integer = array->integer ? (int64_t)array->value[v] : 0;
        const void *value = array->integer ? (const void *)&integer : &array->value[v];
        (void)fwrite(text, 1, n, file); /* export_close finds what failed */
        n = g_base64_encode_step(value, sizeof integer, FALSE, text, &state, &save);
    }
    n += g_base64_encode_close(FALSE, text + n, &state, &save);
    (void)fwrite(text, 1, n, file);
}

static void array_write(FILE *file, const struct array *array)
{
    fprintf(file, "<DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" format=\"binary\">\n",
            array->integer ? "Int64" : "Float64", array->name, array->width);
    numbers_write(file, array);
    fputs("\n</DataArray>\n", file);
}

static void columns_write(FILE *file, const struct columns *columns, const char *without)
{
    for (int k = 0; k < columns->n; k++) {
        const struct column *column = &columns->column[k];
        if (strcmp(column->name, without) != 0)
            array_write(file,
                        &(struct array){column->name, column->width, column->integer, column->value, columns->rows});
    }
}

/* Points, and cells of `corners` points each, in order. */
struct geometry {
    int64_t points, cells;
    int corners;
    const char *cell_name;                        /* "Verts" */
    const double *point_m;                        /* [points][3] */
    const struct columns *point_data, *cell_data; /* NULL: none */
    const char *without;
    double *connectivity, *ends;
};

static void data_write(FILE *file, const char *tag, const struct columns *columns, const char *without)
{
    fprintf(file, "<%s>\n", tag);
    if (columns)
        columns_write(file, columns, without);
    fprintf(file, "</%s>\n", tag);
}

static void geometry_write(FILE *file, const struct geometry *of)
{
    fprintf(file,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
            "header_type=\"UInt64\">\n<PolyData><Piece NumberOfPoints=\"%" PRId64 "\" NumberOf%s=\"%" PRId64 "\">\n",
            of->points, of->cell_name, of->cells);
    data_write(file, "PointData", of->point_data, of->without);
    data_write(file, "CellData", of->cell_data, of->without);
    fputs("<Points>\n", file);
    array_write(file, &(struct array){"Points", 3, false, of->point_m, of->points});
    fprintf(file, "</Points>\n<%s>\n", of->cell_name);
    array_write(file, &(struct array){"connectivity", 1, true, of->connectivity, of->points});
    array_write(file, &(struct array){"offsets", 1, true, of->ends, of->cells});
    fprintf(file, "</%s>\n</Piece></PolyData>\n</VTKFile>\n", of->cell_name);
}

static enum status geometry_save(const struct export *export, const char *name, struct geometry *of)
{
    FILE *file = NULL;
    enum status status = STATUS_OK;
    of->connectivity = malloc((size_t)(of->points + 1) * sizeof(double));
    of->ends = malloc((size_t)(of->cells + 1) * sizeof(double));
    if (!of->connectivity || !of->ends)
        status = status_fail(STATUS_NO_MEMORY, "out of memory");
    if (status == STATUS_OK)
        status = export_open(export, name, &file);
    if (status == STATUS_OK) {
        for (int64_t k = 0; k < of->points; k++)
            of->connectivity[k] = (double)k;
        for (int64_t k = 0; k < of->cells; k++)
            of->ends[k] = (double)((k + 1) * of->corners);
        geometry_write(file, of);
        status = export_close(file);
    }
    free(of->connectivity);
    free(of->ends);
    return status;
}

static enum status particles_save(const struct export *export, const char *name)
{
    const struct run_frames *run = export->run;
    struct geometry geometry = {.points = run->n_particles,
                                .cells = run->n_particles,
                                .corners = 1,
                                .cell_name = "Verts",
                                .point_m = columns_find(&run->particles, "position")->value,
                                .point_data = &run->particles,
                                .without = "position"};
    return geometry_save(export, name, &geometry);
}

static enum status contacts_save(const struct export *export, const char *name)
{
    const struct run_frames *run = export->run;
    const int64_t n = run->contacts.rows;
    double(*ends_m)[2][3] = malloc((size_t)(n + 1) * sizeof *ends_m);
    if (!ends_m)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    for (int64_t row = 0; row < n; row++)
        run_frames_contact_ends(run, row, ends_m[row]);
    struct geometry geometry = {.points = 2 * n,
                                .cells = n,
                                .corners = 2,
                                .cell_name = "Lines",
                                .point_m = &ends_m[0][0][0],
                                .cell_data = &run->contacts,
                                .without = ""};
    enum status status = geometry_save(export, name, &geometry);
    free(ends_m);
    return status;
}

static enum status vtk_begin(struct export *export)
{
    static const char *const names[] = {"particles.pvd", "contacts.pvd"};
    for (int k = 0; k < 2; k++) {
        TRY(export_open(export, names[k], &export->file[k]));
        fputs("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n",
              export->file[k]);
    }
    return STATUS_OK;
}

static enum status vtk_frame(struct export *export, int64_t frame)
{
    static const char *const names[] = {"particles", "contacts"};
    const struct run_frames *run = export->run;
    for (int k = PARTICLES; k <= CONTACTS; k++) {
        char name[64];
        if (k == CONTACTS && frame >= run->n_contact_frames)
            break;
        snprintf(name, sizeof name, "%s_%06" PRId64 ".vtp", names[k], frame);
        TRY(k == PARTICLES ? particles_save(export, name) : contacts_save(export, name));
        if (!run_frames_is_superseded(run, frame))
            fprintf(export->file[k], "<DataSet timestep=\"%.17g\" part=\"0\" file=\"%s\"/>\n", run->time_s[frame],
                    name);
    }
    return STATUS_OK;
}

static enum status vtk_end(struct export *export)
{
    for (int k = PARTICLES; k <= CONTACTS; k++)
        fputs("</Collection>\n</VTKFile>\n", export->file[k]);
    return STATUS_OK;
}

const struct export_format export_vtk = {"vtk", vtk_begin, vtk_frame, vtk_end};
