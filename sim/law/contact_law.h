/* The law of a contact: the constants of a stage, and what contacts lose. The kernels' text of the law is
 * contact_law_tmpl.h. */
#ifndef SHAKEDOWN_SIM_LAW_CONTACT_LAW_H
#define SHAKEDOWN_SIM_LAW_CONTACT_LAW_H

#include "common/scene.h"

/* One stage's law, ready for the kernels. */
struct contact_law_constants {
    double k1, k2, kc; /* N/m; linear law: k1 = k2, kc = 0 */
    double gamma_n;    /* kg/s */
    double mu_s, mu_d;
    double kt, inv_kt;    /* N/m, m/N */
    double gamma_t;       /* kg/s */
    double k2_minus_k1;   /* k2 delta_0 = (k2 - k1) delta_max */
    double branch_ratio;  /* on the adhesion branch delta_max = branch_ratio delta; 0 if k1 = k2 */
    double loading_loss;  /* hysteresis loss per increase of delta_max^2: k1 (1 - k1/k2) / 2 */
    double adhesion_loss; /* and per decrease: kc (1 + kc/k2) ((k2 - k1)/(k2 + kc))^2 / 2 */
};

/* Energy lost in contacts since the start of the stage [J]. */
struct contact_losses {
    double hysteresis, viscous_normal, viscous_tangential, friction;
};

/* Constants of a stage. */
struct contact_law_constants contact_law_constants_of(const struct scene_material *material);

/* Adds the losses of `lost` to `sum`. */
void contact_losses_add(struct contact_losses *sum, const struct contact_losses *lost);

/* Elastic force at overlap delta > 0 with history delta_max [N]. Hysteretic law [LH eq. 1.6]: loading k1 delta, un- and
 * reloading k2 (delta - delta_0), adhesion branch -kc delta; k1 = k2 and kc = 0 give exactly the linear k1 delta. */
static inline double contact_elastic_force(const struct contact_law_constants *law, double delta, double delta_max)
{
    double loading = law->k1 * delta;
    double unloading = law->k2 * delta - law->k2_minus_k1 * delta_max;
    double adhesion = -law->kc * delta;
    double lower = loading < unloading ? loading : unloading;
    return adhesion > lower ? adhesion : lower;
}

#endif
