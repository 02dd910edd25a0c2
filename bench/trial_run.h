/* One run of a scene for a bench: in one process, or through sim, wallctl and recorder over the bus. */
#ifndef SHAKEDOWN_BENCH_TRIAL_RUN_H
#define SHAKEDOWN_BENCH_TRIAL_RUN_H

#include <stdbool.h>

#include "common/status.h"

enum { TRIAL_OVERRIDES_MAX = 24 };

struct trial {
    const char *bin;    /* build folder */
    const char *scene;  /* file */
    const char *folder; /* made if need be; what it holds of an earlier trial is lost */
    const char *override[TRIAL_OVERRIDES_MAX];
    int n_overrides;
    bool in_process;
    double limit_s;    /* the run is killed after that */
    int exit_code;     /* result, of sim: 0; of status_exit_code; 128 if it was killed */
    char message[600]; /* result: what sim said last if exit_code is not 0 */
};

/* Runs it: FOLDER/run.h5 is there afterwards unless sim never began. Over the bus: in the network namespace that the
 * bench itself is in. A run that sim ended badly is a result. STATUS_IO if a process cannot be started, if recorder or
 * wallctl failed before sim did (which is ended then), or the recorder in a run that ended well. */
enum status trial_run(struct trial *trial) MUST_USE;

#endif
