#include "launcher/supervise.h"

#include <errno.h>
#include <glib.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/signalfd.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/bus.h"
#include "launcher/child.h"
#include "launcher/record_state.h"
#include "launcher/report.h"
#include "launcher/restarts.h"

/* Waits before the next, harder way of ending processes. Together with the one for sim they stay below 15 s. */
static const double FINISH_WAIT_S = 120; /* recorder and controller, after sim is done */
static const double CLOSE_WAIT_S = 4;    /* the same, in a run that was told to stop */
static const double HARD_WAIT_S = 2;     /* all, after they were asked in vain */
static const double RESTART_WAIT_S = 10; /* the recorder closes a file that it will open again */
/* Signals closer together than this are one wish: a batch system, or a terminal that closes, sends several. */
static const double ONE_WISH_S = 1;

/* How hard the processes have been asked to end. */
enum stop_level { STOP_NONE, STOP_SIM, STOP_ALL, STOP_AT_ONCE, STOP_KILL };

struct supervisor {
    const struct launch *launch;
    struct child child[ROLES];
    struct restarts restarts[ROLES];
    int signals; /* descriptor */
    double stop_wait_s;
    int level; /* enum stop_level */
    double level_at_s, deadline_s;
    bool interrupted, restarting;
    int failure; /* exit code of the process that failed first; 0: none */
};

static bool is_running(const struct supervisor *s, enum role role)
{
    return s->child[role].running;
}

static bool any_running(const struct supervisor *s)
{
    for (int role = 0; role < ROLES; role++)
        if (role != ROLE_WATCH && is_running(s, role))
            return true;
    return false;
}

/* Whether steps are being done, or will be again. */
static bool sim_goes_on(const struct supervisor *s)
{
    return is_running(s, ROLE_SIM) || s->restarting;
}

static void wait_at_most(struct supervisor *s, double wait_s)
{
    s->deadline_s = clock_now_s() + wait_s;
}

static void signal_all(struct supervisor *s, int signal_number)
{
    for (int role = 0; role < ROLES; role++)
        if (role != ROLE_WATCH)
            child_signal(&s->child[role], signal_number);
}

/* --- Starting --- */

static void note_pid(const struct supervisor *s, const struct child *child)
{
    char *path = run_folder_file(&s->launch->folder, "log/pids");
    FILE *file = fopen(path, "a");
    if (file) { /* for people: without it the run goes on */
        fprintf(file, "%s %d\n", child->name, (int)child->pid);
        (void)fclose(file);
    }
    g_free(path);
}

static enum status start(struct supervisor *s, enum role role, bool resume)
{
    const bool shows = role == ROLE_WATCH || role == ROLE_ANALYZER;
    const bool in_folder = role == ROLE_CONVERTER || (role == ROLE_SIM && launch_in_process(s->launch));
    const char *name = role_name(s->launch, role);
    char *file = g_strdup_printf("log/%s.log", name), *log = run_folder_file(&s->launch->folder, file);
    char **command = role_command(s->launch, role, resume);
    const struct child_place place = {.directory = in_folder ? s->launch->folder.path : NULL,
                                      .log = shows ? NULL : log,
                                      .shown = role == ROLE_SIM && launch_in_process(s->launch)};
    enum status status = child_start(&s->child[role], name, command, &place);
    if (status == STATUS_OK && !shows)
        note_pid(s, &s->child[role]);
    g_strfreev(command);
    g_free(file);
    g_free(log);
    return status;
}

/* The recorder writes over nothing. What a first attempt left stays under another name. */
static void set_aside(const struct launch *launch, const char *name)
{
    char *path = run_folder_file(&launch->folder, name), *aside = g_strconcat(path, ".before", NULL);
    if (rename(path, aside) != 0 && errno != ENOENT)
        say("warning: %s cannot be renamed: %s", path, strerror(errno));
    g_free(path);
    g_free(aside);
}

static void set_record_aside(const struct launch *launch)
{
    set_aside(launch, "run.h5");
    set_aside(launch, "run.lcm");
}

/* --- Stopping --- */

