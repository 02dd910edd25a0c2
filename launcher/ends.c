#include <signal.h>

#include "launcher/report.h"
#include "launcher/supervisor.h"

static const double FINISH_WAIT_S = 120; /* recorder and controller, after sim is done */
static const double CLOSE_WAIT_S = 4;    /* the same, in a run that was told to stop */

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
        if (s->launch->keep_going && restart_allowed(s, ROLE_SIM, code))
            restart_from_checkpoint(s, ROLE_SIM, code);
        else
            stop_on_failure(s, ROLE_SIM, code);
        return;
    }
    /* It has most likely seen END already; if not, the second one says that none will come. */
    child_signal(&s->child[ROLE_CONTROLLER], SIGTERM);
    child_signal(&s->child[ROLE_CONTROLLER], SIGINT);
    if (code == 0 || is_end_of_sim(ROLE_SIM, code)) /* the record is whole: nobody asks for END again */
        child_signal(&s->child[ROLE_RECORDER], SIGTERM);
    supervisor_wait_at_most(s, s->level == STOP_NONE ? FINISH_WAIT_S : CLOSE_WAIT_S);
    if (killed && s->level < STOP_AT_ONCE) { /* no END can come */
        stop_to(s, STOP_ALL);
        stop_to(s, STOP_AT_ONCE);
    }
}

static void note_end_of_controller(struct supervisor *s, int code)
{
    if (is_consequence(s, ROLE_CONTROLLER, code) || (is_wish_to_stop(code) && !restart_sim_goes_on(s)))
        return;
    if (is_wish_to_stop(code)) {
        stop_interrupt(s);
    } else if (restart_sim_goes_on(s) && restart_allowed(s, ROLE_CONTROLLER, code)) {
        restart_say(s, ROLE_CONTROLLER, code, "started again");
        stop_unless_started(s, ROLE_CONTROLLER, false);
    } else {
        stop_on_failure(s, ROLE_CONTROLLER, code);
    }
}

static void note_end_of_recorder(struct supervisor *s, int code)
{
    if (is_consequence(s, ROLE_RECORDER, code))
        return;
    if (is_wish_to_stop(code))
        stop_interrupt(s);
    else if (s->level == STOP_NONE && code > EXIT_CODE_OF_SIGNAL && restart_is_needless(s))
        restart_end_recorded(s, code);
    else if (supervisor_has(s, ROLE_SIM) && restart_allowed(s, ROLE_RECORDER, code))
        restart_from_checkpoint(s, ROLE_RECORDER, code);
    else
        stop_on_failure(s, ROLE_RECORDER, code);
}

void ends_note(struct supervisor *s, enum role role)
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
            stop_note_failure(s, role, code);
        break;
    case ROLE_ANALYZER:
        if (!is_consequence(s, role, code) && s->failure == 0)
            s->failure = code; /* it has said why */
        break;
    default:
        break;
    }
}

void ends_note_overdue(struct supervisor *s)
{
    if (s->level == STOP_NONE && s->restarting) {
        restart_insist(s);
        return;
    }
    for (int role = 0; s->level == STOP_NONE && role < ROLES; role++)
        if (role != ROLE_WATCH && supervisor_has(s, role))
            stop_note_failure(s, role, EXIT_CODE_TIMEOUT);
    stop_harder(s);
}
