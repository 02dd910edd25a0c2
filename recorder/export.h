/* run.h5 for other programs: particles and contacts of all frames as VTK files, tables, or LAMMPS dumps. */
#ifndef SHAKEDOWN_RECORDER_EXPORT_H
#define SHAKEDOWN_RECORDER_EXPORT_H

#include <stdio.h>

#include "recorder/run_frames.h"

enum { EXPORT_FILES_MAX = 3 };

/* An export under way. */
struct export
{
    const char *folder;
    const struct run_frames *run;
    FILE *file[EXPORT_FILES_MAX]; /* open from the first frame to the last; NULL: not used */
};

struct export_format {
    const char *name;                                                    /* "csv" */
    enum status (*begin)(struct export *export) MUST_USE;                /* opens the files */
    enum status (*frame)(struct export *export, int64_t frame) MUST_USE; /* writes the frame that was read */
    enum status (*end)(struct export *export) MUST_USE;                  /* before they are closed */
};

extern const struct export_format export_vtk, export_csv, export_lammps_dump;

/* The format of that name; NULL if there is none. */
const struct export_format *export_format_find(const char *name);

/* Writes all frames of `path` into `folder`, which is made if it is not there, and says to `out` what. STATUS_IO: no
 * file is written over; STATUS_FORMAT: run.h5 is damaged. */
enum status export_run(const char *path, const char *folder, const struct export_format *format, FILE *out) MUST_USE;

/* Opens `name` in the folder of the export for writing; STATUS_IO, also if it is there already. */
enum status export_open(const struct export *export, const char *name, FILE **file) MUST_USE;

/* STATUS_IO if something could not be written. NULL is nothing. */
enum status export_close(FILE *file) MUST_USE;

#endif