static void stop_to(struct supervisor *s, int level)
{
    s->level = level;
    s->level_at_s = clock_now_s();
    wait_at_most(s, level == STOP_SIM ? s->stop_wait_s : HARD_WAIT_S);
    switch (level) {
    case STOP_SIM: /* it ends the record stream, so the recorder gets all of it */
        child_signal(&s->child[ROLE_SIM], SIGINT);
        child_signal(&s->child[ROLE_CONVERTER], SIGINT);
        child_signal(&s->child[ROLE_ANALYZER], SIGTERM);
        break;
    case STOP_ALL:
        signal_all(s, SIGINT);
        break;
    case STOP_AT_ONCE: /* another signal, as two equal ones may arrive as one */
        signal_all(s, SIGTERM);
        break;
    default:
        for (int role = 0; role < ROLES; role++)
            if (role != ROLE_WATCH && is_running(s, role))
                say("killed, as it did not end: %s", s->child[role].name);
        signal_all(s, SIGKILL);
    }
}

static void stop_harder(struct supervisor *s)
{
    stop_to(s, s->level < STOP_KILL ? s->level + 1 : STOP_KILL);
}

static void fail(struct supervisor *s, enum role role, int code)
{
    if (s->failure == 0)
        s->failure = code == EXIT_CODE_TIMEOUT ? status_exit_code(STATUS_TIMEOUT) : code;
    report_failure(&s->child[role], code, &s->launch->folder);
}

/* Ends all others. A simulator that was killed cannot send END, so nobody shall wait for it. */
static void fail_and_stop(struct supervisor *s, enum role role, int code)
{
    fail(s, role, code);
    const int level = role == ROLE_SIM && code > EXIT_CODE_OF_SIGNAL ? STOP_AT_ONCE : STOP_ALL;
    if (s->level < level) {
        if (level == STOP_AT_ONCE)
            stop_to(s, STOP_ALL);
        stop_to(s, level);
    }
}

/* A process was asked to end by someone else: a wish that concerns the run. */
static void interrupt(struct supervisor *s)
{
    s->interrupted = true;
    if (s->level == STOP_NONE)
        stop_to(s, STOP_SIM);
}

/* --- Starting again --- */

static bool may_restart(struct supervisor *s, enum role role, int code)
{
    if (s->level != STOP_NONE || code <= EXIT_CODE_OF_SIGNAL)
        return false;
    return restarts_allow(&s->restarts[role], s->launch->restarts, clock_now_s());
}

static void say_restart(struct supervisor *s, enum role role, int code, const char *what)
{
    char text[END_TEXT_MAX];
    end_text(text, code);
    say("%s %s; %s (%d of at most %d restarts an hour)", s->child[role].name, text, what, s->restarts[role].n,
        s->launch->restarts);
}

static void start_or_fail(struct supervisor *s, enum role role, bool resume)
{
    if (start(s, role, resume) == STATUS_OK)
        return;
    say("error: %s", status_message());
    fail_and_stop(s, role, status_exit_code(STATUS_IO));
}

/* Simulator and recorder go on from the checkpoint together: what came after it is not on disk. */
static void restart_from_checkpoint(struct supervisor *s, enum role role, int code)
{
    const bool saved = run_folder_has(&s->launch->folder, "checkpoint.h5");
    say_restart(s, role, code,
                saved ? "goes on from the checkpoint" : "starts from the beginning, without a checkpoint");
    s->restarting = true;
    wait_at_most(s, RESTART_WAIT_S);
    child_signal(&s->child[ROLE_SIM], SIGKILL);
    child_signal(&s->child[ROLE_RECORDER], SIGINT);
    child_signal(&s->child[ROLE_RECORDER], SIGTERM);
}

/* In run.h5, or in the log from which it is made. */
static bool all_is_recorded(const struct supervisor *s)
{
    return record_is_complete(&s->launch->folder) || log_is_complete(&s->launch->folder);
}

/* A recorder that was killed when it had all: the others wait for it in vain. */
static void end_recorded(struct supervisor *s, int code)
{
    char text[END_TEXT_MAX];
    end_text(text, code);
    say("%s %s, when it had recorded all of the run", s->child[ROLE_RECORDER].name, text);
    s->restarting = true; /* the end of sim says nothing then */
    wait_at_most(s, RESTART_WAIT_S);
    child_signal(&s->child[ROLE_SIM], SIGKILL);
}

