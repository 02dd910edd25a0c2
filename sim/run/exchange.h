/* The exchange with the controller: a wall state out, a wall command back; over LCM, or by calling the law here. */
#ifndef SHAKEDOWN_SIM_RUN_EXCHANGE_H
#define SHAKEDOWN_SIM_RUN_EXCHANGE_H

#include "common/bus.h"
#include "common/coupling.h"
#include "common/record_sender.h"
#include "common/round_trip_time.h"
#include "sim/run/replay.h"

/* How often a state went out and was answered. */
struct exchange_attempt {
    int64_t seq; /* -1: none */
    int sends, answers;
    int waits;                 /* in vain: times that it had to go out again */
    double asked_at_s, trip_s; /* to the first answer */
};

struct exchange {
    const struct scene *scene;
    struct bus *bus;
    struct record_sender *stream; /* served while waiting */
    int64_t run_id;
    bool in_process;        /* the law is called here */
    struct replay *replay;  /* answers come from a log; NULL: not */
    bool record_walls;      /* states and commands are recorded: in_process they are published for that alone */
    int64_t seq;            /* of the next state */
    int64_t repeated;       /* states sent again */
    struct round_trip trip; /* of a state and its answer */
    struct exchange_attempt now, before; /* the state that was asked for last, and the one before it */
    double loss;                         /* share of the copies of states that got no answer */
    bool open;                           /* a state went to the controller, its answer was not taken yet */
    bool answered;
    int64_t ignored; /* answers to the state asked last that do not fit it */
    char why[96];    /* the last of them */
    struct wall_command answer;
    struct wall_state asked;
};

/* Fills `exchange`; over LCM (neither in_process nor `replay`) subscribes WALL_COMMAND. */
enum status exchange_init(struct exchange *exchange, const struct scene *scene, struct bus *bus,
                          struct record_sender *stream, int64_t run_id, bool in_process,
                          struct replay *replay) MUST_USE;

/* Asks for the command that answers `state`; it may come while other things are done. */
enum status exchange_ask(struct exchange *exchange, const struct wall_state *state) MUST_USE;

/* The command that was asked for last. STATUS_TIMEOUT after coupling.timeout_s without one, STATUS_INTERRUPTED when a
 * stop was requested meanwhile, STATUS_FORMAT if it is not fit to be carried out (command_check.h). */
enum status exchange_answer(struct exchange *exchange, struct wall_command *command) MUST_USE;

/* At the end of a run, whatever ended it: waits a while for an answer on its way, so that states and commands are
 * counted as a recorder has heard them. */
enum status exchange_settle(struct exchange *exchange) MUST_USE;

/* Exchanges begun: states sent, repeats not counted. `seq` counts the commands. */
int64_t exchange_states(const struct exchange *exchange);

#endif
