/* How a run is carried out. */
#ifndef SHAKEDOWN_SIM_RUN_RUN_OPTIONS_H
#define SHAKEDOWN_SIM_RUN_RUN_OPTIONS_H

#include "common/bus.h"
#include "common/scene.h"
#include "sim/run/replay.h"

struct run_options {
    int64_t run_id;
    bool in_process;        /* call the control law here instead of asking wallctl */
    bool progress;          /* print STATUS on stderr too */
    const char *url;        /* of the bus; NULL in process: no records at all */
    const char *checkpoint; /* where to write checkpoints; NULL: none */
    const char *resume;     /* the checkpoint to go on from; NULL: from the start */
    const char *controller; /* command of the program that runs in place of wallctl, for the record; NULL: wallctl */
    struct replay *replay;  /* commands come from this log and states are compared with it; no records; NULL: no */
};

#endif
