/* Material parameters of a strain-controlled stage (biaxial, triaxial). Definitions: docs/analysis.md. */
#ifndef SHAKEDOWN_ANALYZER_BIAXIAL_H
#define SHAKEDOWN_ANALYZER_BIAXIAL_H

#include "analyzer/curves.h"
#include "analyzer/quantity.h"
#include "common/scene.h"
#include "common/status.h"

/* Fills E_initial_pa ... critical.q_over_p of quantities[QUANTITIES]; in a stage of another kind, or with too few
 * samples, they become undefined with a reason. Reads the windows from scene->analysis. STATUS_NO_MEMORY. */
enum status biaxial_evaluate(const struct curves *curves, const struct scene *scene,
                             struct quantity *quantities) MUST_USE;

/* Dilatancy angle [rad] from s = -d eps_v/d eps_zz of logarithmic strains: s = 2 sin psi/(1 - sin psi), so sin psi =
 * s/(2 + s) ([LH] print a tan around the right-hand side, which their own numbers do not follow). The error is
 * propagated. NaN for s <= -1. */
struct estimate biaxial_dilatancy_angle_rad(struct estimate slope);

/* sin(phi) = (r - 1)/(r + 1) of the stress ratio r = sigma_zz/sigma_xx (Mohr-Coulomb without cohesion). */
struct estimate biaxial_sin_phi(struct estimate ratio);

#endif
