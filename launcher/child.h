/* One process of a run: started, signalled and waited for by a descriptor of its own (pidfd), never by a number that
 * another process may have by now. */
#ifndef SHAKEDOWN_LAUNCHER_CHILD_H
#define SHAKEDOWN_LAUNCHER_CHILD_H

#include <stdbool.h>
#include <sys/types.h>

#include "launcher/child_log.h"

enum { EXIT_CODE_OF_SIGNAL = 128 }; /* and the number of the signal: as shells have it */

struct child {
    const char *name;
    pid_t pid;
    int pidfd; /* valid while `running` */
    bool running;
    int exit_code; /* once it has ended */
    struct child_log log;
};

/* Where a process is started and where its words go. */
struct child_place {
    const char *directory; /* NULL: here */
    const char *log;       /* path of the log file; NULL: it writes where the launcher does */
    bool shown;            /* the standard error goes where the launcher's does, in spite of the log */
};

/* Starts argv (NULL ended; argv[0] with a path or from PATH) in a process group of its own, so that Ctrl-C reaches the
 * launcher alone, with empty standard input, no signal blocked or ignored but SIGPIPE and SIGXFSZ, and told to end
 * (SIGTERM) when the launcher dies. `name` must outlive the child. */
enum status child_start(struct child *child, const char *name, char *const *argv,
                        const struct child_place *place) MUST_USE;

/* Sends a signal, and SIGCONT, so that a stopped process hears it. Nothing happens to one that has ended. */
void child_signal(const struct child *child, int signal_number);

/* If the process has ended: takes its exit code and last words, sets running to false and returns true. Does not
 * wait. */
bool child_has_ended(struct child *child);

/* What the launcher's own program does between fork and the process' program, as posix_spawn cannot: asks for the
 * signal on the death of `parent` and becomes argv. Returns only on failure. */
enum status child_become(pid_t parent, char **argv) MUST_USE;

#endif
