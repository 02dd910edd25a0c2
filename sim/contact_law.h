/* The contact laws for one contact, as the kernels and the measurements use them. Everything is a select, not a
 * branch, so that the compiler can run many contacts at a time. */
#ifndef SHAKEDOWN_SIM_CONTACT_LAW_H
#define SHAKEDOWN_SIM_CONTACT_LAW_H

#include <math.h>

#include "sim/contacts.h"

#define CONTACT_INLINE static inline __attribute__((always_inline))

CONTACT_INLINE double larger(double a, double b)
{
    return a > b ? a : b;
}

CONTACT_INLINE double smaller(double a, double b)
{
    return a < b ? a : b;
}

/* Elastic force of the hysteretic law [LH eq. 1.6] at overlap delta > 0 with history delta_max [N]:
 * loading k1 delta, un- and reloading k2 (delta - delta_0), adhesion branch -kc delta.
 * k1 = k2 and kc = 0 give exactly k1 delta. */
CONTACT_INLINE double hysteretic_force(const struct contact_law_constants *law, double delta, double delta_max)
{
    double loading = law->k1 * delta;
    double unloading = law->k2 * delta - law->k2_minus_k1 * delta_max;
    double adhesion = -law->kc * delta;
    return larger(adhesion, smaller(loading, unloading));
}

/* The history after that: it grows on loading, and moves with the contact on the adhesion branch, so that reloading
 * follows a k2 line through the point where the branch was left. */
CONTACT_INLINE double hysteretic_history(const struct contact_law_constants *law, double delta, double delta_max)
{
    double loading = law->k1 * delta;
    double unloading = law->k2 * delta - law->k2_minus_k1 * delta_max;
    double adhesion = -law->kc * delta;
    double moved = unloading <= adhesion ? law->branch_ratio * delta : delta_max;
    return unloading >= loading ? delta : moved;
}

/* Energy lost by the change of history from `before` to `after` (0: the contact opened) [J]. Exact along any path:
 * what is stored is f^2/(2 k2), and both branches lose in proportion to the change of delta_max^2. */
CONTACT_INLINE double hysteretic_loss(const struct contact_law_constants *law, double before, double after)
{
    double change = after * after - before * before;
    return change > 0 ? law->loading_loss * change : -law->adhesion_loss * change;
}

/* Normal force that limits friction: never below 0, and counted from the adhesion branch, so that a contact that is
 * pulled to its strongest attraction does not hold sideways (Luding 2008, eq. 15). */
CONTACT_INLINE double friction_normal_force(const struct contact_law_constants *law, double normal_force, double delta)
{
    return larger(0.0, normal_force + law->kc * delta);
}

CONTACT_INLINE void contact_losses_add(struct contact_losses *sum, const struct contact_losses *lost)
{
    sum->hysteresis += lost->hysteresis;
    sum->viscous_normal += lost->viscous_normal;
    sum->viscous_tangential += lost->viscous_tangential;
    sum->friction += lost->friction;
}

#endif
