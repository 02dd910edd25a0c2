/* What a run's files say of themselves: `recorder --verify DIR`. */
#ifndef SHAKEDOWN_RECORDER_VERIFY_H
#define SHAKEDOWN_RECORDER_VERIFY_H

#include <stdio.h>

#include "common/status.h"

/* Reads DIR/run.lcm, if it is there, and DIR/run.h5 as a whole and prints what was found, with a verdict in the last
 * line: every event's checksum; of each channel its numbers without gaps, the totals and hashes that CHECKPOINT and END
 * say, steps that never go back; of run.h5 that every dataset can be read, that it has as many rows as END says,
 * `complete`. STATUS_OK: the run is complete; STATUS_INCOMPLETE: something is missing; STATUS_FORMAT: something is
 * damaged; STATUS_IO: there is nothing to look at. Writes nothing into the folder. */
enum status verify_run(const char *directory, FILE *out) MUST_USE;

#endif
