/* What the numbers of a scene mean to its physics and cost: stiffness, inertia, ringing, walls, steps. */
#ifndef SHAKEDOWN_SIM_RUN_EXPLAIN_SCALES_H
#define SHAKEDOWN_SIM_RUN_EXPLAIN_SCALES_H

#include <stdio.h>

#include "sim/sample/sample.h"

/* Estimates for stage `s` [N, m, s], from the mean particle, a solid fraction of 0.62 (2D 0.83), six contacts (2D four)
 * under the largest pressure that the stage has as a target, and K = z phi k/(3 pi d) (2D z phi k/(2 pi)), exact for
 * lattices of springs; a constrained modulus of 1.8 K. All 0 without a pressure. */
struct stage_scales {
    double pressure_pa;
    double stiffness_n_per_m; /* of contacts under their mean force */
    double kappa;             /* k/(p d), 2D k/p: 1/kappa is about overlap over diameter */
    double modulus_over_p;    /* Hertz-Mindlin: E over p, of two particles; else 0 */
    double contact_s, inertial_s;
    double rate_per_s, inertial_number; /* largest rate of the stage's courses; 0: none */
    double length_m;                    /* of the packed box */
    double wave_s;                      /* there and back */
    double grain_kg;
    double wall_damping_kg_per_s; /* at I = 1e-3 a wall with this damping is 0.1 % of p off */
};

struct stage_scales stage_scales_of(const struct sample *sample, int s);

/* Prints them for all stages, with what is recommended, and what the run costs on this machine, from steps of a
 * touching lattice of as many mean particles, timed for a tenth of a second. */
enum status explain_scales(FILE *out, const struct sample *sample) MUST_USE;

#endif
