/* Files and folders of a study. */
#ifndef SHAKEDOWN_STUDIES_FILES_H
#define SHAKEDOWN_STUDIES_FILES_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "common/status.h"

/* A whole file as a string, to be freed. STATUS_IO, STATUS_NO_MEMORY, STATUS_FORMAT (holds a zero byte). */
enum status files_read(const char *path, char **text) MUST_USE;

/* Writes `text` to `path` by way of a temporary file beside it that is brought to disk and renamed: a kill leaves the
 * old content or the new. STATUS_IO. */
enum status files_write(const char *path, const char *text) MUST_USE;

/* Makes a folder, and those above it, unless it is there. STATUS_IO. */
enum status files_make_folder(const char *path) MUST_USE;

/* Removes a file if it is there. STATUS_IO. */
enum status files_remove(const char *path) MUST_USE;

bool files_exist(const char *path);

/* "folder/name" into `path`. STATUS_USAGE if it does not fit. */
enum status files_join(char *path, size_t size, const char *folder, const char *name) MUST_USE;

/* Waits for the lock of `path` (a file that is made) and takes it; it lasts until the descriptor is closed, or the
 * process ends in any way. STATUS_IO; STATUS_INTERRUPTED if a stop was requested while waiting. */
enum status files_lock(const char *path, int *descriptor) MUST_USE;

/* FNV-1a, 64 bits, of a text. */
uint64_t files_hash(const char *text);

#endif
