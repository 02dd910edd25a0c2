/* What sim and wallctl tell each other, as plain data: the same for the loop over LCM and the loop in one process.
 * Walls in the order x_lo x_hi [y_lo y_hi] z_lo z_hi; wall w belongs to pair w/2 and is its upper wall if w is odd. */
#ifndef SHAKEDOWN_COMMON_COUPLING_H
#define SHAKEDOWN_COMMON_COUPLING_H

#include <stdbool.h>
#include <stdint.h>

#include "common/message.h"
#include "common/scene.h"

/* State of the walls after the forces of `step`. Fields as in lcmtypes/wall_state_t.lcm. */
struct wall_state {
    int64_t step;
    double time_s;
    int stage; /* -1 before the first command */
    int64_t stage_step;
    double stage_time_s;
    double interval_s;
    int64_t command_step; /* the command is wanted from this step on; later than `step` if asked for ahead */
    double kinetic_energy_j, elastic_energy_j;
    int64_t energy_step;
    double interface_residual_j;
    double interface_error, interface_error_before;
    int n_walls;
    double position_m[SCENE_WALLS_MAX];
    double velocity_m_per_s[SCENE_WALLS_MAX];      /* mean over the interval that ended at `step` */
    double acceleration_m_per_s2[SCENE_WALLS_MAX]; /* in that interval, as commanded */
    double force_n[SCENE_WALLS_MAX];               /* of the particles on the wall, positive outward */
    double stiffness_n_per_m[SCENE_WALLS_MAX];
    double damping_kg_per_s[SCENE_WALLS_MAX];
    double stage_position_m[SCENE_WALLS_MAX];
    double force_before_n[SCENE_WALLS_MAX];
    double ahead_position_m[SCENE_WALLS_MAX];
    double ahead_velocity_m_per_s[SCENE_WALLS_MAX];
};

/* How many steps before the end of an interval of n_steps the next command is asked for (coupling.ahead_steps, at most
 * half of it; pipelined: all of it); 0: at its end. */
int coupling_ahead_steps(const struct scene_coupling *coupling, int n_steps);

/* What moves a wall during an interval. */
enum wall_drive {
    DRIVE_PATH,            /* a path that depends on no force */
    DRIVE_LOOP,            /* a path that answers the force */
    DRIVE_IMPEDANCE,       /* mass, damping and driving force: sim closes the loop in every step */
    DRIVE_IMPEDANCE_MIRROR /* the same for a pair of walls with one degree of freedom */
};

/* Why a stage ended: code, text. */
#define STAGE_END_LIST(X)                                                                                              \
    X(NONE, "it goes on")                                                                                              \
    X(LENGTH, "its length")                                                                                            \
    X(LIMIT, "its limit in time, with no condition met")                                                               \
    X(REST, "rest")                                                                                                    \
    X(STRAIN, "until_strain")                                                                                          \
    X(STRESS, "until_stress_pa")                                                                                       \
    X(Q, "until_q_pa")                                                                                                 \
    X(Q_OVER_P, "until_q_over_p")                                                                                      \
    X(R_U, "until_r_u")                                                                                                \
    X(CYCLES, "until_cycles")

enum stage_end {
#define STAGE_END_ENUM(name, text) STAGE_END_##name,
    STAGE_END_LIST(STAGE_END_ENUM)
#undef STAGE_END_ENUM
};

/* The list's text; "unknown" for any other code. */
const char *stage_end_text(int end);

/* Motion from `step` over n_steps: x(t) = x + v t + a t^2/2, v(t) = v + a t, or by an impedance. Fields as in
 * wall_command_t.lcm. */
struct wall_command {
    int64_t step;
    int stage;
    bool finished;
    int ended;   /* enum stage_end: of the stage before, if `stage` begins here, or the protocol ends */
    int measure; /* 1: the state at the end of the interval is to carry its energies */
    int n_steps;
    double fraction_done;
    int n_walls;
    int32_t drive[SCENE_WALLS_MAX]; /* enum wall_drive */
    double position_m[SCENE_WALLS_MAX];
    double velocity_m_per_s[SCENE_WALLS_MAX];
    double acceleration_m_per_s2[SCENE_WALLS_MAX];
    double force_n[SCENE_WALLS_MAX];
    double force_rate_n_per_s[SCENE_WALLS_MAX];
    double force_rate2_n_per_s2[SCENE_WALLS_MAX];
    double mass_kg[SCENE_WALLS_MAX];
    double damping_kg_per_s[SCENE_WALLS_MAX];
};

/* Conversion to and from the generated types (lcmtypes); arrays point into `state`/`command`, no allocation.
 * `from` checks n_walls and returns false for a message that does not fit. */
struct _shakedown_wall_state_t;
struct _shakedown_wall_command_t;
void wall_state_to_message(const struct wall_state *state, int64_t run_id, int64_t seq,
                           struct _shakedown_wall_state_t *message);
bool wall_state_from_message(const struct _shakedown_wall_state_t *message, struct wall_state *state);
void wall_command_to_message(const struct wall_command *command, int64_t run_id, int64_t seq, double time_s,
                             struct _shakedown_wall_command_t *message);
bool wall_command_from_message(const struct _shakedown_wall_command_t *message, struct wall_command *command);

/* Size check, decoding and conversion of what came from the bus, safe for any bytes: false, and nothing but the header
 * read (zero if even that does not fit), for a message that is not of the type or does not fit. */
bool wall_state_decode(const void *data, size_t size, struct message_header *header, struct wall_state *state);
bool wall_command_decode(const void *data, size_t size, struct message_header *header, struct wall_command *command);

/* Encodes into `buffer` [WALL_MESSAGE_MAX] bytes; returns the size, 0 if it does not fit. */
enum { WALL_MESSAGE_MAX = 1024 };

/* Exchanges on their way to the recorder: with the window of the records (common/record_sender.c) below the default
 * receive buffer of a socket. */
enum { WALLS_WINDOW = 16 };

/* Arrays of doubles behind the count of walls in each message; a command has one of 32-bit integers before them. */
enum { WALL_STATE_ARRAYS = 10, WALL_COMMAND_ARRAYS = 8 };
size_t wall_state_encode(const struct wall_state *state, int64_t run_id, int64_t seq, unsigned char *buffer);
size_t wall_command_encode(const struct wall_command *command, int64_t run_id, int64_t seq, double time_s,
                           unsigned char *buffer);

#endif
