/* What contacts are computed with: decided by the scene, the same for all stages. */
#ifndef SHAKEDOWN_SIM_LAW_CONTACT_MODEL_H
#define SHAKEDOWN_SIM_LAW_CONTACT_MODEL_H

#include <stdbool.h>

#include "common/scene.h"

struct contact_model {
    int dimension; /* 2 or 3 */
    int normal;    /* enum contact_law */
    bool frictional;
    bool rolling; /* and with rolling resistance */
    bool torsion; /* 3D: and with torsion resistance; then rolling, too */
    bool mixed;   /* in float (mixed precision), else in double */
    int traits;   /* of the normal law, enum normal_trait */
};

/* What a normal law asks for beside its constants. */
enum normal_trait {
    NORMAL_REMEMBERS_OVERLAP = 1, /* the largest overlap */
    NORMAL_PER_PAIR = 2,          /* reduced mass and radius of each contact (contact_slots.pair) */
    NORMAL_MINDLIN = 4            /* friction remembers a force, whose stiffness goes with the contact radius */
};

struct contact_model contact_model_of(const struct scene *scene);

/* The same from its parts, with the traits of the law, without resistance to rolling and torsion. */
struct contact_model contact_model_make(int dimension, int normal, bool frictional, bool mixed);

/* Constants of a contact, for laws with NORMAL_PER_PAIR: root of the reduced mass [kg^(1/2)], reduced radius a_i
 * a_j/(a_i + a_j), against a wall a_i, in the unit of the slots. */
enum { PAIR_ROOT_MASS, PAIR_RADIUS, PAIR_CONSTANTS };

/* 0: no friction, 1: of slip, 2: of rolling, too, 3: and of torsion; as FRICTION of for_each_model.h. */
static inline int contact_model_friction(const struct contact_model *model)
{
    return model->frictional + model->rolling + model->torsion;
}

/* Components of the tangential spring, of rotations and of moments: 0 without friction, 1 in 2D, 3 in 3D. */
static inline int contact_model_springs(const struct contact_model *model)
{
    return !model->frictional ? 0 : model->dimension == 2 ? 1 : 3;
}

#endif
