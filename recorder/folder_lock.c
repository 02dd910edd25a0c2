#include "recorder/folder_lock.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

enum status folder_lock(const char *directory, int *lock)
{
    *lock = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (*lock < 0)
        return status_fail(STATUS_IO, "cannot open the folder %s: %s", directory, strerror(errno));
    if (flock(*lock, LOCK_EX | LOCK_NB) == 0)
        return STATUS_OK;
    int reason = errno;
    folder_unlock(*lock);
    *lock = -1;
    if (reason == EWOULDBLOCK)
        return status_fail(STATUS_IO, "another recorder writes into %s", directory);
    return STATUS_OK; /* such as NFS, which locks no folders */
}

void folder_unlock(int lock)
{
    if (lock >= 0)
        close(lock); /* opened for reading: nothing can be lost */
}
