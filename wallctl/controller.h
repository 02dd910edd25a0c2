/* wallctl on the bus: answers every WALL_STATE of its run with a WALL_COMMAND until END comes. */
#ifndef SHAKEDOWN_WALLCTL_CONTROLLER_H
#define SHAKEDOWN_WALLCTL_CONTROLLER_H

#include <stdint.h>

#include "common/bus.h"
#include "common/scene.h"

struct controller_counts {
    int64_t answered;  /* commands sent, copies included */
    int64_t foreign;   /* messages of other runs */
    int64_t malformed; /* messages that are not of the channel's type or not well formed */
    int64_t rejected;  /* states the law refuses; the first is reported on stderr */
};

/* Runs until END of `run_id` comes, or until a stop signal (common/signals.h) and then 5 s more in which END is waited
 * for and states are still answered; a second signal ends it at once. Keeps nothing between states: it may be killed
 * and started again at any time. `counts` is filled in any case.
 * STATUS_INTERRUPTED if it stopped without END, STATUS_BUS if the bus fails. */
enum status controller_run(struct bus *bus, const struct scene *scene, int64_t run_id,
                           struct controller_counts *counts) MUST_USE;

#endif
