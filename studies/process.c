#include "studies/process.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

static void become(const char *const *argv, const char *folder, const char *log, bool own_group, pid_t parent)
{
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent || (own_group && setpgid(0, 0) != 0))
        _exit(126);
    int out = open(log, O_WRONLY | O_CREAT | O_APPEND, 0666), nothing = open("/dev/null", O_RDONLY);
    if (out < 0 || nothing < 0 || dup2(nothing, 0) < 0 || dup2(out, 1) < 0 || dup2(out, 2) < 0)
        _exit(126);
    if (folder && chdir(folder) != 0)
        _exit(126);
    /* argv is not written to: execvp's type is older than const */
    execvp(argv[0], (char *const *)(uintptr_t)argv);
    _exit(127);
}

enum status process_start(const char *const *argv, const char *folder, const char *log, bool own_group, pid_t *started)
{
    pid_t parent = getpid(), pid = fork();
    if (pid < 0)
        return status_fail(STATUS_IO, "%s cannot be started: %s", argv[0], strerror(errno));
    if (pid == 0)
        become(argv, folder, log, own_group, parent);
    if (own_group)
        (void)setpgid(pid, pid); /* whoever is first; the child may have gone on already */
    *started = pid;
    return STATUS_OK;
}

static int code_of(int state)
{
    return WIFEXITED(state) ? WEXITSTATUS(state) : 128 + WTERMSIG(state);
}

enum status process_wait(pid_t pid, int *code)
{
    int state;
    while (waitpid(pid, &state, 0) < 0)
        if (errno != EINTR)
            return status_fail(STATUS_IO, "waiting for a program: %s", strerror(errno));
    *code = code_of(state);
    return STATUS_OK;
}

enum status process_poll(pid_t pid, bool *ended, int *code)
{
    int state;
    pid_t got = waitpid(pid, &state, WNOHANG);
    if (got < 0 && errno != EINTR)
        return status_fail(STATUS_IO, "waiting for a program: %s", strerror(errno));
    *ended = got == pid;
    if (*ended)
        *code = code_of(state);
    return STATUS_OK;
}

enum status process_run(const char *const *argv, const char *folder, const char *log, int *code)
{
    pid_t pid = 0;
    TRY(process_start(argv, folder, log, false, &pid));
    return process_wait(pid, code);
}

bool process_exists(const char *name)
{
    char path[4096];
    const char *part = getenv("PATH");
    while (part && *part) {
        size_t length = strcspn(part, ":");
        if (snprintf(path, sizeof path, "%.*s/%s", (int)length, part, name) < (int)sizeof path &&
            access(path, X_OK) == 0)
            return true;
        part += length + (part[length] == ':');
    }
    return false;
}
