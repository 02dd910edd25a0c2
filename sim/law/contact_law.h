/* The law of a contact: the constants of a stage, and what contacts lose. The text of the law itself is
 * contact_law_tmpl.h, that of each normal law normal_<name>.h. `n` is the unit normal from j (or the wall) to i. */
#ifndef SHAKEDOWN_SIM_LAW_CONTACT_LAW_H
#define SHAKEDOWN_SIM_LAW_CONTACT_LAW_H

#include "common/scene.h"

enum { NORMAL_CONSTANTS_MAX = 10 };

/* Against rolling or torsion; k = 0: none. */
struct contact_resistance {
    double mu, k, inv_k, gamma; /* N/m, m/N, kg/s */
};

/* One stage's law, ready for the kernels. */
struct contact_law_constants {
    double normal[NORMAL_CONSTANTS_MAX]; /* of the normal law, as its text has them; the last: gamma_n */
    double stiffness;                    /* upper bound of the normal stiffness [N/m]; contact_law_set_scale */
    double gamma_n;                      /* kg/s */
    double mu_s, mu_d;
    double kt, inv_kt; /* N/m, m/N */
    double gamma_t;    /* kg/s */
    struct contact_resistance rolling, torsion;
    bool no_pull;       /* the normal dashpot never makes a contact pull */
    bool elastic_limit; /* friction is limited by the elastic force alone */
    bool springs;       /* friction has springs; without friction, or with kt = 0, they stay as they are */
    double per_force;   /* 1/(a small force of the scene) [1/N], a power of 2; contact_law_set_scale */
};

/* What kernels count lengths [m], velocities [m/s] and forces [N] in: powers of 2, so that nothing is rounded.
 * Rotations go in velocity units over a metre. In double all are 1. */
struct law_units {
    double length, speed, force;
};

/* Energy lost in contacts since the start of the stage [J]. */
struct contact_losses {
    double hysteresis, viscous_normal, viscous_tangential, friction;
    double stiffness;                /* what a tangential stiffness that changes with the contact takes (Mindlin) */
    double rolling, viscous_rolling; /* by the friction and the dashpots of rolling and torsion */
};

/* Of one contact at a complete step: force on i and its tangential part [N], that of the tangential spring alone,
 * reversed, in its components; normal force, energy in the elastic normal force and in the tangential spring [J]. */
struct contact_forces {
    double total[3], tangential[3], spring[3];
    double rolling[3], torsion; /* those springs of rolling and torsion, likewise; spring_j has theirs too */
    double normal, elastic_j, spring_j;
};

/* Constants of a stage. normal: enum contact_law, that of the model (contact_model.h), which may be richer than the
 * stage's. */
struct contact_law_constants contact_law_constants_of(const struct scene_material *material, int normal);

/* The same of contacts with the walls of an axis: of the particles, with their wall_friction, but for what the walls'
 * own material says. Elastic constants of both are combined: 1/E* = sum (1 - nu^2)/E, 1/G* = sum 2 (2 - nu)(1 + nu)/E
 * (Johnson 1985). */
struct contact_law_constants contact_law_constants_of_walls(const struct scene_stage *stage, enum axis axis,
                                                            int normal);

/* Sets what follows from the size of the particles: the stiffness of a law whose stiffness goes with the force, that of
 * two particles of the radius under the force (0: none is known, a small overlap is taken), and the unit of force. */
void contact_law_set_scale(struct contact_law_constants *law, int normal, double radius_m, double force_n);

/* Traits of a normal law (enum normal_trait, contact_model.h). */
int contact_law_traits(int normal);

/* Adds the losses of `lost` to `sum`. */
void contact_losses_add(struct contact_losses *sum, const struct contact_losses *lost);

#endif
