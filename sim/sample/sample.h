/* The simulated sample: particles, contacts and walls, and how one step changes them. Knows the stages' materials and
 * time steps, but no target and no protocol: walls move as commands say. */
#ifndef SHAKEDOWN_SIM_SAMPLE_SAMPLE_H
#define SHAKEDOWN_SIM_SAMPLE_SAMPLE_H

#include "common/coupling.h"
#include "common/scene.h"
#include "sim/contacts/contact_list.h"
#include "sim/grains/particles.h"
#include "sim/kernels/kernels.h"
#include "sim/look/coupling_audit.h"
#include "sim/neighbours/verlet_list.h"
#include "sim/sample/threads.h"

/* Energy ledger since the start of the stage [J]. */
struct ledger {
    double kinetic_start, elastic_start, potential_start;
    double work_walls;
    double background; /* dissipated by background damping */
    struct contact_losses contacts;
};

/* The command in force. x0, v0, a0 of walls with an impedance are those of the current step. */
struct wall_trajectory {
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

struct sample {
    const struct scene *scene;
    struct particles particles;
    struct contact_list pairs;
    struct verlet_list verlet;
    struct threads threads;
    struct wall walls[SCENE_WALLS_MAX];
    int n_walls;
    struct wall_trajectory trajectory;
    struct coupling_audit audit;
    enum instruction_set isa;
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
    bool open;       /* the last step is not complete: sample_step_open */
    double kicked_s; /* the time step of the last kick, or of the one that is due; 0 at the start of a stage */
};

/* Makes a sample with the model of the scene and room for its particles, without any state yet; for checkpoints. */
enum status sample_create_empty(struct sample **sample, const struct scene *scene) MUST_USE;

/* Makes the sample of the scene at step 0. `scene` must outlive the sample. Errors: STATUS_NO_MEMORY, STATUS_LIMIT (no
 * room), STATUS_USAGE (SHAKEDOWN_ISA), those of checkpoint_start. */
enum status sample_create(struct sample **sample, const struct scene *scene) MUST_USE;
void sample_free(struct sample *sample);

/* Prepares the lists of contacts for the particles' radii. */
enum status sample_init_lists(struct sample *sample) MUST_USE;

/* Builds the lists anew, for the positions as they are. Errors: as of verlet_list_build. */
enum status sample_build_lists(struct sample *sample) MUST_USE;

/* Hands all lists over to the kernels, as contact_list_close does. */
enum status sample_close_lists(struct sample *sample) MUST_USE;

/* Sets what follows from the stage and the scene: material and law. */
void sample_set_law(struct sample *sample);

/* Takes a command: switches to its stage if that is new (the ledger starts anew, forces follow the new material) and
 * sets the walls on their path. STATUS_FORMAT if the command does not fit the current step. */
enum status sample_command(struct sample *sample, const struct wall_command *command) MUST_USE;

/* One time step: velocity Verlet with velocities predicted for the force evaluation, second order also for forces that
 * depend on velocity. STATUS_UNSTABLE if a particle has left the box or is not finite. */
enum status sample_step(struct sample *sample) MUST_USE;

/* The same, but forces between particles and what follows from them are left to the next step, which goes on in as few
 * passes over the particles as it can: faster, and the same bits. Who reads velocities, accelerations, the contacts'
 * history or the ledger calls sample_complete first; measurements, hash, checkpoint and a change of stage do. Walls and
 * their forces are complete, and in double positions. */
enum status sample_step_open(struct sample *sample) MUST_USE;
void sample_complete(const struct sample *sample);

/* What the controller is told; energies are filled by the caller. */
void sample_wall_state(const struct sample *sample, struct wall_state *state);

/* Makes `state`, told when the interval in force began, ask for the command after it (pipelined). */
void sample_wall_state_ahead(const struct sample *sample, struct wall_state *state);

/* Length of the box along component c [m]. */
double sample_box_length_m(const struct sample *sample, int c);

/* Index of the scene's axis that component c is (2D: 0 -> x, 1 -> z). */
enum axis sample_axis(const struct sample *sample, int c);

/* FNV-1a over positions, velocities (in the order of ids) and walls: equal bits, equal hash. */
uint64_t sample_hash(const struct sample *sample);

#endif
