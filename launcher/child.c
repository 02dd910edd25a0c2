#include "launcher/child.h"

#include <errno.h>
#include <fcntl.h>
#include <glib.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

enum status child_become(pid_t parent, char **argv)
{
    if (prctl(PR_SET_PDEATHSIG, SIGTERM) != 0)
        return status_fail(STATUS_IO, "cannot ask for a signal on the launcher's death: %s", strerror(errno));
    if (getppid() != parent)
        return status_fail(STATUS_INTERRUPTED, "the launcher has ended");
    /* When the launcher is killed nobody reads the logs: that shall not end a process before its record is closed. A
     * limit for the size of files shall be an error like a full disk. */
    if (signal(SIGPIPE, SIG_IGN) == SIG_ERR || signal(SIGXFSZ, SIG_IGN) == SIG_ERR)
        return status_fail(STATUS_IO, "cannot ignore signals: %s", strerror(errno));
    execvp(argv[0], argv);
    return status_fail(STATUS_IO, "cannot start %s: %s", argv[0], strerror(errno));
}

/* launcher --exec PID argv... */
static char **argv_around(char *const *argv)
{
    GPtrArray *words = g_ptr_array_new();
    g_ptr_array_add(words, g_strdup("/proc/self/exe"));
    g_ptr_array_add(words, g_strdup("--exec"));
    g_ptr_array_add(words, g_strdup_printf("%d", (int)getpid()));
    for (; *argv; argv++)
        g_ptr_array_add(words, g_strdup(*argv));
    g_ptr_array_add(words, NULL);
    return (char **)g_ptr_array_free(words, FALSE);
}

static int actions_fill(posix_spawn_file_actions_t *actions, const struct child_place *place, int output)
{
    int error = posix_spawn_file_actions_addopen(actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    if (!error && output >= 0)
        error = posix_spawn_file_actions_adddup2(actions, output, STDOUT_FILENO);
    if (!error && output >= 0 && !place->shown)
        error = posix_spawn_file_actions_adddup2(actions, output, STDERR_FILENO);
    if (!error && place->directory)
        error = posix_spawn_file_actions_addchdir_np(actions, place->directory);
    return error;
}

static int attributes_fill(posix_spawnattr_t *attributes)
{
    sigset_t none, all;
    if (sigemptyset(&none) != 0 || sigfillset(&all) != 0)
        return errno;
    int error = posix_spawnattr_setsigmask(attributes, &none);
    if (!error)
        error = posix_spawnattr_setsigdefault(attributes, &all);
    if (!error)
        error = posix_spawnattr_setpgroup(attributes, 0);
    if (!error)
        error = posix_spawnattr_setflags(attributes,
                                         POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    return error;
}

static int spawn(pid_t *pid, char *const *argv, const struct child_place *place, int output)
{
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    int error = posix_spawn_file_actions_init(&actions);
    if (error)
        return error;
    error = posix_spawnattr_init(&attributes);
    if (!error) {
        error = actions_fill(&actions, place, output);
        if (!error)
            error = attributes_fill(&attributes);
        if (!error)
            error = posix_spawn(pid, argv[0], &actions, &attributes, argv, environ);
        posix_spawnattr_destroy(&attributes);
    }
    posix_spawn_file_actions_destroy(&actions);
    return error;
}

enum status child_start(struct child *child, const char *name, char *const *argv, const struct child_place *place)
{
    int output = -1;
    child->name = name;
    child->running = false;
    child->exit_code = 0;
    if (place->log)
        TRY(child_log_open(&child->log, place->log, &output));
    char **words = argv_around(argv);
    int error = spawn(&child->pid, words, place, output);
    g_strfreev(words);
    if (output >= 0)
        close(output);
    if (error) {
        child_log_close(&child->log);
        return status_fail(STATUS_IO, "cannot start %s: %s", name, strerror(error));
    }
    /* Ours and not waited for yet, so the number is still its own. */
    child->pidfd = (int)syscall(SYS_pidfd_open, child->pid, 0);
    if (child->pidfd < 0) {
        error = errno;
        kill(child->pid, SIGKILL);
        waitpid(child->pid, NULL, 0);
        child_log_close(&child->log);
        return status_fail(STATUS_IO, "%s: pidfd_open: %s (Linux 5.4 or later is needed)", name, strerror(error));
    }
    child->running = true;
    return STATUS_OK;
}

void child_signal(const struct child *child, int signal_number)
{
    if (!child->running)
        return;
    /* ESRCH: it has just ended, which the next look will find. */
    (void)syscall(SYS_pidfd_send_signal, child->pidfd, signal_number, NULL, 0);
    (void)syscall(SYS_pidfd_send_signal, child->pidfd, SIGCONT, NULL, 0);
}

bool child_has_ended(struct child *child)
{
    siginfo_t info = {0};
    int found;
    if (!child->running)
        return false;
    do
        found = waitid(P_PIDFD, (id_t)child->pidfd, &info, WEXITED | WNOHANG);
    while (found != 0 && errno == EINTR);
    if (found == 0 && info.si_pid == 0)
        return false;
    /* Not to be had otherwise (found != 0): someone else has waited for it, and its exit code is lost. */
    child->exit_code = info.si_code == CLD_EXITED ? info.si_status : EXIT_CODE_OF_SIGNAL + info.si_status;
    if (found != 0)
        child->exit_code = EXIT_CODE_OF_SIGNAL + SIGKILL;
    close(child->pidfd);
    child->running = false;
    child_log_close(&child->log);
    return true;
}
