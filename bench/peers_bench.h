/* The two halves of the benchmark against peers: equal physics, and time. */
#ifndef SHAKEDOWN_BENCH_PEERS_BENCH_H
#define SHAKEDOWN_BENCH_PEERS_BENCH_H

#include <jansson.h>

#include "bench/peers_input.h"

enum { PEERS_REPS_MAX = 100 };

struct peers_case {
    const char *name, *file;
    long our_steps, steps; /* of a timed run */
};

/* One scene's benchmark. */
struct peers_work {
    const struct peers_case *at;
    const char *sim;                    /* the program */
    char folder[1024];                  /* of this scene */
    char checkpoint[CONFIG_STRING_MAX]; /* the prepared sample */
    struct scene *whole, *last;         /* the scene, and its last stage alone, from the checkpoint */
    int reps;
    int threads; /* ours has; the peers have as many ranks */
    json_t *report;
};

/* What the scene says, for peers: linear law with k1 in place of a hysteretic one. Walls and mean masses from the
 * sample, which is of that scene. */
struct peer_input peers_input_of(const struct scene *scene, const struct sample *sample);

/* Writes the packing and the script, runs the peer in the folder (it leaves a log of its own wherever it runs), with
 * what it says in FOLDER/NAME.log. `input`->data is set; `input`->dump is a name in the folder. */
enum status peers_run(struct peer_input *input, const struct sample *sample, const char *folder,
                      const char *name) MUST_USE;

/* Mean radius [m]. */
double peers_mean_radius(const struct sample *sample);

/* The stage's law, walls that stay, forces of the state. */
enum status peers_start_stage(struct sample *sample) MUST_USE;

/* Means over the contacts of a sample at a complete step, and over its particles. STATUS_NO_MEMORY. */
struct peers_scale {
    double force_n, overlap_m, diameter_m, mass_kg;
};
enum status peers_measure_scale(struct sample *sample, struct peers_scale *scale) MUST_USE;

/* Forces on every particle in states that load, shear, unload and slide the contacts, which have been through all
 * states before: of Hertz-Mindlin and of Luding's law with k2 that grows, for scenes of law "hertz". Prints a table and
 * adds it to the report. */
enum status peers_states(const struct peers_work *work) MUST_USE;

/* Forces on every particle, and positions after some hundred steps, of the peers and ours. Prints a table and adds it
 * to the report. */
enum status peers_physics(const struct peers_work *work) MUST_USE;

/* Time per step of many discs or spheres (packings of lattice_sample.h), ours with `threads` threads beside LAMMPS with
 * as many ranks; named "discs" or "spheres", NULL: both. Adds to `cases`. STATUS_USAGE for others, or more threads than
 * this process may use CPUs. */
struct peers_threads {
    const char *sim, *out, *only;
    int threads, count, reps;
};
enum status peers_threads(const struct peers_threads *options, json_t *cases) MUST_USE;

/* Time per step, all in turn; of a law "hertz" also ours with a linear law of about the same stiffness. A hysteretic
 * sample is first settled with the linear law of its k1, so that the peers, who start without history, get one at rest.
 */
enum status peers_timing(const struct peers_work *work) MUST_USE;

#endif
