/* Large samples on several threads, with the same bits for any number of them: pairs are cut into blocks, particles
 * into parts and walls into pieces that depend on the sample alone (halo.h), and sums over these have a fixed order. */
#ifndef SHAKEDOWN_SIM_SAMPLE_THREADS_H
#define SHAKEDOWN_SIM_SAMPLE_THREADS_H

#include "sim/base/thread_team.h"
#include "sim/kernels/kernels.h"
#include "sim/sample/halo.h"
#include "sim/sample/thread_choice.h"

/* Sets in a piece of a wall's contacts: short, so that many threads have some (a wall of 1e5 spheres has 135 sets), but
 * longer than it takes to hand out. */
enum { THREADS_PIECE_SETS = 8 };

/* Of the particles: those of one span. */
struct threads_part {
    double power; /* of the background */
    bool far, late;
};

/* Of a wall's contacts: some sets of them. */
struct threads_piece {
    double force;
    int touching;
    struct contact_losses losses;
};

struct threads {
    int n;                       /* threads, at most */
    struct thread_choice choice; /* how many of them */
    struct thread_team *team;    /* NULL: a small sample */
    int n_parts;                 /* of the particles; 1: a small sample, in one go */
    struct threads_part *part;   /* [n_parts] */
    struct halo halo;
    struct contact_losses *losses; /* [halo.blocks_max] */
    double *block_s;               /* [halo.blocks_max] time of each block in the last step; NULL: nobody asks */
    double walls_s;                /* and of all walls, in steps that somebody asks about */
    struct threads_piece *piece;   /* [piece_capacity] */
    int piece_capacity;
    bool apart[3]; /* no particle can touch both walls of an axis */
};

/* At most as many threads as wanted; 0: as the number of particles and the CPUs of this process suggest. Errors:
 * STATUS_NO_MEMORY. */
enum status threads_init(struct threads *threads, const struct particles *particles, int64_t wanted) MUST_USE;
void threads_free(struct threads *threads);

/* To be called when the lists of pairs and walls have been closed. Errors: STATUS_NO_MEMORY. */
enum status threads_cut(struct threads *threads, struct particles *particles, struct contact_list *pairs,
                        const struct wall *walls, int n_walls) MUST_USE;

/* The kernels on all threads: as pair_kernel over the whole list into particles->force, as wall_kernel for all walls,
 * and as those of their names. */
void threads_pair(struct threads *threads, const struct kernels *kernels, struct particles *particles,
                  struct contact_list *pairs, const struct contact_law_constants *law, double dt_s,
                  struct contact_losses *losses);
void threads_walls(struct threads *threads, const struct kernels *kernels, struct particles *particles,
                   struct wall *walls, int n_walls, const struct contact_law_constants *law_of_axis, double dt_s,
                   struct contact_losses *losses);
bool threads_drift(struct threads *threads, const struct kernels *kernels, struct particles *particles, double dt_s,
                   double before_s, double reach_m);
double threads_kick(struct threads *threads, const struct kernels *kernels, struct particles *particles,
                    const struct kick_constants *constants);

/* What the rest of a step and the drift of the next want to know. */
struct threads_sweep {
    const struct contact_law_constants *law;
    const struct kick_constants *kick;
    double dt_s, reach_m; /* of the step that ends and of the drift */
};

/* Forces between particles, kick and drift of the next step, all at once: the same bits as one after the other. Adds
 * the energy lost. Returns what advance_kernel does. */
bool threads_sweep(struct threads *threads, const struct kernels *kernels, struct particles *particles,
                   struct contact_list *pairs, const struct threads_sweep *sweep, struct contact_losses *losses,
                   double *background_w);

#endif
