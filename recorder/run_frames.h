/* Frames of a run.h5 (docs/file-format.md) for the export: particles and contacts as columns of numbers, whichever of
 * them the file has. What the file says of itself is data: every extent and every index is checked. */
#ifndef SHAKEDOWN_RECORDER_RUN_FRAMES_H
#define SHAKEDOWN_RECORDER_RUN_FRAMES_H

#include <hdf5.h>
#include <stdbool.h>
#include <stdint.h>

#include "common/status.h"

enum { COLUMNS_MAX = 32, COLUMN_NAME_MAX = 64, COLUMN_UNIT_MAX = 32, COLUMN_WIDTH_MAX = 3 };

struct column {
    char name[COLUMN_NAME_MAX]; /* of the dataset: letters, digits, _ */
    char unit[COLUMN_UNIT_MAX]; /* "m/s" */
    int width;                  /* 1 ... COLUMN_WIDTH_MAX */
    bool integer;
    bool fixed;    /* the same in all frames */
    hid_t dataset; /* negative: computed */
    double *value; /* [rows][width] of the frame that was read */
};

struct columns {
    int n;
    int64_t rows; /* of the frame that was read */
    struct column column[COLUMNS_MAX];
};

struct run_frames {
    hid_t file;
    bool complete; /* the recorder proved the run complete */
    int64_t n_frames, n_particles;
    int64_t n_contact_frames;       /* at most n_frames; those after have no contacts in the file */
    double *step, *time_s, *stage;  /* [n_frames] */
    double *box_lo_m, *box_edges_m; /* [n_frames][3], [n_frames][3][3] */
    double *offset;           /* [n_contact_frames + 1]: contacts of frame f are rows offset[f] ... offset[f+1]-1 */
    struct columns particles; /* in the order of id */
    /* The last column, `force` [3], N, is the whole force on i. */
    struct columns contacts;
};

/* Opens `path` for reading, whoever writes it. STATUS_IO if there is no such file, STATUS_FORMAT, naming the dataset,
 * if it is not what docs/file-format.md says. On success to be closed. */
enum status run_frames_open(struct run_frames *run, const char *path) MUST_USE;

/* Reads frame `frame` into the columns' values. STATUS_FORMAT if it cannot be read or an index in it is none. */
enum status run_frames_read(struct run_frames *run, int64_t frame) MUST_USE;

/* The column of that name; NULL if the file has none. */
const struct column *columns_find(const struct columns *columns, const char *name);

/* Ends of contact `row` of the frame that was read, [2][3], m: the centre of i, and the centre of j or the point on the
 * wall. */
void run_frames_contact_ends(const struct run_frames *run, int64_t row, double end_m[2][3]);

/* True if a later frame has the same step: readers want one frame per time. */
bool run_frames_is_superseded(const struct run_frames *run, int64_t frame);

void run_frames_close(struct run_frames *run);

#endif
