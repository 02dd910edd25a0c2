/* Whether a sample is at rest, by the two figures that are usual for it. */
#ifndef SHAKEDOWN_SIM_MEASURE_AT_REST_H
#define SHAKEDOWN_SIM_MEASURE_AT_REST_H

#include "sim/sample/sample.h"

struct rest_figures {
    int contacts;            /* of particles and walls; 0: nothing touches, and the others say nothing */
    double energy_ratio;     /* E_kin/E_el */
    double unbalanced_force; /* mean size of the force on a particle that touches something, over the mean normal force
                                of a contact */
};

struct rest_figures rest_figures_of(struct complete_sample whole);

#endif
