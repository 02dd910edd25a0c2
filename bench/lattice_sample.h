/* Dense packings of any size that need no preparation: a jittered lattice with the radii and materials of scenes A (2D)
 * and B (3D), at the solid fraction that gives the scene's number of contacts, relaxed under strong damping between
 * walls that stay. Stage 0 relaxes, without friction; stage 1 is the test. */
#ifndef SHAKEDOWN_BENCH_LATTICE_SAMPLE_H
#define SHAKEDOWN_BENCH_LATTICE_SAMPLE_H

#include "sim/sample/sample.h"

struct lattice_kind {
    int dimension;
    double solid_fraction, jitter; /* of the spacing */
    const char *text;              /* of the scene, for threads, precision and count */
};

/* Of 2 or 3 dimensions; NULL of others. */
const struct lattice_kind *lattice_kind_of(int dimension);

/* The scene, to be freed by scene_free. precision: "double" or "mixed". STATUS_CONFIG. */
enum status lattice_scene(struct scene *scene, const struct lattice_kind *kind, int threads, const char *precision,
                          int count) MUST_USE;

/* Shrinks the lattice of a sample that such a scene has made, with its walls, to the solid fraction, and jitters it.
 * Particles get their places at random, as after long mixing, or `ordered` in rows. STATUS_NO_MEMORY. */
enum status lattice_pack(struct sample *sample, const struct lattice_kind *kind, bool ordered) MUST_USE;

/* Starts a stage with the walls at rest where they are; n steps of it. Errors: as of sample_step_open. */
enum status lattice_begin(struct sample *sample, int stage) MUST_USE;
enum status lattice_steps(struct sample *sample, int n) MUST_USE;

#endif
