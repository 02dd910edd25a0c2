/* Large samples on several threads, with the same bits for any number of them: pairs and particles are cut into pieces
 * that depend on the sample alone; each piece of the pairs adds up in an array of its own, and these are summed piece
 * by piece. */
#ifndef SHAKEDOWN_SIM_THREADS_H
#define SHAKEDOWN_SIM_THREADS_H

#include "sim/kernels.h"

/* Of the list: the sets of one piece, and the rows of the particles that they touch. */
struct threads_piece {
    int first_set, last_set;
    int first_row, last_row;
    void *force; /* as particles->force; all zero between force evaluations */
    void *memory;
    struct contact_losses losses;
};

struct threads {
    int n;        /* threads */
    int n_pieces; /* 1: a small sample, in one go */
    struct threads_piece *piece;
    double *power; /* [n_pieces] of the background, piece by piece */
};

/* As many threads as wanted; 0: as the number of particles and the CPUs of this process suggest. Errors:
 * STATUS_NO_MEMORY. */
enum status threads_init(struct threads *threads, const struct particles *particles, int64_t wanted) MUST_USE;
void threads_free(struct threads *threads);

/* To be called when the list of pairs has been built. */
void threads_cut(struct threads *threads, const struct particles *particles, const struct contact_list *pairs);

/* The kernels on all threads: as pair_kernel over the whole list into particles->force, and as those of their names. */
void threads_pair(struct threads *threads, const struct kernels *kernels, struct particles *particles,
                  struct contact_list *pairs, const struct contact_law_constants *law, struct contact_losses *losses);
bool threads_drift(const struct threads *threads, const struct kernels *kernels, struct particles *particles,
                   double dt_s, double reach_m);
bool threads_advance(const struct threads *threads, const struct kernels *kernels, struct particles *particles,
                     const struct kick_constants *constants, double dt_s, double reach_m, double *background_w);
double threads_kick(const struct threads *threads, const struct kernels *kernels, struct particles *particles,
                    const struct kick_constants *constants);

#endif
