#include "sim/sample/wall_state.h"

#include <string.h>

#include "sim/sample/wall_motion.h"

void sample_wall_state(const struct sample *sample, struct wall_state *state)
{
    const struct wall_trajectory *path = &sample->trajectory;
    const struct coupling_audit *audit = &sample->audit;
    memset(state, 0, sizeof *state);
    state->step = sample->step;
    state->time_s = sample->time_s;
    state->stage = sample->stage;
    state->stage_step = sample->stage_step;
    state->stage_time_s = sample->stage < 0 ? 0 : (double)sample->stage_step * sample->dt;
    state->interval_s = path->n_steps * path->dt;
    state->command_step = sample->step;
    state->interface_residual_j = audit->residual_j;
    state->interface_error = audit->error;
    state->interface_error_before = audit->error_before;
    state->n_walls = sample->n_walls;
    for (int w = 0; w < sample->n_walls; w++) {
        const struct wall *wall = &sample->walls[w];
        state->position_m[w] = wall->x;
        state->velocity_m_per_s[w] = walls_mean_velocity_m_per_s(sample, w);
        state->acceleration_m_per_s2[w] = path->n_steps > 0 ? path->a0[w] : 0;
        state->force_before_n[w] = audit->force_start[w];
        state->force_n[w] = wall->force;
        state->stage_position_m[w] = sample->stage_position_m[w];
    }
    memcpy(state->ahead_position_m, state->position_m, sizeof state->ahead_position_m);
    memcpy(state->ahead_velocity_m_per_s, state->velocity_m_per_s, sizeof state->ahead_velocity_m_per_s);
    walls_stiffness(sample, state->stiffness_n_per_m, state->damping_kg_per_s);
}

void sample_wall_state_ahead(const struct sample *sample, struct wall_state *state)
{
    if (sample->stage_step == 0) /* the stage began meanwhile */
        sample_wall_state(sample, state);
    state->command_step = sample->trajectory.from_step + sample->trajectory.n_steps;
    for (int w = 0; w < sample->n_walls; w++) {
        state->ahead_position_m[w] = walls_end_position_m(sample, w);
        state->ahead_velocity_m_per_s[w] = walls_mean_velocity_m_per_s(sample, w);
    }
}
