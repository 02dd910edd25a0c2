/* Where the two sides of a candidate for contact are. */
#ifndef SHAKEDOWN_SIM_SAMPLE_CONTACT_GEOMETRY_H
#define SHAKEDOWN_SIM_SAMPLE_CONTACT_GEOMETRY_H

#include <math.h>

#include "sim/contacts/contact_list.h"

/* Of a candidate: overlap (<= 0: open), unit normal from j or the wall to i, and distance along it [m]. */
struct contact_geometry {
    double overlap, n[3], distance;
};

/* From positions as they are in double. Particle i against j; `dimension` should be known where this is compiled. */
static inline struct contact_geometry contact_geometry_of_pair(int dimension, const struct particles *p, int i, int j)
{
    struct contact_geometry g = {0};
    double d2 = 0;
    for (int c = 0; c < dimension; c++) {
        g.n[c] = p->x[c][i] - p->x[c][j];
        d2 += g.n[c] * g.n[c];
    }
    g.distance = sqrt(d2);
    for (int c = 0; c < dimension; c++)
        g.n[c] /= g.distance;
    g.overlap = p->radius[i] + p->radius[j] - g.distance;
    return g;
}

/* Particle i against a wall. */
static inline struct contact_geometry contact_geometry_at_wall(const struct particles *p, int i,
                                                               const struct wall *wall)
{
    struct contact_geometry g = {0};
    g.n[wall->axis] = wall->inward;
    g.distance = wall->inward * (p->x[wall->axis][i] - wall->x);
    g.overlap = p->radius[i] - g.distance;
    return g;
}

#endif
