#include "bench/child.h"

#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { LOG_END = 400 }; /* characters of a failed child's log that are shown */

static void become(const struct child *child)
{
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL); /* nothing is left behind if the bench is killed */
    int log = open(child->log, O_WRONLY | O_CREAT | O_TRUNC, 0644), nothing = open("/dev/null", O_RDONLY);
    if (log < 0 || nothing < 0 || dup2(nothing, 0) < 0 || dup2(log, 1) < 0 || dup2(log, 2) < 0)
        _exit(126);
    if (child->folder && chdir(child->folder) != 0)
        _exit(126);
    if (child->variable && setenv(child->variable, child->value, 1) != 0)
        _exit(126);
    /* argv is not written to: execvp's type is older than const */
    execvp(child->argv[0], (char *const *)(uintptr_t)child->argv);
    _exit(127);
}

static enum status failed(const struct child *child, int state)
{
    char *text = NULL;
    if (WIFEXITED(state) && WEXITSTATUS(state) == 127)
        return status_fail(STATUS_IO, "%s cannot be started", child->argv[0]);
    const char *end = "";
    if (file_read(child->log, &text) == STATUS_OK)
        end = strlen(text) > LOG_END ? text + strlen(text) - LOG_END : text;
    enum status status = status_fail(STATUS_IO, "%s failed; the end of %s:\n%s", child->argv[0], child->log, end);
    free(text);
    return status;
}

static double seconds(struct timeval t)
{
    return (double)t.tv_sec + 1e-6 * (double)t.tv_usec;
}

enum status child_start(const struct child *child, pid_t *started)
{
    pid_t pid = fork();
    if (pid < 0)
        return status_fail(STATUS_IO, "%s cannot be started: %s", child->argv[0], strerror(errno));
    if (pid == 0)
        become(child);
    *started = pid;
    return STATUS_OK;
}

enum status child_run(struct child *child)
{
    struct rusage usage;
    pid_t pid = 0;
    int state;
    TRY(child_start(child, &pid));
    while (wait4(pid, &state, 0, &usage) < 0)
        if (errno != EINTR)
            return status_fail(STATUS_IO, "%s: %s", child->argv[0], strerror(errno));
    child->cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
    child->exit_code = WIFEXITED(state) ? WEXITSTATUS(state) : 128;
    return child->exit_code == 0 ? STATUS_OK : failed(child, state);
}

enum status file_read(const char *path, char **text)
{
    FILE *file = fopen(path, "rb");
    size_t size = 0, got;
    *text = NULL;
    if (!file)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    do {
        char *larger = realloc(*text, size + 65536 + 1);
        if (!larger) {
            free(*text);
            *text = NULL;
            fclose(file);
            return status_fail(STATUS_NO_MEMORY, "no memory for %s", path);
        }
        *text = larger;
        got = fread(*text + size, 1, 65536, file);
        size += got;
    } while (got > 0);
    (*text)[size] = 0;
    fclose(file);
    return STATUS_OK;
}

enum status folder_make(const char *path)
{
    if (mkdir(path, 0755) == 0 || errno == EEXIST)
        return STATUS_OK;
    return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
}

enum status pin_to_core(int *core)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) != 0)
        return status_fail(STATUS_IO, "no list of cores: %s", strerror(errno));
    for (*core = CPU_SETSIZE - 1; *core > 0 && !CPU_ISSET(*core, &set);)
        (*core)--;
    CPU_ZERO(&set);
    CPU_SET(*core, &set);
    if (sched_setaffinity(0, sizeof set, &set) != 0)
        return status_fail(STATUS_IO, "core %d cannot be chosen: %s", *core, strerror(errno));
    return STATUS_OK;
}
