/* The kernels of a time step, specialised at compile time for each model and instruction set (contact_law_tmpl.h) and
 * chosen at the start of a run. */
#ifndef SHAKEDOWN_SIM_KERNELS_KERNELS_H
#define SHAKEDOWN_SIM_KERNELS_KERNELS_H

#include "sim/contacts/contact_list.h"
#include "sim/lanes/instruction_set.h"

struct kick_constants {
    double dt;
    double gamma_b, gamma_br; /* kg/s */
    double gravity[3];        /* m/s^2, components as the particles' */
};

/* Forces and moments of the pairs in spans first ... last - 1 of the list, in `force`: particles->force, or another
 * array of that kind (particles.h). They are added to the rows, and the columns of the spans' particles are set.
 * History changes. Adds the energy lost.
 * dt_s: 0: forces are evaluated anew and no time passes. */
typedef void pair_kernel(const struct particles *particles, struct contact_list *pairs, int first, int last,
                         const struct contact_law_constants *law, double dt_s, void *force,
                         struct contact_losses *losses);

/* The same for the contacts of one wall, added to particles->force; sets the wall's force and how many
 * touch it. */
typedef void wall_kernel(struct particles *particles, struct wall *wall, const struct contact_law_constants *law,
                         double dt_s, struct contact_losses *losses);

/* Positions of the next step, velocities of the middle on the way and those predicted for its end; makes views and
 * records. True if a particle is further than reach_m from where the lists were built, or not finite. before_s: the
 * time step that kick has completed, 0 if p->v was given anew since. Both 0: only views and records. */
typedef bool drift_kernel(struct particles *particles, double dt_s, double before_s, double reach_m);

/* Accelerations and velocities of the end of the step; zeroes the rows of the sums. Returns the power that background
 * damping takes [W]. */
typedef double kick_kernel(struct particles *particles, const struct kick_constants *constants);

/* The kick of a step and the drift of the next in one pass, the same bits as one after the other. */
typedef bool advance_kernel(struct particles *particles, const struct kick_constants *constants, double dt_s,
                            double reach_m, double *background_w);

struct kernels {
    pair_kernel *pair;
    wall_kernel *wall;
    drift_kernel *drift;
    kick_kernel *kick;
    advance_kernel *advance;
};

/* Kernels specialised for a model. */
struct kernels kernels_select(enum instruction_set isa, const struct contact_model *model);

#endif
