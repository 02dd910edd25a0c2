/* One recorder per folder. HDF5's own locks are off, as they would keep readers out and readers would stop us. */
#ifndef SHAKEDOWN_RECORDER_FOLDER_LOCK_H
#define SHAKEDOWN_RECORDER_FOLDER_LOCK_H

#include "common/status.h"

/* Locks the folder itself (flock), so that nothing stays behind a kill. STATUS_IO if another process has it; where the
 * file system knows no such lock, none is taken. *lock goes to folder_unlock; negative: none. */
enum status folder_lock(const char *directory, int *lock) MUST_USE;
void folder_unlock(int lock);

#endif
