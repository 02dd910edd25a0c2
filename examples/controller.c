/* A controller of one's own, in place of wallctl (docs/your-own-controller.md): compresses the box in z at a constant
 * velocity for 2000 steps in each stage of the scene, while all other walls rest. Nothing of Shakedown but the messages
 * is used: lcm-gen makes them from lcmtypes/.
 *
 *     ./shakedown run scenes/quick.cfg --controller build/examples/example-controller */
#include <lcm/lcm.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "shakedown_wall_command_t.h"
#include "shakedown_wall_state_t.h"

enum { STEPS = 2000, INTERVAL = 50, WALLS = 6 };
static const double VELOCITY_M_PER_S = -0.01;

struct controller {
    int64_t run_id;
    bool failed;
};

static int steps_left(const shakedown_wall_state_t *state)
{
    return state->stage < 0 ? 0 : STEPS - (int)state->stage_step;
}

/* The answer depends on the state alone, so that a repeated state gets a copy, and this program may be started again. */
static void on_state(const lcm_recv_buf_t *buffer, const char *channel, const shakedown_wall_state_t *state, void *user)
{
    struct controller *c = user;
    double zero[WALLS] = {0}, velocity[WALLS] = {0};
    int32_t path[WALLS] = {0}; /* drive 0: a path that depends on no force */
    (void)channel;
    if (state->run_id != c->run_id || state->n_walls > WALLS)
        return;
    int left = steps_left(state);
    shakedown_wall_command_t command = {.run_id = state->run_id,
                                        .seq = state->seq,           /* of the state that this answers */
                                        .step = state->command_step, /* from which the command holds */
                                        .time_s = state->time_s,
                                        .stage = state->stage,
                                        .n_walls = state->n_walls,
                                        .drive = path,
                                        .position_m = state->position_m, /* walls do not jump */
                                        .velocity_m_per_s = velocity,
                                        .acceleration_m_per_s2 = zero,
                                        .force_n = zero,
                                        .force_rate_n_per_s = zero,
                                        .force_rate2_n_per_s2 = zero,
                                        .mass_kg = zero,
                                        .damping_kg_per_s = zero};
    if (left <= 0 && state->stage == 0) { /* one stage is enough here */
        command.finished = 1;
        command.ended = 1;
        command.fraction_done = 1;
    } else {
        command.stage = 0;
        left = left > 0 ? left : STEPS; /* the first state is before the first stage: -1 */
        command.n_steps = left < INTERVAL ? left : INTERVAL;
        command.fraction_done = 1 - (double)left / STEPS;
        velocity[state->n_walls - 1] = VELOCITY_M_PER_S; /* the upper wall in z is the last */
    }
    c->failed = c->failed || shakedown_wall_command_t_publish(buffer->lcm, "WALL_COMMAND", &command) != 0;
}

/* END, whose first fields are those of every message: a hash of the type, then run_id, big-endian. */
static void on_end(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct controller *c = user;
    const unsigned char *bytes = buffer->data;
    int64_t run_id = 0;
    (void)channel;
    for (int k = 8; k < 16 && buffer->data_size >= 16; k++)
        run_id = (int64_t)((uint64_t)run_id << 8 | bytes[k]);
    if (run_id == c->run_id)
        exit(c->failed ? 1 : 0);
}

/* Arguments: SCENE [--set KEY=VALUE]... --run-id N --lcm URL; scene and overrides do not matter here. */
int main(int argc, char **argv)
{
    struct controller c = {0};
    const char *url = NULL;
    for (int k = 1; k + 1 < argc; k++) {
        if (strcmp(argv[k], "--run-id") == 0)
            c.run_id = strtoll(argv[k + 1], NULL, 10);
        if (strcmp(argv[k], "--lcm") == 0)
            url = argv[k + 1];
    }
    lcm_t *lcm = lcm_create(url);
    if (!lcm || !shakedown_wall_state_t_subscribe(lcm, "WALL_STATE", on_state, &c) ||
        !lcm_subscribe(lcm, "END", on_end, &c)) {
        fprintf(stderr, "controller: no bus at %s\n", url ? url : "the default");
        return 1;
    }
    while (lcm_handle(lcm) == 0 && !c.failed)
        ;
    return 1;
}
