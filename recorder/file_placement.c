#include "recorder/file_placement.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <unistd.h>

/* The name, too, is on disk then. Not all file systems bring folders to disk: EINVAL. */
static bool folder_sync(const char *path)
{
    char folder[PATH_MAX];
    const char *slash = strrchr(path, '/');
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) + 1 : 1, slash ? path : ".");
    int file = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0)
        return false;
    bool ok = fsync(file) == 0 || errno == EINVAL;
    int reason = errno;
    close(file); /* nothing was written through it */
    errno = reason;
    return ok;
}

static bool file_sync(const char *path)
{
    int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0)
        return false;
    bool ok = fsync(file) == 0;
    int reason = errno;
    close(file);
    errno = reason;
    return ok;
}

enum status file_into_place(const char *from, const char *to)
{
    if (!file_sync(from) || rename(from, to) != 0 || !folder_sync(to))
        return status_fail(STATUS_IO, "cannot write %s: %s", to, strerror(errno));
    return STATUS_OK;
}

static bool copy_all(int from, int to)
{
    struct stat file;
    off_t at = 0;
    if (fstat(from, &file) != 0)
        return false;
    while (at < file.st_size) {
        if (sendfile(to, from, &at, (size_t)(file.st_size - at)) <= 0 && errno != EINTR)
            return false;
    }
    return true;
}

static bool copy(const char *from, const char *to)
{
    int source = open(from, O_RDONLY | O_CLOEXEC);
    int target = source < 0 ? -1 : open(to, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666);
    bool ok = target >= 0 && copy_all(source, target);
    int reason = errno;
    if (target >= 0 && close(target) != 0 && ok) {
        ok = false;
        reason = errno;
    }
    if (source >= 0)
        close(source);
    errno = reason;
    return ok;
}

enum status file_copy_into_place(const char *from, const char *to)
{
    char path[PATH_MAX];
    enum status status;
    if (snprintf(path, sizeof path, "%s.new", to) >= (int)sizeof path)
        return status_fail(STATUS_IO, "the path %s is too long", to);
    status = copy(from, path) ? file_into_place(path, to)
                              : status_fail(STATUS_IO, "cannot write %s: %s", path, strerror(errno));
    if (status != STATUS_OK)
        (void)unlink(path); /* its room is wanted */
    return status;
}
