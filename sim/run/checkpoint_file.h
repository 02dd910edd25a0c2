/* The file of a checkpoint: 512 bytes that say length and hash, then an HDF5 file. It is made and read in memory, so
 * that a full disk fails one plain write, and damage is seen before HDF5 looks at it. HDF5's tools find what is behind
 * the first 512 bytes by themselves. */
#ifndef SHAKEDOWN_SIM_RUN_CHECKPOINT_FILE_H
#define SHAKEDOWN_SIM_RUN_CHECKPOINT_FILE_H

#include <hdf5.h>
#include <stdbool.h>
#include <stddef.h>

#include "common/status.h"

enum checkpoint_type { CHECKPOINT_I32, CHECKPOINT_I64, CHECKPOINT_F32, CHECKPOINT_F64 };

size_t checkpoint_type_size(enum checkpoint_type type);

/* An HDF5 file in memory, empty. Close it with checkpoint_image_close. */
enum status checkpoint_image_create(hid_t *file) MUST_USE;
void checkpoint_image_close(hid_t file);

/* One dataset at `path` (groups on the way are made): [count] numbers, or a text. */
enum status checkpoint_put(hid_t file, const char *path, enum checkpoint_type type, size_t count,
                           const void *data) MUST_USE;
enum status checkpoint_put_text(hid_t file, const char *path, const char *text) MUST_USE;

/* Reads them back; STATUS_FORMAT if there is none of that type and length. checkpoint_count gives the length of one;
 * the text is to be freed. */
enum status checkpoint_get(hid_t file, const char *path, enum checkpoint_type type, size_t count, void *data) MUST_USE;
enum status checkpoint_get_text(hid_t file, const char *path, char **text) MUST_USE;
enum status checkpoint_count(hid_t file, const char *path, size_t *count) MUST_USE;

/* Whether there is something at `path`. */
bool checkpoint_has(hid_t file, const char *path);

/* Brings an image to disk under `path` at once or not at all, and reads it back. Errors as in checkpoint.h. */
enum status checkpoint_image_save(hid_t file, const char *path) MUST_USE;
enum status checkpoint_image_load(const char *path, hid_t *file) MUST_USE;

/* As checkpoint_share of checkpoint.h. */
enum status checkpoint_file_share(const char *path, const char *copy) MUST_USE;

#endif
