/* A step on more cores than there are: measured times of the blocks of a sample, dealt out to so many threads as
 * sim/base/thread_team.c does. */
#ifndef SHAKEDOWN_BENCH_SCALING_MODEL_H
#define SHAKEDOWN_BENCH_SCALING_MODEL_H

/* What a step is made of, with one thread [us]. */
struct scaling_model {
    int n_blocks;
    const double *block_us;              /* [n_blocks] */
    double walls_us;                     /* of all walls */
    int n_axes;                          /* whose walls are done one axis after the other, */
    const int *n_pieces;                 /* [n_axes] in so many pieces */
    int n_jobs;                          /* all jobs of a step, those of the walls among them */
    double serial_us;                    /* the rest, which one thread does */
    double job_us;                       /* to hand out a job and to wait for its end */
    double bytes_mb, bandwidth_gb_per_s; /* that a step moves, and that all cores together can */
    double data_mb, cache_mb;            /* that a step needs; and what each core has of caches, part of shared ones */
};

/* Longest time that one of `threads` threads works on pieces that take so long each, every thread beginning with a
 * share of pieces side by side and going on with those of the others; threads <= 256 [us]. */
double scaling_model_makespan(const double *piece_us, int n, int threads);

/* Time of a step with so many threads [us]; all of it with one. No less than its bytes over the bandwidth, unless the
 * caches of so many cores hold its data. */
double scaling_model_step_us(const struct scaling_model *model, int threads);

#endif
