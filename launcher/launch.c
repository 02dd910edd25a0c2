#include "launcher/launch.h"

#include <errno.h>
#include <fcntl.h>
#include <glib.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "launcher/record_state.h"
#include "launcher/report.h"
#include "launcher/supervisor.h"

static void run_over_bus(struct supervisor *s)
{
    const bool resume = s->launch->resume;
    say("run %s in %s on %s", s->launch->folder.run_id, s->launch->folder.path, s->launch->folder.url);
    stop_unless_started(s, ROLE_RECORDER, resume);
    if (s->level == STOP_NONE)
        stop_unless_started(s, ROLE_CONTROLLER, false);
    if (s->level == STOP_NONE)
        stop_unless_started(s, ROLE_SIM, resume);
    if (s->level == STOP_NONE && supervisor_start(s, ROLE_WATCH, false) != STATUS_OK)
        say("no progress will be shown: %s", status_message());
    supervise(s);
    supervise_end_watch(s);
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
    stop_unless_started(s, ROLE_CONVERTER, false);
    supervise(s);
}

/* A run that was refused leaves log and record as they are. */
static void run_in_process(struct supervisor *s)
{
    const struct log_state before = log_state_of(s->launch);
    say("run %s in %s, in one process", s->launch->folder.run_id, s->launch->folder.path);
    stop_unless_started(s, ROLE_SIM, s->launch->resume);
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

/* There while an evaluation lasts: numbers without plots are left where all were killed. */
static const char EVALUATING[] = "log/evaluating";

static void mark_evaluating(const struct launch *launch)
{
    char *path = run_folder_file(&launch->folder, EVALUATING);
    const int file = open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
    if (file < 0 || close(file) != 0)
        say("warning: %s cannot be written: %s", path, strerror(errno));
    g_free(path);
}

static bool is_evaluated(const struct run_folder *folder)
{
    return run_folder_has(folder, "analysis.json") && !run_folder_has(folder, EVALUATING);
}

/* An evaluation that broke off is done again by --resume. */
static int evaluate(struct supervisor *s)
{
    begin_part(s);
    mark_evaluating(s->launch);
    stop_unless_started(s, ROLE_ANALYZER, false);
    supervise(s);
    forget(s->launch, EVALUATING);
    /* A result that failed its checks, or is doubtful, is there all the same. */
    const bool whole = s->failure == 0 || s->failure == status_exit_code(STATUS_LIMIT) ||
                       s->failure == status_exit_code(STATUS_DOUBTFUL);
    if (whole && !s->interrupted) {
        printf("results: %s\n", s->launch->folder.path);
        return s->failure;
    }
    forget(s->launch, "analysis.json");
    say(s->interrupted ? "interrupted; the record is complete" : "the record is complete, its evaluation failed");
    report_way_on(&s->launch->folder);
    return s->interrupted ? status_exit_code(STATUS_INTERRUPTED) : s->failure;
}

static void simulate(struct supervisor *s)
{
    if (!s->launch->resume)
        record_set_aside(s->launch);
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
    char *path = report_shell_word(folder->path);
    say("error: %s/run.h5 is complete already; evaluate it again with: ./shakedown analyze %s", folder->path, path);
    g_free(path);
    return status_exit_code(STATUS_IO);
}

int launch_run(const struct launch *launch, double stop_wait_s)
{
    struct supervisor s = {.launch = launch, .stop_wait_s = stop_wait_s, .deadline_s = INFINITY};
    for (int role = 0; role < ROLES; role++)
        s.child[role] = (struct child){.name = role_name(launch, role), .log = {.file = -1, .pipe = -1}};
    if (supervise_open_signals(&s) != STATUS_OK)
        return status_report("shakedown", STATUS_IO);
    if (!record_is_complete(&launch->folder))
        go_on(&s);
    else if (is_evaluated(&launch->folder))
        return refuse_complete(&launch->folder);
    forget(launch, "namespace-pid");
    int code = s.interrupted || s.failure ? conclude_unfinished(&s) : evaluate(&s);
    for (int role = 0; role < ROLES; role++)
        g_free(s.child[role].log.path);
    close(s.signals);
    return code;
}
