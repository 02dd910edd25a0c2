/* A run under way. */
#ifndef SHAKEDOWN_SIM_RUN_RUN_STATE_H
#define SHAKEDOWN_SIM_RUN_RUN_STATE_H

#include "common/record_sender.h"
#include "sim/measure/passing_watch.h"
#include "sim/measure/stability_watch.h"
#include "sim/measure/time_remaining.h"
#include "sim/run/exchange.h"
#include "sim/run/records.h"
#include "sim/run/run_options.h"
#include "sim/run/run_progress.h"
#include "sim/sample/energy.h"
#include "sim/sample/sample.h"

struct run_energies {
    struct held_energy held;
    int64_t step; /* at which it was measured */
};

struct run_judge {
    struct stability_watch watch; /* of the stage */
    struct passing_watch passing;
    int hurry_steps;    /* particles are so fast that contacts are looked at every so many steps; 0: they are not */
    bool passing_noted; /* in this stage */
    int64_t doubts;     /* notes so far that make the run doubtful */
    char first_doubt[768];
};

struct run {
    const struct scene *scene;
    const struct run_options *options;
    struct sample *sample;
    struct bus bus;
    struct record_sender *stream;
    struct records records;
    struct exchange exchange;
    struct run_judge judge;
    double fraction_done;
    struct run_energies energies;    /* measured when the controller wants them */
    struct held_energy sampled;      /* of the last sample, for people */
    struct time_remaining remaining; /* of the stage */
    int frame_strain_next;           /* index in frame_strains */
    double start_s, status_s;
    int64_t status_step, status_seq;
    double steps_per_second;
    bool resumed;               /* went on from `before` */
    struct run_progress before; /* zero for a run from the start */
    struct run_energies told;   /* with the last state */
    struct wall_command command;
    bool has_command;         /* `command` is for the current step and was asked for ahead */
    double checkpoint_s;      /* when the last one was written */
    double checkpoint_cost_s; /* what it took, records and all */
    double stop_s;            /* when a stop was seen; 0: none */
};

static inline const struct scene_stage *run_stage(const struct run *run)
{
    return &run->scene->stage[run->sample->stage];
}

#endif
