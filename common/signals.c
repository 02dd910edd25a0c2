#include "common/signals.h"

#include <errno.h>
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static volatile sig_atomic_t stop_requests;
static volatile sig_atomic_t launcher; /* its process id; 0: none */

/* A wish that the launcher does not know of concerns the run: it asks the others in order. */
static void on_stop(int signal_number, siginfo_t *info, void *context)
{
    const int error = errno;
    (void)signal_number;
    (void)context;
    if (stop_requests < SIG_ATOMIC_MAX)
        stop_requests++;
    if (launcher && info->si_pid != launcher && getppid() == launcher)
        (void)kill((pid_t)launcher, SIGUSR1);
    errno = error;
}

static void find_launcher(void)
{
    const char *text = getenv("SHAKEDOWN_LAUNCHER");
    const int pid = text ? atoi(text) : 0;
    launcher = pid > 1 && getppid() == pid ? pid : 0;
}

enum status signals_install(void)
{
    struct sigaction action = {.sa_sigaction = on_stop, .sa_flags = SA_RESTART | SA_SIGINFO};
    sigset_t stops;
    find_launcher();
    /* Each handler holds the other signals back, so that the count cannot be torn. */
    if (sigemptyset(&stops) != 0 || sigaddset(&stops, SIGINT) != 0 || sigaddset(&stops, SIGTERM) != 0 ||
        sigaddset(&stops, SIGHUP) != 0)
        return status_fail(STATUS_IO, "cannot make a signal set: %s", strerror(errno));
    action.sa_mask = stops;
    if (sigaction(SIGINT, &action, NULL) != 0 || sigaction(SIGTERM, &action, NULL) != 0 ||
        sigaction(SIGHUP, &action, NULL) != 0 || sigprocmask(SIG_UNBLOCK, &stops, NULL) != 0)
        return status_fail(STATUS_IO, "cannot install signal handlers: %s", strerror(errno));
    return STATUS_OK;
}

bool stop_requested(void)
{
    return stop_requests > 0;
}

int stop_request_count(void)
{
    return (int)stop_requests;
}