static void finish_restart(struct supervisor *s)
{
    if (!s->restarting || is_running(s, ROLE_SIM) || is_running(s, ROLE_RECORDER))
        return;
    s->restarting = false;
    if (s->level != STOP_NONE || all_is_recorded(s)) {
        child_signal(&s->child[ROLE_CONTROLLER], SIGTERM);
        return;
    }
    const bool resume = run_folder_has(&s->launch->folder, "checkpoint.h5");
    s->deadline_s = INFINITY;
    if (!resume)
        set_record_aside(s->launch);
    if (!launch_in_process(s->launch))
        start_or_fail(s, ROLE_RECORDER, resume);
    start_or_fail(s, ROLE_SIM, resume);
}

/* --- Ends of processes --- */

static bool is_wish_to_stop(int code)
{
    return code == status_exit_code(STATUS_INTERRUPTED) || code == EXIT_CODE_OF_SIGNAL + SIGTERM ||
           code == EXIT_CODE_OF_SIGNAL + SIGHUP;
}

/* A simulator whose result is doubtful has come to its end like any other; the analyzer says it again. */
static bool is_end_of_sim(enum role role, int code)
{
    return role == ROLE_SIM && code == status_exit_code(STATUS_DOUBTFUL);
}

/* Whether an exit code only tells what was asked for, or what the end of another process has caused. */
static bool is_consequence(const struct supervisor *s, enum role role, int code)
{
    if (code == 0 || is_end_of_sim(role, code) || s->level >= STOP_KILL)
        return true;
    if (s->level == STOP_NONE)
        return false;
    if (is_wish_to_stop(code) || (role == ROLE_CONTROLLER && s->launch->folder.controller))
        return true;
    return s->level >= STOP_ALL &&
           (code == status_exit_code(STATUS_TIMEOUT) || code == status_exit_code(STATUS_INCOMPLETE));
}

static void note_end_of_sim(struct supervisor *s, int code)
{
    const bool killed = code > EXIT_CODE_OF_SIGNAL && code != status_exit_code(STATUS_INTERRUPTED);
    if (s->level == STOP_NONE && is_wish_to_stop(code)) {
        s->interrupted = true;
        s->level = STOP_SIM;
    } else if (!is_consequence(s, ROLE_SIM, code)) {
        if (s->launch->keep_going && may_restart(s, ROLE_SIM, code))
            restart_from_checkpoint(s, ROLE_SIM, code);
        else
            fail_and_stop(s, ROLE_SIM, code);
        return;
    }
    child_signal(&s->child[ROLE_CONTROLLER], SIGTERM); /* it has most likely seen END already */
    wait_at_most(s, s->level == STOP_NONE ? FINISH_WAIT_S : CLOSE_WAIT_S);
    if (killed && s->level < STOP_AT_ONCE) { /* no END can come */
        stop_to(s, STOP_ALL);
        stop_to(s, STOP_AT_ONCE);
    }
}

static void note_end_of_controller(struct supervisor *s, int code)
{
    if (is_consequence(s, ROLE_CONTROLLER, code) || (is_wish_to_stop(code) && !sim_goes_on(s)))
        return;
    if (is_wish_to_stop(code)) {
        interrupt(s);
    } else if (sim_goes_on(s) && may_restart(s, ROLE_CONTROLLER, code)) {
        say_restart(s, ROLE_CONTROLLER, code, "started again");
        start_or_fail(s, ROLE_CONTROLLER, false);
    } else {
        fail_and_stop(s, ROLE_CONTROLLER, code);
    }
}

static void note_end_of_recorder(struct supervisor *s, int code)
{
    if (is_consequence(s, ROLE_RECORDER, code))
        return;
    if (is_wish_to_stop(code))
        interrupt(s);
    else if (s->level == STOP_NONE && code > EXIT_CODE_OF_SIGNAL && all_is_recorded(s))
        end_recorded(s, code);
    else if (is_running(s, ROLE_SIM) && may_restart(s, ROLE_RECORDER, code))
        restart_from_checkpoint(s, ROLE_RECORDER, code);
    else
        fail_and_stop(s, ROLE_RECORDER, code);
}

