/* Which program plays which part in a run, and what it is told. */
#ifndef SHAKEDOWN_LAUNCHER_COMMANDS_H
#define SHAKEDOWN_LAUNCHER_COMMANDS_H

#include <stdbool.h>

#include "launcher/run_folder.h"

/* In the order in which ends are looked at: what the simulator does explains what the others do. */
enum role { ROLE_SIM, ROLE_CONTROLLER, ROLE_RECORDER, ROLE_WATCH, ROLE_CONVERTER, ROLE_ANALYZER, ROLES };

struct launch {
    struct run_folder folder;
    const char *bin; /* the build folder */
    bool resume;     /* goes on from the folder's checkpoint */
    bool keep_going; /* a simulator that crashes goes on from the checkpoint, too */
    int restarts;    /* of each process within an hour */
};

/* For messages and log files. */
const char *role_name(const struct launch *launch, enum role role);

/* The command, NULL ended, to be freed by g_strfreev. With `resume`, sim and recorder go on from the checkpoint. */
char **role_command(const struct launch *launch, enum role role, bool resume);

/* Whether the run has one process, without a bus. */
bool launch_in_process(const struct launch *launch);

#endif
