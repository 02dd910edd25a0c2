/* The few HDF5 operations the recorder needs, with every return checked: STATUS_IO and a message with HDF5's own
 * innermost reason ("No space left on device") on failure. */
#ifndef SHAKEDOWN_RECORDER_H5_H
#define SHAKEDOWN_RECORDER_H5_H

#include <hdf5.h>
#include <stdbool.h>

#include "common/status.h"

enum { H5_RANK_MAX = 3 };

/* An open dataset that grows along its first axis. */
struct h5_series {
    hid_t id;                  /* negative: not open */
    hid_t type;                /* type in memory; a predefined one, not owned */
    int rank;                  /* 1 ... H5_RANK_MAX */
    hsize_t rows;              /* rows in the file */
    hsize_t dims[H5_RANK_MAX]; /* dims[1...]: shape of a row */
};

/* How the rows of a series lie in the file. */
struct h5_layout {
    hsize_t chunk[H5_RANK_MAX];
    int deflate; /* level 1 ... 9 with shuffle; 0: not compressed */
};

/* Creates `path`; STATUS_IO if it exists. Also stops HDF5 from printing its errors and from closing files at exit
 * (which may never end on a full disk). */
enum status h5_file_create(const char *path, hid_t *file) MUST_USE;

/* What was written so far makes a whole file, of which a copy may be taken. */
enum status h5_file_flush(hid_t file) MUST_USE;

/* Closes the file. Everything opened in it must be closed. */
enum status h5_file_close(hid_t file) MUST_USE;

/* For a file that cannot be written: gives its room on the disk back and leaves it to the end of the process, as
 * closing would try to write. Negative: nothing. */
void h5_file_abandon(hid_t file);

/* Creates a group with the groups on its way. */
enum status h5_group_create(hid_t file, const char *path) MUST_USE;

/* A second name for an object. */
enum status h5_link(hid_t file, const char *target, const char *name) MUST_USE;

/* Creates (with the groups on its way) a series without rows; `row_dims` [rank-1] is the shape of a row; `unit` becomes
 * the attribute unit_si. The dataset stays open until h5_series_close. */
enum status h5_series_create(hid_t file, const char *path, hid_t type, int rank, const hsize_t *row_dims,
                             const struct h5_layout *layout, const char *unit, struct h5_series *series) MUST_USE;

/* Appends `rows` rows from `data` [rows][row_dims...]. */
enum status h5_series_append(struct h5_series *series, hsize_t rows, const void *data) MUST_USE;

/* Reads row `row`, which is written. */
enum status h5_series_row_read(const struct h5_series *series, hsize_t row, void *data) MUST_USE;
enum status h5_series_close(struct h5_series *series) MUST_USE;

/* Gives row `row` of a series of rank 3, already written, a path of its own (a virtual dataset, no copy), for readers
 * that know no slices. */
enum status h5_series_row_link(hid_t file, const struct h5_series *series, const char *series_path, hsize_t row,
                               const char *path) MUST_USE;

/* Writes a dataset of fixed shape [n] (n = 0: a scalar), over the one that is there. */
enum status h5_vector_write(hid_t file, const char *path, hid_t type, hsize_t n, const void *data,
                            const char *unit) MUST_USE;

/* The same for one text. Its bytes are UTF-8, its type says ASCII: Octave refuses the other. */
enum status h5_text_write(hid_t file, const char *path, const char *text) MUST_USE;

/* Creates or overwrites an attribute of the object at `path`: [n] numbers (n = 0: a scalar), a text, [n] texts.
 * Texts are of fixed length, ended by a zero, UTF-8. */
enum status h5_attribute_numbers(hid_t file, const char *path, const char *name, hid_t type, hsize_t n,
                                 const void *data) MUST_USE;
enum status h5_attribute_text(hid_t file, const char *path, const char *name, const char *text) MUST_USE;
enum status h5_attribute_texts(hid_t file, const char *path, const char *name, const char *const *texts,
                               size_t n) MUST_USE;

#endif
