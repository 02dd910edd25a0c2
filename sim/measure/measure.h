/* Measurements of a complete step. None of them changes it. */
#ifndef SHAKEDOWN_SIM_MEASURE_MEASURE_H
#define SHAKEDOWN_SIM_MEASURE_MEASURE_H

#include "sim/sample/sample.h"

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

/* Inertial number of the fastest strain rate, p the mean wall stress: 3D |rate| 2 <a> sqrt(rho/p), 2D |rate|
 * sqrt(<m>/p) as the spheres are not as deep as the box; 0 without pressure. The last step need not be complete. */
double measure_inertial_number(const struct sample *sample);

/* The energy that passed through the sample in the stage, to hold the ledger's residual against [J]: the largest of the
 * work (of walls, gravity and a change of material), all losses, the change of what is held, and the kinetic energy at
 * the start. A stage that only comes to rest does no work, so that work alone is no measure. */
double measure_turnover_j(const struct sample *sample, const struct measurement *m);

/* What a residual is doubted against [J]: the turnover, but not less than MEASURE_HELD_PART of the energy, elastic and
 * kinetic, that is held at the start or now. A stage in which hardly anything passes has a turnover next to nothing,
 * and rounding and the first step leave more than that: 1e-7 to 1e-6 of what is held. */
double measure_ledger_scale_j(const struct sample *sample, const struct measurement *m);
extern const double MEASURE_HELD_PART;

/* Errors: STATUS_NO_MEMORY; STATUS_UNSTABLE if the energies are not finite. */
enum status measure(struct complete_sample whole, struct measurement *m) MUST_USE;

/* One contact as recorded. */
struct contact_measurement {
    int i, j; /* j < 0: wall -1-j */
    double overlap_m, normal_force_n;
    double normal[3], tangential_force_n[3];
    bool sliding;
    int list, member; /* where the sample has it (sample_list) */
};

/* Fills `out` with the contacts (overlap > 0) and returns their number; NULL only counts. Pairs first, by (i, j), then
 * walls, by wall; i and j are ids, i < j. */
int measure_contacts(struct complete_sample whole, struct contact_measurement *out);

/* What a contact remembers of field `column` (history_shown), of the record's i against j, in SI: as the state holds
 * it, springs half a time step ahead of positions. Writes and returns history_kind_values values. 2D: rotations about
 * +y. */
int measure_contact_history(const struct sample *sample, const struct contact_measurement *contact, int column,
                            double *value);

#endif
