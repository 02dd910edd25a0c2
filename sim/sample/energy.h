/* What a sample holds. */
#ifndef SHAKEDOWN_SIM_SAMPLE_ENERGY_H
#define SHAKEDOWN_SIM_SAMPLE_ENERGY_H

#include "sim/sample/sample.h"

double energy_kinetic_j(struct complete_sample whole);   /* translation and rotation */
double energy_potential_j(struct complete_sample whole); /* in gravity: -sum m g.x */

/* As the controller's conditions, the ledger and the audit of the coupling take it. */
struct held_energy {
    double kinetic_j;
    double elastic_j; /* sum f^2/(2 k2) of the elastic normal forces + sum kt xi^2/2 */
};
struct held_energy energy_held(struct complete_sample whole);

/* The ledger of a stage that begins now. */
struct ledger energy_ledger_start(struct complete_sample whole);

#endif
