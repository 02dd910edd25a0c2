/* How the record of a run stands. */
#ifndef SHAKEDOWN_LAUNCHER_RECORD_STATE_H
#define SHAKEDOWN_LAUNCHER_RECORD_STATE_H

#include <stdbool.h>

#include "launcher/run_folder.h"

/* Whether run.h5 holds the whole run, from its start to an end that was not an interruption or a failure. False too for
 * a file that is not there or cannot be read. */
bool record_is_complete(const struct run_folder *folder);

/* Whether run.lcm holds the same: undamaged, and END of a run that went well is its last message. Without a complete
 * run.h5 it is what a kill leaves that comes just before run.h5 is in place. */
bool log_is_complete(const struct run_folder *folder);

#endif
