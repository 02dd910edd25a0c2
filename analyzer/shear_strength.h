/* Material parameters of a stage in which one axis leads: biaxial and triaxial compression and extension, drained, at
 * constant volume or on another path. Definitions: docs/analysis.md. */
#ifndef SHAKEDOWN_ANALYZER_SHEAR_STRENGTH_H
#define SHAKEDOWN_ANALYZER_SHEAR_STRENGTH_H

#include <stdbool.h>

#include "analyzer/curves.h"
#include "analyzer/quantity.h"
#include "analyzer/stiffness.h"
#include "common/scene.h"
#include "common/status.h"

/* Fills E_initial_pa ... critical.q_over_p of quantities[QUANTITIES] and `stiffness`; with too few samples they become
 * undefined with a reason. Reads the windows from scene->analysis. STATUS_NO_MEMORY. */
enum status shear_strength_evaluate(const struct curves *curves, const struct scene *scene, struct quantity *quantities,
                                    struct stiffness *stiffness) MUST_USE;

/* Dilatancy angle [rad] from s = -d eps_v/d|eps_zz| of logarithmic strains: of the flow rule, in compression s = 2 sin
 * psi/(1 - sin psi), so sin psi = s/(2 + s) ([LH] print a tan around the right-hand side, which their own numbers do
 * not follow); in extension s = 2 sin psi/(1 + sin psi), so sin psi = s/(2 - s). The error is propagated. NaN where
 * |sin psi| would be 1 or more. */
struct estimate shear_dilatancy_angle_rad(struct estimate slope, bool extension);

/* sin(phi) = (r - 1)/(r + 1) of the ratio r of the larger to the smaller stress (Mohr-Coulomb without cohesion). */
struct estimate shear_sin_phi(struct estimate ratio);

#endif
