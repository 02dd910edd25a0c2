#include <errno.h>
#include <glib.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

#include "common/bus.h"
#include "launcher/record_state.h"
#include "launcher/report.h"
#include "launcher/supervisor.h"

static const double RESTART_WAIT_S = 10; /* the recorder closes a file that it will open again */

/* The recorder writes over nothing. What a first attempt left stays under another name. */
static void set_aside(const struct launch *launch, const char *name)
{
    char *path = run_folder_file(&launch->folder, name), *aside = g_strconcat(path, ".before", NULL);
    if (rename(path, aside) != 0 && errno != ENOENT)
        say("warning: %s cannot be renamed: %s", path, strerror(errno));
    g_free(path);
    g_free(aside);
}

void record_set_aside(const struct launch *launch)
{
    set_aside(launch, "run.h5");
    set_aside(launch, "run.lcm");
}

bool restart_sim_goes_on(const struct supervisor *s)
{
    return supervisor_has(s, ROLE_SIM) || s->restarting;
}

bool restart_allowed(struct supervisor *s, enum role role, int code)
{
    if (s->level != STOP_NONE || code <= EXIT_CODE_OF_SIGNAL)
        return false;
    return restarts_allow(&s->restarts[role], s->launch->restarts, clock_now_s());
}

void restart_say(struct supervisor *s, enum role role, int code, const char *what)
{
    char text[END_TEXT_MAX];
    end_text(text, code);
    say("%s %s; %s (%d of at most %d restarts an hour)", s->child[role].name, text, what, s->restarts[role].n,
        s->launch->restarts);
}

void restart_from_checkpoint(struct supervisor *s, enum role role, int code)
{
    const bool saved = run_folder_has(&s->launch->folder, "checkpoint.h5");
    restart_say(s, role, code,
                saved ? "goes on from the checkpoint" : "starts from the beginning, without a checkpoint");
    s->restarting = true;
    supervisor_wait_at_most(s, RESTART_WAIT_S);
    child_signal(&s->child[ROLE_SIM], SIGKILL);
    child_signal(&s->child[ROLE_RECORDER], SIGINT);
    child_signal(&s->child[ROLE_RECORDER], SIGTERM);
}

void restart_insist(struct supervisor *s)
{
    supervisor_signal_all(s, SIGKILL);
    supervisor_wait_at_most(s, RESTART_WAIT_S);
}

bool restart_is_needless(const struct supervisor *s)
{
    return record_is_complete(&s->launch->folder) || log_is_complete(&s->launch->folder);
}

void restart_end_recorded(struct supervisor *s, int code)
{
    char text[END_TEXT_MAX];
    end_text(text, code);
    say("%s %s, when it had recorded all of the run", s->child[ROLE_RECORDER].name, text);
    s->restarting = true; /* the end of sim says nothing then */
    supervisor_wait_at_most(s, RESTART_WAIT_S);
    child_signal(&s->child[ROLE_SIM], SIGKILL);
}

void restart_finish(struct supervisor *s)
{
    if (!s->restarting || supervisor_has(s, ROLE_SIM) || supervisor_has(s, ROLE_RECORDER))
        return;
    s->restarting = false;
    if (s->level != STOP_NONE || restart_is_needless(s)) {
        child_signal(&s->child[ROLE_CONTROLLER], SIGTERM);
        return;
    }
    const bool resume = run_folder_has(&s->launch->folder, "checkpoint.h5");
    s->deadline_s = INFINITY;
    if (!resume)
        record_set_aside(s->launch);
    if (!launch_in_process(s->launch))
        stop_unless_started(s, ROLE_RECORDER, resume);
    stop_unless_started(s, ROLE_SIM, resume);
}
