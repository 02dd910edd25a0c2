#include "launcher/child_log.h"

#include <errno.h>
#include <fcntl.h>
#include <glib.h>
#include <string.h>
#include <unistd.h>

enum status child_log_open(struct child_log *log, const char *path, int *write_end)
{
    int ends[2];
    g_free(log->path);
    *log = (struct child_log){.path = g_strdup(path), .file = -1, .pipe = -1};
    if (pipe2(ends, O_CLOEXEC) != 0)
        return status_fail(STATUS_IO, "cannot make a pipe: %s", strerror(errno));
    if (fcntl(ends[0], F_SETFL, O_NONBLOCK) != 0) {
        close(ends[0]);
        close(ends[1]);
        return status_fail(STATUS_IO, "cannot set up a pipe: %s", strerror(errno));
    }
    log->file = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    log->pipe = ends[0];
    *write_end = ends[1];
    return STATUS_OK;
}

static void tail_add(struct child_log *log, const char *bytes, size_t n)
{
    const size_t room = sizeof log->tail - 1;
    if (n > room) {
        bytes += n - room;
        n = room;
    }
    size_t kept = log->n_tail + n > room ? room - n : log->n_tail;
    memmove(log->tail, log->tail + log->n_tail - kept, kept);
    memcpy(log->tail + kept, bytes, n);
    log->n_tail = kept + n;
    log->tail[log->n_tail] = '\0';
}

/* A disk that is full now may have room for the next words. */
static void file_add(const struct child_log *log, const char *bytes, size_t n)
{
    while (log->file >= 0 && n > 0) {
        ssize_t written = write(log->file, bytes, n);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            return;
        bytes += written;
        n -= (size_t)written;
    }
}

void child_log_take(struct child_log *log)
{
    char bytes[4096];
    while (log->pipe >= 0) {
        ssize_t n = read(log->pipe, bytes, sizeof bytes);
        if (n > 0) {
            tail_add(log, bytes, (size_t)n);
            file_add(log, bytes, (size_t)n);
        } else if (n < 0 && errno == EINTR) {
            continue;
        } else if (n < 0 && errno == EAGAIN) {
            return;
        } else {
            close(log->pipe);
            log->pipe = -1;
        }
    }
}

void child_log_close(struct child_log *log)
{
    child_log_take(log);
    if (log->pipe >= 0)
        close(log->pipe);
    if (log->file >= 0)
        close(log->file);
    log->pipe = log->file = -1;
}

const char *child_log_last_lines(struct child_log *log, int lines)
{
    const char *start = log->tail + log->n_tail;
    while (start > log->tail) {
        if (start[-1] == '\n' && start != log->tail + log->n_tail && --lines == 0)
            break;
        start--;
    }
    return start;
}
