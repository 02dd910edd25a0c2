#include "sim/run/command_check.h"

#include <math.h>

/* Of the box: a thousandth of a radius where a hundred particles lie in a row, far below an overlap. */
static const double JUMP = 1e-6;

static enum status numbers_check(const struct wall_command *command)
{
    const struct {
        const char *name;
        const double *value;
    } fields[] = {{"position_m", command->position_m},
                  {"velocity_m_per_s", command->velocity_m_per_s},
                  {"acceleration_m_per_s2", command->acceleration_m_per_s2},
                  {"force_n", command->force_n},
                  {"force_rate_n_per_s", command->force_rate_n_per_s},
                  {"force_rate2_n_per_s2", command->force_rate2_n_per_s2},
                  {"mass_kg", command->mass_kg},
                  {"damping_kg_per_s", command->damping_kg_per_s}};
    for (size_t k = 0; k < sizeof fields / sizeof fields[0]; k++)
        for (int w = 0; w < command->n_walls; w++)
            if (!isfinite(fields[k].value[w]))
                return status_fail(STATUS_FORMAT, "the command for step %lld: %s[%d] is not finite",
                                   (long long)command->step, fields[k].name, w);
    return STATUS_OK;
}

static enum status drives_check(const struct wall_command *command)
{
    for (int w = 0; w < command->n_walls; w++) {
        const int drive = command->drive[w];
        if (drive < DRIVE_PATH || drive > DRIVE_IMPEDANCE_MIRROR)
            return status_fail(STATUS_FORMAT, "the command for step %lld: drive[%d] is %d; allowed: 0 to 3",
                               (long long)command->step, w, drive);
        if (drive >= DRIVE_IMPEDANCE && !(command->mass_kg[w] > 0 || command->damping_kg_per_s[w] > 0))
            return status_fail(STATUS_FORMAT,
                               "the command for step %lld: wall %d has an impedance without mass_kg and "
                               "damping_kg_per_s; one must be above 0",
                               (long long)command->step, w);
    }
    return STATUS_OK;
}

static enum status jumps_check(const struct wall_state *state, const struct wall_command *command)
{
    const double *now_m = state->command_step > state->step ? state->ahead_position_m : state->position_m;
    for (int w = 0; w < command->n_walls; w++) {
        const double length_m = state->position_m[w | 1] - state->position_m[w & ~1];
        if (!(fabs(command->position_m[w] - now_m[w]) <= JUMP * length_m))
            return status_fail(
                STATUS_FORMAT,
                "the command for step %lld: position_m[%d] is %.9g, the wall is at %.9g; allowed: within "
                "%g of the box, as walls do not jump",
                (long long)command->step, w, command->position_m[w], now_m[w], JUMP);
    }
    return STATUS_OK;
}

static enum status stage_check(const struct scene *scene, const struct wall_state *state,
                               const struct wall_command *command)
{
    if (command->stage < 0 || command->stage >= scene->n_stages || command->stage < state->stage)
        return status_fail(STATUS_FORMAT, "the command for step %lld: stage is %d; allowed: %d to %lld",
                           (long long)command->step, command->stage, state->stage < 0 ? 0 : state->stage,
                           (long long)scene->n_stages - 1);
    const struct scene_stage *stage = &scene->stage[command->stage];
    const int64_t done = command->stage == state->stage ? state->stage_step + state->command_step - state->step : 0;
    const double left = ceil(stage->duration_s / stage->dt_s) + 1 - (double)done; /* 1: for the rounding of the ratio */
    const bool ahead = state->command_step > state->step;
    if (command->n_steps < (ahead ? 0 : 1) || (double)command->n_steps > left)
        return status_fail(STATUS_FORMAT,
                           "the command for step %lld: n_steps is %d; allowed: 1 to %.0f, what is left of "
                           "stage \"%s\"",
                           (long long)command->step, command->n_steps, left, stage->name);
    return STATUS_OK;
}

enum status command_check(const struct scene *scene, const struct wall_state *state, const struct wall_command *command)
{
    if (command->n_walls != state->n_walls)
        return status_fail(STATUS_FORMAT, "the command for step %lld: n_walls is %d; allowed: %d",
                           (long long)command->step, command->n_walls, state->n_walls);
    if (command->finished)
        return STATUS_OK;
    TRY(numbers_check(command));
    TRY(drives_check(command));
    TRY(jumps_check(state, command));
    return stage_check(scene, state, command);
}
