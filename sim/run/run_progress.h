#ifndef SHAKEDOWN_SIM_RUN_RUN_PROGRESS_H
#define SHAKEDOWN_SIM_RUN_RUN_PROGRESS_H

#include "common/bus.h"
#include "common/coupling.h"
#include "sim/measure/stability_watch.h"

/* Where a run stands, beside the state of the sample. */
struct run_progress {
    int64_t run_id;
    double fraction_done;
    double kinetic_j, elastic_j; /* as the controller was told last, measured at energy_step */
    int64_t energy_step;
    int64_t frame_strain_next;
    int64_t exchanges, commands_repeated; /* answered states; states sent again */
    int64_t frames;                       /* recorded */
    int64_t last_sample_step, last_frame_step;
    int64_t record_total[RECORD_CHANNELS]; /* records sent, all of them acknowledged */
    int64_t record_hash[RECORD_CHANNELS];  /* of these (common/record_hash.h) */
    int64_t log_bytes;                     /* length of the event log that sim writes itself; 0: none */
    double elapsed_s;
    struct stability_watch watch;
    int hurry_steps, passing_noted; /* of the judge */
    int64_t doubts;                 /* notes that make the run doubtful */
    int has_command;                /* the command for the current step was asked for ahead: this one */
    struct wall_command command;
};

#endif
