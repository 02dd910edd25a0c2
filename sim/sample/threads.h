/* Large samples on several threads, with the same bits for any number of them: pairs and particles are cut into pieces
 * that depend on the sample alone. Pieces of the pairs follow each other in space, and the even ones come before the
 * odd ones, so that those at work at the same time have no particle in common. */
#ifndef SHAKEDOWN_SIM_SAMPLE_THREADS_H
#define SHAKEDOWN_SIM_SAMPLE_THREADS_H

#include "sim/base/team.h"
#include "sim/kernels/kernels.h"
#include "sim/sample/thread_choice.h"

/* Of the list: the spans of one piece, and the first and the last row of the particles that they touch. */
struct threads_piece {
    int first_span, last_span;
    int lo, hi;
    struct contact_losses losses;
};

/* Of the particles: those of one span. */
struct threads_part {
    int piece;    /* the last one to add to their sums; below 0: there is none such */
    int complete; /* and after which of its spans these are complete, if not before */
    double power; /* of the background */
    bool far;
};

struct threads {
    int n;                       /* threads, at most */
    struct thread_choice choice; /* how many of them */
    struct team *team;           /* NULL: a small sample */
    int n_parts;                 /* of the particles; 1: a small sample, in one go */
    int n_cuts;                  /* of the pairs; 1: in one go, as particles in no order in space are */
    bool sweeps;                 /* a step goes on with a part as soon as its sums are complete */
    struct threads_piece *piece; /* [PIECES_MAX] */
    struct threads_part *part;   /* [n_parts] */
};

/* At most as many threads as wanted; 0: as the number of particles and the CPUs of this process suggest. Errors:
 * STATUS_NO_MEMORY. */
enum status threads_init(struct threads *threads, const struct particles *particles, int64_t wanted) MUST_USE;
void threads_free(struct threads *threads);

/* To be called when the list of pairs has been built. Every piece gets a padding particle of its own. */
void threads_cut(struct threads *threads, const struct particles *particles, struct contact_list *pairs);

/* The kernels on all threads: as pair_kernel over the whole list into particles->force, and as those of their names. */
void threads_pair(struct threads *threads, const struct kernels *kernels, struct particles *particles,
                  struct contact_list *pairs, const struct contact_law_constants *law, double dt_s,
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
