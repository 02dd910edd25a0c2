/* The simulated sample: particles, contacts and walls, and how one step changes them. Knows the stages' materials and
 * time steps, but no target and no protocol: walls move as commands say. */
#ifndef SHAKEDOWN_SIM_SAMPLE_SAMPLE_H
#define SHAKEDOWN_SIM_SAMPLE_SAMPLE_H

#include "common/coupling.h"
#include "common/scene.h"
#include "sim/contacts/contact_list.h"
#include "sim/grains/particles.h"
#include "sim/kernels/kernels.h"
#include "sim/neighbours/verlet_list.h"
#include "sim/sample/threads.h"

/* Energy ledger since the start of the stage [J]. */
struct ledger {
    double kinetic_start, elastic_start, potential_start;
    double work_walls;
    double work_material; /* what the stage's material, where it is another, added to the elastic energy held */
    double background;    /* dissipated by background damping */
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

/* Books of the interface between walls and controller (coupling_audit.h). */
/* Walls whose loop is closed in every step, and that turn round in every step; over windows of steps. Not in
 * checkpoints: a run that goes on looks anew. */
struct swing_watch {
    double way_m[SCENE_WALLS_MAX];   /* of the last step, outward */
    int turns[SCENE_WALLS_MAX];      /* in a row */
    double swung_j[SCENE_WALLS_MAX]; /* by what the force changed on the way, of those that turn */
    double passed_j;                 /* by the force itself, of all */
    int steps, bad_windows, leaking_windows;
};

struct coupling_audit {
    /* Since the start of the stage [J], over all walls in a force loop: |work that sim integrated - (F + F')/2 dx| with
     * the forces at both ends of an interval; of sim, and as the controller's motion took them. */
    double residual_j, controller_residual_j;
    /* The same over |F + F'|/2 |dx|, of the last two intervals; 0: nothing moved. */
    double error, error_before;
    /* The interval in force; after its end, until the next command, the one that ended. */
    double force_told[SCENE_WALLS_MAX];       /* of the sample at its start, as told to the controller [N] */
    double force_start[SCENE_WALLS_MAX];      /* the same, but with the material of the stage */
    double controller_force[SCENE_WALLS_MAX]; /* as it took them; of an impedance: driving force at the start */
    double x_start[SCENE_WALLS_MAX];          /* m */
    double work[SCENE_WALLS_MAX];             /* of the sample on the walls, trapezoidal rule over all steps [J] */
    /* The watch, over windows of intervals. */
    double window_residual_j, window_error;
    int window_intervals, bad_windows, leaking_windows;
    struct swing_watch swing;
    double diameter_m, sound_m_per_s; /* mean; of the sample: follow from particles and material */
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
    struct contact_law_constants law;         /* of particles among themselves; */
    struct contact_law_constants wall_law[3]; /* and on the walls of each component */
    const struct scene_material *material;    /* of the stage */
    double gravity[3];                        /* components as the particles' */
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

/* A sample whose last step is complete (sample_complete, step_completion.h): what looks at the state takes this. Good
 * until the sample changes. */
struct complete_sample {
    const struct sample *sample;
};

/* Makes a sample with the model of the scene and room for its particles, without any state yet; for checkpoints. */
enum status sample_create_empty(struct sample **sample, const struct scene *scene) MUST_USE;

/* Makes the sample of the scene at step 0 from its initial packing. `scene` must outlive the sample. Errors:
 * STATUS_NO_MEMORY, STATUS_LIMIT (no room), STATUS_USAGE (SHAKEDOWN_ISA). */
enum status sample_create(struct sample **sample, const struct scene *scene) MUST_USE;
void sample_free(struct sample *sample);

/* A sample that has its particles and walls gets ready for its first step: walls at rest where they are, lists. */
enum status sample_start(struct sample *sample) MUST_USE;

/* Prepares the lists of contacts for the particles' radii. */
enum status sample_init_lists(struct sample *sample) MUST_USE;

/* Builds the lists anew, for the positions as they are. Errors: as of verlet_list_build. */
enum status sample_build_lists(struct sample *sample) MUST_USE;

/* Hands all lists over to the kernels, as contact_list_close does. */
enum status sample_close_lists(struct sample *sample) MUST_USE;

/* List l: 0 the pairs, 1 + w those of wall w. */
const struct contact_list *sample_list(const struct sample *sample, int l);

/* Length of the box along component c [m]. */
double sample_box_length_m(const struct sample *sample, int c);

/* Index of the scene's axis that component c is (2D: 0 -> x, 1 -> z). */
enum axis sample_axis(const struct sample *sample, int c);

/* "reference 2d hysteretic frictionless": what is computed and how. */
void sample_kernel_set(const struct sample *sample, char *text, size_t size);

/* FNV-1a over positions, velocities (in the order of ids) and walls: equal bits, equal hash. */
uint64_t sample_hash(struct complete_sample whole);

#endif
