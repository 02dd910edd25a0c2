/* How the record of a run stands. */
#ifndef SHAKEDOWN_LAUNCHER_RECORD_STATE_H
#define SHAKEDOWN_LAUNCHER_RECORD_STATE_H

#include <stdbool.h>

#include "launcher/run_folder.h"

/* Whether run.h5 holds the whole run, from its start to an end that was not an interruption or a failure. False too for
 * a file that is not there or cannot be read. */
bool record_is_complete(const struct run_folder *folder);

#endif
