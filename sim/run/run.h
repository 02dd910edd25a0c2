/* A whole run: exchange, steps, records, status, until the protocol is done. */
#ifndef SHAKEDOWN_SIM_RUN_RUN_H
#define SHAKEDOWN_SIM_RUN_RUN_H

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
    struct replay *replay;  /* commands come from this log and states are compared with it; no records; NULL: no */
};

/* Runs the scene. On an error, or when a stop is requested, END says so and the records so far stay valid. The status
 * of the run is returned. */
enum status run_scene(const struct scene *scene, const struct run_options *options) MUST_USE;

#endif
