/* The protocol: which stage is in force at a state, and where in it we are. Internal to the law. */
#ifndef SHAKEDOWN_WALLCTL_STAGE_SEQUENCE_H
#define SHAKEDOWN_WALLCTL_STAGE_SEQUENCE_H

#include "common/coupling.h"
#include "common/scene.h"

/* A moment of the protocol, at the step of a state. */
struct moment {
    const struct scene_stage *stage;
    int stage_index;
    int64_t stage_step;             /* steps done in it */
    int64_t steps_left;             /* 0: the protocol is finished */
    int64_t steps_to_look;          /* until the conditions of the stage are looked at */
    bool looks_at_energy;           /* and the energies are wanted then */
    enum stage_end ended;           /* of the stage before, if one ends at this moment */
    const double *stage_position_m; /* [n_walls] at the start of the stage; points into the state */
    double fraction_done;           /* of scene_total_time_s; a stage that ended early counts in full */
};

/* The moment at which `state` (already checked) stands: in its stage, or at the start of the next if it is over. */
struct moment stage_sequence_moment(const struct scene *scene, const struct wall_state *state);

#endif
