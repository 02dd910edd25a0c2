/* LAMMPS' text dumps: particles.dump (dump custom), contacts.dump and wall_contacts.dump (dump local). LAMMPS counts
 * atoms from 1: its id is ours plus 1. Of frames of one step the last, as its readers want the steps to grow. */
#include <inttypes.h>
#include <string.h>

#include "recorder/export.h"

enum { ATOMS, PAIRS, WALLS };

/* Ours, and what LAMMPS calls its components. */
static const struct {
    const char *ours, *theirs[COLUMN_WIDTH_MAX];
} atom_columns[] = {{"mass", {"mass"}},
                    {"radius", {"radius"}},
                    {"position", {"x", "y", "z"}},
                    {"velocity", {"vx", "vy", "vz"}},
                    {"angular_velocity", {"omegax", "omegay", "omegaz"}}};

enum { ATOM_COLUMNS = sizeof atom_columns / sizeof *atom_columns };

static void head_print(FILE *file, const struct run_frames *run, int64_t frame, const char *what, int64_t rows)
{
    const double *lo_m = run->box_lo_m + 3 * frame, *edges_m = run->box_edges_m + 9 * frame;
    fprintf(file, "ITEM: TIMESTEP\n%.0f\nITEM: NUMBER OF %s\n%" PRId64 "\nITEM: BOX BOUNDS ff ff ff\n",
            run->step[frame], what, rows);
    for (int axis = 0; axis < 3; axis++)
        fprintf(file, "%.17g %.17g\n", lo_m[axis], lo_m[axis] + edges_m[4 * axis]);
}

static void values_print(FILE *file, const struct column *column, int64_t row)
{
    for (int axis = 0; axis < column->width; axis++)
        fprintf(file, " %.17g", column->value[row * column->width + axis]);
}

static void atoms_print(FILE *file, const struct run_frames *run, int64_t frame)
{
    const struct column *columns[ATOM_COLUMNS];
    head_print(file, run, frame, "ATOMS", run->n_particles);
    fputs("ITEM: ATOMS id type", file);
    for (int k = 0; k < ATOM_COLUMNS; k++) {
        columns[k] = columns_find(&run->particles, atom_columns[k].ours);
        for (int axis = 0; columns[k] && axis < columns[k]->width; axis++)
            fprintf(file, " %s", atom_columns[k].theirs[axis] ? atom_columns[k].theirs[axis] : "?");
    }
    fputc('\n', file);
    for (int64_t row = 0; row < run->n_particles; row++) {
        fprintf(file, "%" PRId64 " 1", row + 1);
        for (int k = 0; k < ATOM_COLUMNS; k++) {
            if (columns[k])
                values_print(file, columns[k], row);
        }
        fputc('\n', file);
    }
}

static void entry_names_print(FILE *file, const struct columns *contacts)
{
    fputs("index", file);
    for (int k = 0; k < contacts->n; k++) {
        const struct column *column = &contacts->column[k];
        if (strcmp(column->name, "pair") == 0)
            fputs(" batom1 batom2", file);
        for (int axis = 0; strcmp(column->name, "pair") != 0 && axis < column->width; axis++)
            fprintf(file, column->width > 1 ? " %s[%d]" : " %s", column->name, axis + 1);
    }
    fputc('\n', file);
}

static void entry_print(FILE *file, const struct columns *contacts, int64_t row, int64_t index)
{
    fprintf(file, "%" PRId64, index);
    for (int k = 0; k < contacts->n; k++) {
        const struct column *column = &contacts->column[k];
        if (strcmp(column->name, "pair") != 0) {
            values_print(file, column, row);
            continue;
        }
        const double *pair = column->value + 2 * row;
        fprintf(file, " %.0f %.0f", pair[0] + 1.0, pair[1] < 0.0 ? pair[1] : pair[1] + 1.0);
    }
    fputc('\n', file);
}

static void entries_print(FILE *file, const struct run_frames *run, int64_t frame, bool walls)
{
    const struct columns *contacts = &run->contacts;
    const double *pair = columns_find(contacts, "pair")->value;
    int64_t count = 0;
    for (int64_t row = 0; row < contacts->rows; row++)
        count += (pair[2 * row + 1] < 0.0) == walls;
    head_print(file, run, frame, "ENTRIES", count);
    fputs("ITEM: ENTRIES ", file);
    entry_names_print(file, contacts);
    int64_t index = 0;
    for (int64_t row = 0; row < contacts->rows; row++) {
        if ((pair[2 * row + 1] < 0.0) == walls)
            entry_print(file, contacts, row, ++index);
    }
}

static enum status lammps_begin(struct export *export)
{
    static const char *const names[] = {"particles.dump", "contacts.dump", "wall_contacts.dump"};
    for (int k = 0; k < 3; k++)
        TRY(export_open(export, names[k], &export->file[k]));
    return STATUS_OK;
}

static enum status lammps_frame(struct export *export, int64_t frame)
{
    const struct run_frames *run = export->run;
    if (run_frames_is_superseded(run, frame))
        return STATUS_OK;
    atoms_print(export->file[ATOMS], run, frame);
    if (frame < run->n_contact_frames) {
        entries_print(export->file[PAIRS], run, frame, false);
        entries_print(export->file[WALLS], run, frame, true);
    }
    return STATUS_OK;
}

static enum status lammps_end(struct export *export)
{
    (void)export;
    return STATUS_OK;
}

const struct export_format export_lammps_dump = {"lammps-dump", lammps_begin, lammps_frame, lammps_end};
