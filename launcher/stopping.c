#include <signal.h>

#include "common/bus.h"
#include "launcher/report.h"
#include "launcher/supervisor.h"

/* All, after they were asked in vain. */
static const double HARD_WAIT_S = 2;

void stop_to(struct supervisor *s, int level)
{
    s->level = level;
    s->level_at_s = clock_now_s();
    supervisor_wait_at_most(s, level == STOP_SIM ? s->stop_wait_s : HARD_WAIT_S);
    switch (level) {
    case STOP_SIM: /* it ends the record stream, so the recorder gets all of it */
        child_signal(&s->child[ROLE_SIM], SIGINT);
        child_signal(&s->child[ROLE_CONVERTER], SIGINT);
        child_signal(&s->child[ROLE_ANALYZER], SIGTERM);
        break;
    case STOP_ALL:
        supervisor_signal_all(s, SIGINT);
        break;
    case STOP_AT_ONCE: /* another signal, as two equal ones may arrive as one */
        supervisor_signal_all(s, SIGTERM);
        break;
    default:
        for (int role = 0; role < ROLES; role++)
            if (role != ROLE_WATCH && supervisor_has(s, role))
                say("killed, as it did not end: %s", s->child[role].name);
        supervisor_signal_all(s, SIGKILL);
    }
}

void stop_harder(struct supervisor *s)
{
    stop_to(s, s->level < STOP_KILL ? s->level + 1 : STOP_KILL);
}

void stop_note_failure(struct supervisor *s, enum role role, int code)
{
    if (s->failure == 0)
        s->failure = code == EXIT_CODE_TIMEOUT ? status_exit_code(STATUS_TIMEOUT) : code;
    report_failure(&s->child[role], code, &s->launch->folder);
}

/* Ends all others. A simulator that was killed cannot send END, so nobody shall wait for it. */
void stop_on_failure(struct supervisor *s, enum role role, int code)
{
    stop_note_failure(s, role, code);
    const int level = role == ROLE_SIM && code > EXIT_CODE_OF_SIGNAL ? STOP_AT_ONCE : STOP_ALL;
    if (s->level < level) {
        if (level == STOP_AT_ONCE)
            stop_to(s, STOP_ALL);
        stop_to(s, level);
    }
}

void stop_interrupt(struct supervisor *s)
{
    s->interrupted = true;
    if (s->level == STOP_NONE)
        stop_to(s, STOP_SIM);
}

void stop_unless_started(struct supervisor *s, enum role role, bool resume)
{
    if (supervisor_start(s, role, resume) == STATUS_OK)
        return;
    say("error: %s", status_message());
    stop_on_failure(s, role, status_exit_code(STATUS_IO));
}
