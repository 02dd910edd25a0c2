#include "studies/files.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/signals.h"

enum { CHUNK = 65536 };

static enum status stream_read(FILE *file, const char *path, char **text)
{
    size_t size = 0, got;
    do {
        char *larger = realloc(*text, size + CHUNK + 1);
        if (!larger)
            return status_fail(STATUS_NO_MEMORY, "no memory for %s", path);
        *text = larger;
        got = fread(*text + size, 1, CHUNK, file);
        size += got;
    } while (got > 0);
    (*text)[size] = '\0';
    if (ferror(file))
        return status_fail(STATUS_IO, "%s: cannot be read: %s", path, strerror(errno));
    return strlen(*text) == size ? STATUS_OK : status_fail(STATUS_FORMAT, "%s: not a text file", path);
}

enum status files_read(const char *path, char **text)
{
    FILE *file = fopen(path, "rb");
    *text = NULL;
    if (!file)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    enum status status = stream_read(file, path, text);
    (void)fclose(file);
    if (status != STATUS_OK) {
        free(*text);
        *text = NULL;
    }
    return status;
}

enum status files_write(const char *path, const char *text)
{
    char temporary[4096];
    if (snprintf(temporary, sizeof temporary, "%s.new", path) >= (int)sizeof temporary)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", path);
    FILE *file = fopen(temporary, "wb");
    if (!file)
        return status_fail(STATUS_IO, "%s: %s", temporary, strerror(errno));
    bool failed = fputs(text, file) == EOF || fflush(file) != 0 || fsync(fileno(file)) != 0;
    failed = fclose(file) != 0 || failed;
    if (failed || rename(temporary, path) != 0)
        return status_fail(STATUS_IO, "%s: cannot be written: %s", path, strerror(errno));
    return STATUS_OK;
}

enum status files_make_folder(const char *path)
{
    char part[4096];
    if (snprintf(part, sizeof part, "%s", path) >= (int)sizeof part)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", path);
    for (char *slash = strchr(part + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        if (mkdir(part, 0777) != 0 && errno != EEXIST)
            return status_fail(STATUS_IO, "%s: %s", part, strerror(errno));
        *slash = '/';
    }
    if (mkdir(part, 0777) != 0 && errno != EEXIST)
        return status_fail(STATUS_IO, "%s: %s", part, strerror(errno));
    return STATUS_OK;
}

enum status files_remove(const char *path)
{
    if (unlink(path) != 0 && errno != ENOENT)
        return status_fail(STATUS_IO, "%s: cannot be removed: %s", path, strerror(errno));
    return STATUS_OK;
}

bool files_exist(const char *path)
{
    return access(path, F_OK) == 0;
}

enum status files_join(char *path, size_t size, const char *folder, const char *name)
{
    if (snprintf(path, size, "%s/%s", folder, name) >= (int)size)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", folder);
    return STATUS_OK;
}

enum status files_lock(const char *path, int *descriptor)
{
    *descriptor = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (*descriptor < 0)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    while (flock(*descriptor, LOCK_EX | LOCK_NB) != 0) {
        int failure = errno;
        if (failure == EWOULDBLOCK && !stop_requested()) {
            (void)usleep(50000); /* a blocking flock would be restarted after a signal */
            continue;
        }
        (void)close(*descriptor);
        if (failure == EWOULDBLOCK)
            return status_fail(STATUS_INTERRUPTED, "interrupted while waiting for %s", path);
        return status_fail(STATUS_IO, "%s: no lock: %s", path, strerror(failure));
    }
    return STATUS_OK;
}

uint64_t files_hash(const char *text)
{
    uint64_t hash = 14695981039346656037u;
    for (; *text; text++)
        hash = (hash ^ (unsigned char)*text) * 1099511628211u;
    return hash;
}
