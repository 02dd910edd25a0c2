/* The simulated sample: particles, contacts and walls, and how one step changes them. Knows the stages' materials and
 * time steps, but no target and no protocol: walls move as commands say. */
#ifndef SHAKEDOWN_SIM_WORLD_H
#define SHAKEDOWN_SIM_WORLD_H

#include "common/coupling.h"
#include "common/scene.h"
#include "sim/contacts.h"
#include "sim/interface.h"
#include "sim/kernels.h"
#include "sim/neighbor.h"
#include "sim/particles.h"
#include "sim/threads.h"

/* Energy ledger since the start of the stage [J]. */
struct ledger {
    double kinetic_start, elastic_start, potential_start;
    double work_walls;
    double background; /* dissipated by background damping */
    struct contact_losses contacts;
};

/* The command in force. x0, v0, a0 of walls with an impedance are those of the current step. */
struct wall_path {
    int64_t from_step;
    int n_steps;
    double dt;
    double x0[SCENE_WALLS_MAX], v0[SCENE_WALLS_MAX], a0[SCENE_WALLS_MAX];
    int32_t drive[SCENE_WALLS_MAX];                                                           /* enum wall_drive */
    double force[SCENE_WALLS_MAX], force_rate[SCENE_WALLS_MAX], force_rate2[SCENE_WALLS_MAX]; /* of the command */
    double mass[SCENE_WALLS_MAX], damping[SCENE_WALLS_MAX];
    double v_last[SCENE_WALLS_MAX]; /* mean over the step before from_step, and its length */
    double dt_last;
};

struct world {
    const struct scene *scene;
    struct particles particles;
    struct contact_list pairs;
    struct neighbor neighbor;
    struct threads threads;
    struct wall walls[SCENE_WALLS_MAX];
    int n_walls;
    struct wall_path path;
    struct interface interface;
    enum kernel_isa isa;
    struct kernels kernels;
    struct contact_law_constants law;
    const struct scene_material *material; /* of the stage */
    double gravity[3];                     /* components as the particles' */
    struct ledger ledger;

    int64_t step;
    double time_s;
    int stage; /* -1 before the first command */
    int64_t stage_step;
    double stage_time_start_s;
    double stage_position_m[SCENE_WALLS_MAX];
    double dt;
    bool open;       /* the last step is not complete: world_step_open */
    double kicked_s; /* the time step of the last kick, or of the one that is due; 0 at the start of a stage */
};

/* Makes a world with the model of the scene and room for its particles, without any state yet; for checkpoints. */
enum status world_create_empty(struct world **world, const struct scene *scene) MUST_USE;

/* Makes the sample of the scene at step 0. `scene` must outlive the world. Errors: STATUS_NO_MEMORY, STATUS_LIMIT (no
 * room), STATUS_USAGE (SHAKEDOWN_ISA), those of checkpoint_start. */
enum status world_create(struct world **world, const struct scene *scene) MUST_USE;
void world_free(struct world *world);

/* Prepares the lists of contacts for the particles' radii. */
enum status world_init_lists(struct world *world) MUST_USE;

/* Builds the lists anew, for the positions as they are. Errors: as of neighbor_build. */
enum status world_build_lists(struct world *world) MUST_USE;

/* Hands all lists over to the kernels, as contact_list_close does. */
enum status world_close_lists(struct world *world) MUST_USE;

/* Sets what follows from the stage and the scene: material and law. */
void world_set_law(struct world *world);

/* Takes a command: switches to its stage if that is new (the ledger starts anew, forces follow the new material) and
 * sets the walls on their path. STATUS_FORMAT if the command does not fit the current step. */
enum status world_command(struct world *world, const struct wall_command *command) MUST_USE;

/* One time step: velocity Verlet with velocities predicted for the force evaluation, second order also for forces that
 * depend on velocity. STATUS_UNSTABLE if a particle has left the box or is not finite. */
enum status world_step(struct world *world) MUST_USE;

/* The same, but forces between particles and what follows from them are left to the next step, which goes on in as few
 * passes over the particles as it can: faster, and the same bits. Who reads velocities, accelerations, the contacts'
 * history or the ledger calls world_settle first; measurements, hash, checkpoint and a change of stage do. Walls and
 * their forces are complete, and in double positions. */
enum status world_step_open(struct world *world) MUST_USE;
void world_settle(const struct world *world);

/* What the controller is told; energies are filled by the caller. */
void world_wall_state(const struct world *world, struct wall_state *state);

/* Makes `state`, told when the interval in force began, ask for the command after it (pipelined). */
void world_wall_state_ahead(const struct world *world, struct wall_state *state);

/* Length of the box along component c [m]. */
double world_box_length_m(const struct world *world, int c);

/* Index of the scene's axis that component c is (2D: 0 -> x, 1 -> z). */
enum axis world_axis(const struct world *world, int c);

/* FNV-1a over positions, velocities (in the order of ids) and walls: equal bits, equal hash. */
uint64_t world_hash(const struct world *world);

#endif
