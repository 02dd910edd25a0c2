/* The elastic normal force of one contact, for measurements; the kernels spell out the same (contact_law_tmpl.h). */
#ifndef SHAKEDOWN_SIM_LAW_CONTACT_LAW_H
#define SHAKEDOWN_SIM_LAW_CONTACT_LAW_H

#include "sim/contacts/contact_list.h"

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
