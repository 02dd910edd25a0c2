/* What the parts of the launcher know of a run that goes on, and what they do to it. Used inside launcher/ only. */
#ifndef SHAKEDOWN_LAUNCHER_SUPERVISOR_H
#define SHAKEDOWN_LAUNCHER_SUPERVISOR_H

#include "launcher/child.h"
#include "launcher/commands.h"
#include "launcher/restarts.h"

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

/* --- supervisor.c: the processes --- */

bool supervisor_has(const struct supervisor *s, enum role role);
bool supervisor_has_any(const struct supervisor *s); /* apart from the display */

/* When to lose patience (ends_note_overdue). */
void supervisor_wait_at_most(struct supervisor *s, double wait_s);
void supervisor_signal_all(struct supervisor *s, int signal_number);

/* Starts the program of `role`. With `resume`, sim and recorder go on from the checkpoint. STATUS_IO if it cannot. */
enum status supervisor_start(struct supervisor *s, enum role role, bool resume) MUST_USE;

/* --- stopping.c: asking processes to end, harder and harder. With the wait for sim, the waits stay below 15 s. --- */

void stop_to(struct supervisor *s, int level);
void stop_harder(struct supervisor *s);

/* Reports a process that failed; the second one ends all others, too. */
void stop_note_failure(struct supervisor *s, enum role role, int code);
void stop_on_failure(struct supervisor *s, enum role role, int code);

/* A process was asked to end by someone else: a wish that concerns the run. */
void stop_interrupt(struct supervisor *s);

/* Starts a process; where that fails, the run fails. */
void stop_unless_started(struct supervisor *s, enum role role, bool resume);

/* --- restarting.c: processes that die are started again --- */

/* The recorder writes over nothing. What a first attempt left stays under another name. */
void record_set_aside(const struct launch *launch);

/* Whether steps are being done, or will be again. */
bool restart_sim_goes_on(const struct supervisor *s);

/* Whether a process that ended with `code` may be started once more; counts it. */
bool restart_allowed(struct supervisor *s, enum role role, int code);
void restart_say(struct supervisor *s, enum role role, int code, const char *what);

/* Simulator and recorder go on from the checkpoint together: what came after it is not on disk. Both are asked to end,
 * and killed if they do not (restart_insist); restart_finish starts them when they have. */
void restart_from_checkpoint(struct supervisor *s, enum role role, int code);
void restart_insist(struct supervisor *s);
void restart_finish(struct supervisor *s);

/* Whether all of the run is in run.h5, or in the log from which it is made; and what follows when the recorder was
 * killed then: the others wait for it in vain. */
bool restart_is_needless(const struct supervisor *s);
void restart_end_recorded(struct supervisor *s, int code);

/* --- ends.c: what the end of a process, or that it does not end, says about the run --- */

void ends_note(struct supervisor *s, enum role role);
void ends_note_overdue(struct supervisor *s);

/* --- supervise.c: the loop --- */

enum status supervise_open_signals(struct supervisor *s) MUST_USE;

/* Until all that were started have ended; the display may stay. */
void supervise(struct supervisor *s);
void supervise_end_watch(struct supervisor *s);

#endif
