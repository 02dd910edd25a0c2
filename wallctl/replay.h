/* Replay of a run's log through the law: the commands of today against the recorded ones, bit for bit. */
#ifndef SHAKEDOWN_WALLCTL_REPLAY_H
#define SHAKEDOWN_WALLCTL_REPLAY_H

#include <stdint.h>

#include "common/bus.h"
#include "common/scene.h"

struct replay_counts {
    int64_t states;    /* read, copies included */
    int64_t commands;  /* compared and found equal, copies included */
    int64_t unpaired;  /* commands whose state is not in the log */
    int64_t foreign;   /* messages of other runs */
    int64_t malformed; /* messages that could not be read */
};

/* Reads the log that `bus` has open to its end. The run is `run_id`, or with run_id_given false that of the first
 * message. `counts` is filled in any case.
 * STATUS_FORMAT at the first command that differs (the message names step, field and both values) or that the law
 * refuses; STATUS_INCOMPLETE if END is missing (the log was cut) or no command could be compared. */
enum status replay_run(struct bus *bus, const struct scene *scene, bool run_id_given, int64_t run_id,
                       struct replay_counts *counts) MUST_USE;

#endif