static void note_end(struct supervisor *s, enum role role)
{
    const int code = s->child[role].exit_code;
    switch (role) {
    case ROLE_SIM:
        if (!s->restarting)
            note_end_of_sim(s, code);
        break;
    case ROLE_CONTROLLER:
        note_end_of_controller(s, code);
        break;
    case ROLE_RECORDER:
        if (!s->restarting)
            note_end_of_recorder(s, code);
        break;
    case ROLE_CONVERTER: /* what is missing after a failure has been told already */
        if (!is_consequence(s, role, code) && !(s->failure && code == status_exit_code(STATUS_INCOMPLETE)))
            fail(s, role, code);
        break;
    case ROLE_ANALYZER:
        if (!is_consequence(s, role, code) && s->failure == 0)
            s->failure = code; /* it has said why */
        break;
    default:
        break;
    }
}

static void note_overdue(struct supervisor *s)
{
    if (s->level == STOP_NONE && s->restarting) {
        signal_all(s, SIGKILL);
        wait_at_most(s, RESTART_WAIT_S);
        return;
    }
    for (int role = 0; s->level == STOP_NONE && role < ROLES; role++)
        if (role != ROLE_WATCH && is_running(s, role))
            fail(s, role, EXIT_CODE_TIMEOUT);
    stop_harder(s);
}

/* --- The loop --- */

