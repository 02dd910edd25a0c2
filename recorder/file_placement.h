/* Files that are there whole or not at all: written beside their place, brought to disk, renamed. */
#ifndef SHAKEDOWN_RECORDER_FILE_PLACEMENT_H
#define SHAKEDOWN_RECORDER_FILE_PLACEMENT_H

#include "common/status.h"

/* Brings `from` to disk and renames it to `to` in the same folder. STATUS_IO on failure; `to` is then as it was. */
enum status file_into_place(const char *from, const char *to) MUST_USE;

/* The same with a copy of `from`, by way of `to`.new. */
enum status file_copy_into_place(const char *from, const char *to) MUST_USE;

#endif
