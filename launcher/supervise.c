#include <errno.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include "common/bus.h"
#include "launcher/supervisor.h"

/* Signals closer together than this are one wish: a batch system, or a terminal that closes, sends several. */
static const double ONE_WISH_S = 1;
/* Patience with the display. */
static const double WATCH_WAIT_S = 2;

/* SIGHUP stays ignored under nohup. */
enum status supervise_open_signals(struct supervisor *s)
{
    static const int wanted[] = {SIGINT, SIGTERM, SIGUSR1, SIGHUP};
    struct sigaction before;
    sigset_t set;
    char text[32];
    if (sigemptyset(&set) != 0 || sigaction(SIGHUP, NULL, &before) != 0 || signal(SIGXFSZ, SIG_IGN) == SIG_ERR)
        return status_fail(STATUS_IO, "cannot make a signal set: %s", strerror(errno));
    const size_t n = sizeof wanted / sizeof *wanted - (before.sa_handler == SIG_IGN);
    for (size_t k = 0; k < n; k++)
        if (sigaddset(&set, wanted[k]) != 0 || signal(wanted[k], SIG_DFL) == SIG_ERR)
            return status_fail(STATUS_IO, "cannot make a signal set: %s", strerror(errno));
    if (sigprocmask(SIG_BLOCK, &set, NULL) != 0)
        return status_fail(STATUS_IO, "cannot block signals: %s", strerror(errno));
    s->signals = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
    snprintf(text, sizeof text, "%d", (int)getpid());
    if (s->signals < 0 || setenv("SHAKEDOWN_LAUNCHER", text, 1) != 0)
        return status_fail(STATUS_IO, "signalfd: %s", strerror(errno));
    return STATUS_OK;
}

static void take_signals(struct supervisor *s)
{
    struct signalfd_siginfo info;
    while (read(s->signals, &info, sizeof info) == (ssize_t)sizeof info) {
        if (info.ssi_signo == SIGUSR1) { /* from a process that was asked to stop (common/signals.h) */
            stop_interrupt(s);
            continue;
        }
        s->interrupted = true;
        if (s->level == STOP_NONE || clock_now_s() - s->level_at_s >= ONE_WISH_S)
            stop_harder(s);
    }
}

static int timeout_ms(const struct supervisor *s)
{
    const double left_s = s->deadline_s - clock_now_s();
    return left_s == INFINITY ? -1 : left_s <= 0 ? 0 : (int)ceil(1e3 * fmin(left_s, 3600));
}

static void wait_for_event(struct supervisor *s)
{
    struct pollfd fds[1 + 2 * ROLES] = {{.fd = s->signals, .events = POLLIN}};
    nfds_t n = 1;
    for (int role = 0; role < ROLES; role++) {
        if (!supervisor_has(s, role))
            continue;
        fds[n++] = (struct pollfd){.fd = s->child[role].pidfd, .events = POLLIN};
        if (s->child[role].log.pipe >= 0)
            fds[n++] = (struct pollfd){.fd = s->child[role].log.pipe, .events = POLLIN};
    }
    /* An error (a signal, no memory for a moment) only means to look again. */
    (void)poll(fds, n, timeout_ms(s));
}

/* Until all that were started have ended; the display may stay. */
void supervise(struct supervisor *s)
{
    while (supervisor_has_any(s)) {
        wait_for_event(s);
        take_signals(s);
        for (int role = 0; role < ROLES; role++) {
            if (supervisor_has(s, role))
                child_log_take(&s->child[role].log);
            if (child_has_ended(&s->child[role]))
                ends_note(s, role);
        }
        restart_finish(s);
        if (clock_now_s() >= s->deadline_s && supervisor_has_any(s))
            ends_note_overdue(s);
    }
}

void supervise_end_watch(struct supervisor *s)
{
    struct child *watch = &s->child[ROLE_WATCH];
    const double end_s = clock_now_s() + WATCH_WAIT_S;
    child_signal(watch, SIGTERM);
    while (watch->running && !child_has_ended(watch)) {
        struct pollfd fd = {.fd = watch->pidfd, .events = POLLIN};
        const double left_s = end_s - clock_now_s();
        if (left_s <= 0)
            child_signal(watch, SIGKILL);
        (void)poll(&fd, 1, left_s > 0 ? (int)ceil(1e3 * left_s) : 100);
    }
}
