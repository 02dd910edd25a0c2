/* Measurements of the sample at the current step. None of them changes it. */
#ifndef SHAKEDOWN_SIM_LOOK_MEASURE_H
#define SHAKEDOWN_SIM_LOOK_MEASURE_H

#include "sim/sample/sample.h"

double measure_kinetic_energy_j(const struct sample *sample);   /* translation and rotation */
double measure_potential_energy_j(const struct sample *sample); /* in gravity: -sum m g.x */

/* What the sample holds now, as the controller's conditions, the ledger and the watch take it. */
struct held_energy {
    double kinetic_j;
    double elastic_j; /* sum f^2/(2 k2) of the elastic normal forces + sum kt xi^2/2 */
};
struct held_energy measure_held_energy(const struct sample *sample);

/* Upper bound of each wall's tangent stiffness, sum of k2, and damping, sum of gamma_n, over its contacts; [n_walls].
 */
void measure_wall_stiffness(const struct sample *sample, double *stiffness_n_per_m, double *damping_kg_per_s);

/* Everything of a sample_t but its header. Tensors row major, dimension x dimension; compression positive. */
struct measurement {
    double box_length_m[3], strain[3], stress_wall_pa[3];
    double stress_contact_pa[9]; /* (1/V) sum f (x) l, walls included; l from j to i, or from the wall to i */
    double fabric[9];            /* (1/N_c) sum n (x) n between particles */
    double solid_fraction;
    double coordination, coordination_no_rattlers, rattler_fraction;
    int n_contacts, n_wall_contacts;
    double sliding_fraction, max_overlap_ratio, inertial_number;
    double kinetic_j, elastic_normal_j, elastic_tangential_j;
    double work_gravity_j, residual_j;
};

/* Errors: STATUS_NO_MEMORY; STATUS_UNSTABLE if the energies are not finite. */
enum status measure(const struct sample *sample, struct measurement *m) MUST_USE;

/* One contact as recorded. */
struct contact_measurement {
    int i, j; /* j < 0: wall -1-j */
    double overlap_m, normal_force_n;
    double normal[3], tangential_force_n[3];
    bool sliding;
};

/* Fills `out` with the contacts (overlap > 0) and returns their number; NULL only counts. Pairs first, by (i, j), then
 * walls, by wall; i and j are ids, i < j. */
int measure_contacts(const struct sample *sample, struct contact_measurement *out);

#endif
