/* The protocol: which stage is in force at a state, and where in it we are. Internal to the law. */
#ifndef SHAKEDOWN_WALLCTL_PROTOCOL_H
#define SHAKEDOWN_WALLCTL_PROTOCOL_H

#include "common/coupling.h"
#include "common/scene.h"

/* A moment of the protocol, at the step of a state. */
struct moment {
    const struct scene_stage *stage;
    int stage_index;
    int64_t stage_step;             /* steps done in it */
    int64_t steps_left;             /* 0: the protocol is finished */
    const double *stage_position_m; /* [n_walls] at the start of the stage; points into the state */
    double fraction_done;           /* of scene_total_time_s; a stage that ended early counts in full */
};

/* The moment at which `state` (already checked) stands: in its stage, or at the start of the next if it is over. */
struct moment protocol_moment(const struct scene *scene, const struct wall_state *state);

/* Steps of a stage that no condition ends: duration_s/dt_s rounded, at least 1; rounded up where duration_s is a whole
 * number of stress cycles, so that none is cut short. */
int64_t protocol_stage_steps(const struct scene_stage *stage);

/* Area [m^2] of the walls of a pair: the product of the other box lengths; 2D has a depth of 1 m. */
double walls_area_m2(const struct wall_state *state, int pair);

#endif
