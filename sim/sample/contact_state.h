/* What contacts do at a complete step, from the state alone, so that the kernels need not keep it. */
#ifndef SHAKEDOWN_SIM_SAMPLE_CONTACT_STATE_H
#define SHAKEDOWN_SIM_SAMPLE_CONTACT_STATE_H

#include "sim/sample/contact_geometry.h"
#include "sim/sample/sample.h"

/* Of candidate k of list l (sample_list), from positions as they are in double. */
struct contact_geometry contact_geometry_at(const struct sample *sample, int l, int k);

/* Candidate k of list l (sample_list). False if it is open; `forces` is not set then. */
bool contact_state_at(struct complete_sample whole, int l, int k, struct contact_geometry *geometry,
                      struct contact_forces *forces);

/* Sums over the contacts of all lists. */
struct contact_survey {
    double elastic_normal_j, elastic_tangential_j;
    double max_overlap_ratio;
    double stress[9], fabric[9]; /* sums over contacts; fabric over those between particles */
    int pairs, walls, sliding;
    int32_t *i, *j; /* [candidates] touching particles, j < 0: a wall */
};

/* Adds all contacts to `sum`. */
void contact_survey_make(struct complete_sample whole, struct contact_survey *sum);

/* The elastic energy of all contacts [J]: of normal forces and of springs, those of rolling and torsion among them. */
double contact_state_elastic_j(struct complete_sample whole);

#endif
