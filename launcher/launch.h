/* Runs a run: starts its processes, watches over them, starts again what died, ends them in order. */
#ifndef SHAKEDOWN_LAUNCHER_LAUNCH_H
#define SHAKEDOWN_LAUNCHER_LAUNCH_H

#include "launcher/commands.h"

/* Simulates, records and evaluates; says on the standard error what went wrong and how to go on, and on the standard
 * output where the results are. Returns the exit code for main: that of the process that failed first, 128 + n for
 * one that signal n ended, 130 for an interrupted run. `stop_wait_s`: how long the simulator may take to write its
 * checkpoint and close the record once it is asked to stop, before it is asked harder. */
int launch_run(const struct launch *launch, double stop_wait_s);

#endif
