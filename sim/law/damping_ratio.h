/* The dashpot that gives a restitution. */
#ifndef SHAKEDOWN_SIM_LAW_DAMPING_RATIO_H
#define SHAKEDOWN_SIM_LAW_DAMPING_RATIO_H

#include <math.h>

#include "common/scene.h"

/* 2 zeta acos(zeta)/sqrt(1 - zeta^2), and its continuation beyond critical damping: -ln e of an oscillator that is let
 * go where the force is 0. */
static inline double damping_ratio_loss(double zeta)
{
    const double root = sqrt(fabs(1 - zeta * zeta));
    if (root < 1e-6)
        return 2;
    return 2 * zeta * (zeta < 1 ? acos(zeta) : acosh(zeta)) / root;
}

/* zeta = gamma_n/(2 sqrt(k m_ij)) at which impacts have the material's restitution. A dashpot that may pull acts until
 * the overlap is 0: zeta = -ln e/sqrt(pi^2 + ln^2 e) [D eq. 1]. One that may not lets go when the force is 0: e =
 * exp(-2 zeta acos(zeta)/sqrt(1 - zeta^2)) (Schwager & Poeschel, Granular Matter 9 (2007) 465). The same for Hertz
 * contacts, whose overlap^(5/4) and speed obey the linear oscillator's equation (Antypov & Elliott 2011). */
static inline double damping_ratio_of(const struct scene_material *material)
{
    const double pi = 3.14159265358979323846, loss = -log(material->restitution);
    if (material->dashpot_pull == DASHPOT_PULL_ALLOWED)
        return loss / sqrt(pi * pi + loss * loss);
    double low = 0, high = 1 / sqrt(material->restitution); /* about 1/(2 sqrt(e)) far beyond critical damping */
    for (int k = 0; k < 60; k++) {
        const double middle = 0.5 * (low + high);
        if (damping_ratio_loss(middle) < loss)
            low = middle;
        else
            high = middle;
    }
    return material->restitution < 1 ? low : 0;
}

#endif
