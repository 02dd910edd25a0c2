#include "common/signals.h"

#include <errno.h>
#include <signal.h>
#include <stdint.h>
#include <string.h>

static volatile sig_atomic_t stop_requests;

static void on_stop(int signal_number)
{
    (void)signal_number;
    if (stop_requests < SIG_ATOMIC_MAX)
        stop_requests++;
}

enum status signals_install(void)
{
    struct sigaction action = {.sa_handler = on_stop, .sa_flags = SA_RESTART};
    sigset_t stops;
    /* Each handler holds the other signal back, so that the count cannot be torn. */
    if (sigemptyset(&stops) != 0 || sigaddset(&stops, SIGINT) != 0 || sigaddset(&stops, SIGTERM) != 0)
        return status_fail(STATUS_IO, "cannot make a signal set: %s", strerror(errno));
    action.sa_mask = stops;
    if (sigaction(SIGINT, &action, NULL) != 0 || sigaction(SIGTERM, &action, NULL) != 0 ||
        sigprocmask(SIG_UNBLOCK, &stops, NULL) != 0)
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