static void take_signals(struct supervisor *s)
{
    struct signalfd_siginfo info;
    while (read(s->signals, &info, sizeof info) == (ssize_t)sizeof info) {
        if (info.ssi_signo == SIGUSR1) { /* from a process that was asked to stop (common/signals.h) */
            interrupt(s);
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
        if (!is_running(s, role))
            continue;
        fds[n++] = (struct pollfd){.fd = s->child[role].pidfd, .events = POLLIN};
        if (s->child[role].log.pipe >= 0)
            fds[n++] = (struct pollfd){.fd = s->child[role].log.pipe, .events = POLLIN};
    }
    /* An error (a signal, no memory for a moment) only means to look again. */
    (void)poll(fds, n, timeout_ms(s));
}

/* Until all that were started have ended; the display may stay. */
static void supervise(struct supervisor *s)
{
    while (any_running(s)) {
        wait_for_event(s);
        take_signals(s);
        for (int role = 0; role < ROLES; role++) {
            if (is_running(s, role))
                child_log_take(&s->child[role].log);
            if (child_has_ended(&s->child[role]))
                note_end(s, role);
        }
        finish_restart(s);
        if (clock_now_s() >= s->deadline_s && any_running(s))
            note_overdue(s);
    }
}

/* --- Parts of a run --- */

static void end_watch(struct supervisor *s)
{
    struct child *watch = &s->child[ROLE_WATCH];
    const double end_s = clock_now_s() + HARD_WAIT_S;
    child_signal(watch, SIGTERM);
    while (watch->running && !child_has_ended(watch)) {
        struct pollfd fd = {.fd = watch->pidfd, .events = POLLIN};
        const double left_s = end_s - clock_now_s();
        if (left_s <= 0)
            child_signal(watch, SIGKILL);
        (void)poll(&fd, 1, left_s > 0 ? (int)ceil(1e3 * left_s) : 100);
    }
}

static void run_over_bus(struct supervisor *s)
{
    const bool resume = s->launch->resume;
    say("run %s in %s on %s", s->launch->folder.run_id, s->launch->folder.path, s->launch->folder.url);
    start_or_fail(s, ROLE_RECORDER, resume);
    if (s->level == STOP_NONE)
        start_or_fail(s, ROLE_CONTROLLER, false);
    if (s->level == STOP_NONE)
        start_or_fail(s, ROLE_SIM, resume);
    if (s->level == STOP_NONE && start(s, ROLE_WATCH, false) != STATUS_OK)
        say("no progress will be shown: %s", status_message());
    supervise(s);
    end_watch(s);
}

/* Size and time of the log, to see whether it was touched. */
struct log_state {
    off_t size;
    struct timespec changed;
};

static struct log_state log_state_of(const struct launch *launch)
{
    struct stat stat_of = {0};
    char *path = run_folder_file(&launch->folder, "run.lcm");
    if (stat(path, &stat_of) != 0)
        stat_of = (struct stat){0};
    g_free(path);
    return (struct log_state){stat_of.st_size, stat_of.st_mtim};
}

static void begin_part(struct supervisor *s)
{
    s->level = STOP_NONE;
    s->deadline_s = INFINITY;
}

/* Makes run.h5 from the log. */
static void convert(struct supervisor *s)
{
    begin_part(s);
    start_or_fail(s, ROLE_CONVERTER, false);
    supervise(s);
}

/* A run that was refused leaves log and record as they are. */
static void run_in_process(struct supervisor *s)
{
    const struct log_state before = log_state_of(s->launch);
    say("run %s in %s, in one process", s->launch->folder.run_id, s->launch->folder.path);
    start_or_fail(s, ROLE_SIM, s->launch->resume);
    supervise(s);
    const struct log_state after = log_state_of(s->launch);
    if (after.size == 0 || (after.size == before.size && after.changed.tv_sec == before.changed.tv_sec &&
                            after.changed.tv_nsec == before.changed.tv_nsec))
        return;
    convert(s);
}

static bool can_go_on(int code)
{
    static const enum status never[] = {STATUS_USAGE, STATUS_CONFIG, STATUS_UNSTABLE, STATUS_LIMIT, STATUS_FORMAT};
    for (size_t k = 0; k < sizeof never / sizeof *never; k++)
        if (code == status_exit_code(never[k]))
            return false;
    return true;
}

/* Says how an unfinished run can be gone on with; returns the exit code. */
static int conclude_unfinished(const struct supervisor *s)
{
    const struct run_folder *folder = &s->launch->folder;
    if (s->interrupted)
        say("interrupted");
    report_record(folder);
    if (s->interrupted || can_go_on(s->failure))
        report_way_on(folder);
    return s->interrupted ? status_exit_code(STATUS_INTERRUPTED) : s->failure;
}

/* Removes a file that may be there. */
static void forget(const struct launch *launch, const char *name)
{
    char *path = run_folder_file(&launch->folder, name);
    if (unlink(path) != 0 && errno != ENOENT)
        say("warning: %s cannot be removed: %s", path, strerror(errno));
    g_free(path);
}

/* An evaluation that broke off is done again by --resume. */
static int evaluate(struct supervisor *s)
{
    begin_part(s);
    start_or_fail(s, ROLE_ANALYZER, false);
    supervise(s);
    /* A result that failed its checks is there all the same. */
    const bool whole = s->failure == 0 || s->failure == status_exit_code(STATUS_LIMIT);
    if (whole && !s->interrupted) {
        printf("results: %s\n", s->launch->folder.path);
        return s->failure;
    }
    forget(s->launch, "analysis.json");
    say(s->interrupted ? "interrupted; the record is complete" : "the record is complete, its evaluation failed");
    report_way_on(&s->launch->folder);
    return s->interrupted ? status_exit_code(STATUS_INTERRUPTED) : s->failure;
}

/* SIGHUP stays ignored under nohup. */
static enum status open_signals(struct supervisor *s)
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

static void simulate(struct supervisor *s)
{
    if (!s->launch->resume)
        set_record_aside(s->launch);
    if (launch_in_process(s->launch))
        run_in_process(s);
    else
        run_over_bus(s);
}

/* Does what is left of a run: its steps, or only run.h5, if a kill came before the log was made into it. */
static void go_on(struct supervisor *s)
{
    const struct run_folder *folder = &s->launch->folder;
    if (!log_is_complete(folder))
        simulate(s);
    if (s->failure || s->interrupted || record_is_complete(folder) || !log_is_complete(folder))
        return;
    say("the log is complete: run.h5 is made from it");
    convert(s);
}

static int refuse_complete(const struct run_folder *folder)
{
    say("error: %s/run.h5 is complete already; evaluate it again with: ./shakedown analyze %s", folder->path,
        folder->path);
    return status_exit_code(STATUS_IO);
}

int launch_run(const struct launch *launch, double stop_wait_s)
{
    struct supervisor s = {.launch = launch, .stop_wait_s = stop_wait_s, .deadline_s = INFINITY};
    for (int role = 0; role < ROLES; role++)
        s.child[role] = (struct child){.name = role_name(launch, role), .log = {.file = -1, .pipe = -1}};
    if (open_signals(&s) != STATUS_OK)
        return status_report("shakedown", STATUS_IO);
    if (!record_is_complete(&launch->folder))
        go_on(&s);
    else if (run_folder_has(&launch->folder, "analysis.json"))
        return refuse_complete(&launch->folder);
    forget(launch, "namespace-pid");
    int code = s.interrupted || s.failure ? conclude_unfinished(&s) : evaluate(&s);
    for (int role = 0; role < ROLES; role++)
        g_free(s.child[role].log.path);
    close(s.signals);
    return code;
}
