/* How long a time step the contacts of a sample bear: known before the first step. */
#ifndef SHAKEDOWN_SIM_MEASURE_STEP_LIMIT_H
#define SHAKEDOWN_SIM_MEASURE_STEP_LIMIT_H

#include "sim/sample/sample.h"

/* Of one stage and the lightest particle of the sample. */
struct step_limit {
    double stable_s;      /* the longest step at which the scheme is stable */
    bool tangential;      /* tangential springs and rotation set it; */
    char contact_axis;    /* or contacts with the walls of this axis; 0: of particles */
    double contact_s;     /* duration of a contact of two such particles without damping, pi/sqrt(2 k/m) */
    double wall_stable_s; /* the longest at which the loops of stress-controlled walls are; INFINITY: no such walls */
    char wall_axis;       /* of the wall that sets it */
    double radius_m;      /* of the lightest particle */
};

/* The scheme of time_step.c on a spring and a dashpot, omega^2 = k/m and lambda = gamma/m, is stable for
 * omega^2 dt^2 + 4 lambda dt < 4, that is up to 2/(lambda + sqrt(lambda^2 + omega^2)). In a random close packing a
 * particle of radius a has d (1 + a/<a>) neighbours (2 d for one of the mean size, d for a small one between large
 * ones), d the dimension: along any line k is that of 1 + a/<a> contacts, and m the reduced mass with a mean particle.
 * Tangentially each contact pulls at a lever: a sphere's effective mass is 2/7 of its mass; rolling and torsion turn it
 * alone, at most at the lever of its radius: 2/5. */
struct step_limit step_limit_of(const struct sample *sample, const struct scene_stage *stage);

/* STATUS_CONFIG, with the key and the longest step that holds, if contacts do not bear the time step of a stage. */
enum status step_limit_check(const struct sample *sample) MUST_USE;

#endif
