/* Replay of a run's log through the simulator: the recorded commands drive the sample, without a bus, and the wall
 * states of today are compared with the recorded ones, bit for bit. */
#ifndef SHAKEDOWN_SIM_RUN_REPLAY_H
#define SHAKEDOWN_SIM_RUN_REPLAY_H

#include "common/bus.h"
#include "common/coupling.h"

struct replay_counts {
    int64_t states;    /* compared and found equal, copies included */
    int64_t commands;  /* carried out */
    int64_t foreign;   /* messages of other runs */
    int64_t malformed; /* messages that could not be read */
};

struct replay {
    struct bus bus;
    bool run_known;
    int64_t run_id;
    struct replay_counts counts;
    const struct wall_state *now; /* the state asked with; NULL: none */
    struct wall_command command;  /* the recorded answer to it */
    bool state_seen, command_seen;
    bool ended;
    int64_t end_step, end_hash;
    enum status failure; /* found in a handler */
};

/* Opens the event log at `path`. The run is `run_id`, or with run_id_given false that of the first message. Errors:
 * STATUS_IO, STATUS_BUS (no such log). */
enum status replay_open(struct replay *replay, const char *path, bool run_id_given, int64_t run_id) MUST_USE;
void replay_close(struct replay *replay);

/* Reads on to the recorded answer to `state`. STATUS_FORMAT if the recorded state differs (the message names step,
 * field and both values); STATUS_INCOMPLETE if the log has no state and command for this step. */
enum status replay_exchange(struct replay *replay, const struct wall_state *state,
                            struct wall_command *command) MUST_USE;

/* After the last command: END must come, for the same step with the same hash of the state (sample_hash).
 * STATUS_INCOMPLETE without END, STATUS_FORMAT if it differs. */
enum status replay_finish(struct replay *replay, int64_t step, uint64_t state_hash) MUST_USE;

#endif
