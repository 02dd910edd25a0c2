/* One contact, or all of a list, in the law's own text: compiled for each model, and for CPUs with and without fused
 * multiply-adds, which give the same bits. */
#ifndef SHAKEDOWN_SIM_SAMPLE_CONTACT_LOOK_H
#define SHAKEDOWN_SIM_SAMPLE_CONTACT_LOOK_H

#include "sim/sample/contact_geometry.h"
#include "sim/sample/sample.h"

/* Forces of contact k of list l, which touches. */
typedef void contact_look(const struct sample *sample, int l, int k, const struct contact_geometry *g,
                          struct contact_forces *f);

/* Adds the elastic energies [J] of the contacts of list l. */
typedef void contact_energies(const struct sample *sample, int l, double *normal_j, double *tangential_j);

struct contact_looks {
    contact_look *forces;
    contact_energies *energies;
};

/* [law][dimension - 2][friction] */
extern const struct contact_looks contact_looks_plain[LAW_COUNT][2][4], contact_looks_fma[LAW_COUNT][2][4];

#endif
