/* frames.csv, particles.csv, contacts.csv: one row per frame, particle, contact, a line of names first. Numbers have
 * all their digits. */
#include <ctype.h>
#include <inttypes.h>
#include <string.h>

#include "recorder/export.h"

enum { FRAMES, PARTICLES, CONTACTS };

/* "m/s^2" as the end of a name: "_m_per_s2". */
static void unit_print(FILE *file, const char *unit)
{
    if (unit[0])
        fputc('_', file);
    for (const char *sign = unit; *sign; sign++) {
        if (*sign == '/')
            fputs("_per_", file);
        else if (isalnum((unsigned char)*sign))
            fputc(tolower((unsigned char)*sign), file);
    }
}

static void names_print(FILE *file, const struct columns *columns)
{
    fputs("frame,step,time_s", file);
    for (int k = 0; k < columns->n; k++) {
        const struct column *column = &columns->column[k];
        for (int axis = 0; axis < column->width; axis++) {
            fprintf(file, ",%s", column->name);
            if (column->width > 1)
                fprintf(file, "_%c", column->width == 2 ? "ij"[axis] : "xyz"[axis]);
            unit_print(file, column->unit);
        }
    }
    fputc('\n', file);
}

static void rows_print(FILE *file, const struct columns *columns, const struct run_frames *run, int64_t frame)
{
    for (int64_t row = 0; row < columns->rows; row++) {
        fprintf(file, "%" PRId64 ",%.0f,%.17g", frame, run->step[frame], run->time_s[frame]);
        for (int k = 0; k < columns->n; k++) {
            const struct column *column = &columns->column[k];
            for (int axis = 0; axis < column->width; axis++)
                fprintf(file, ",%.*g", 17, column->value[row * column->width + axis]);
        }
        fputc('\n', file);
    }
}

static enum status csv_begin(struct export *export)
{
    static const char *const names[] = {"frames.csv", "particles.csv", "contacts.csv"};
    for (int k = 0; k < 3; k++)
        TRY(export_open(export, names[k], &export->file[k]));
    fputs("frame,step,time_s,stage,box_lo_x_m,box_lo_y_m,box_lo_z_m,box_length_x_m,box_length_y_m,box_length_z_m\n",
          export->file[FRAMES]);
    names_print(export->file[PARTICLES], &export->run->particles);
    names_print(export->file[CONTACTS], &export->run->contacts);
    return STATUS_OK;
}

static enum status csv_frame(struct export *export, int64_t frame)
{
    const struct run_frames *run = export->run;
    const double *lo_m = run->box_lo_m + 3 * frame, *edges_m = run->box_edges_m + 9 * frame;
    fprintf(export->file[FRAMES], "%" PRId64 ",%.0f,%.17g,%.0f,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", frame,
            run->step[frame], run->time_s[frame], run->stage[frame], lo_m[0], lo_m[1], lo_m[2], edges_m[0], edges_m[4],
            edges_m[8]);
    rows_print(export->file[PARTICLES], &run->particles, run, frame);
    rows_print(export->file[CONTACTS], &run->contacts, run, frame);
    return STATUS_OK;
}

static enum status csv_end(struct export *export)
{
    (void)export;
    return STATUS_OK;
}

const struct export_format export_csv = {"csv", csv_begin, csv_frame, csv_end};
