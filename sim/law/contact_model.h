/* What contacts are computed with: decided by the scene, the same for all stages. */
#ifndef SHAKEDOWN_SIM_LAW_CONTACT_MODEL_H
#define SHAKEDOWN_SIM_LAW_CONTACT_MODEL_H

#include <stdbool.h>

#include "common/scene.h"

struct contact_model {
    int dimension; /* 2 or 3 */
    int normal;    /* enum contact_law */
    bool frictional;
    bool single; /* in float (mixed precision), else in double */
};

struct contact_model contact_model_of(const struct scene *scene);

/* Components of the tangential spring, of rotations and of moments: 0 without friction, 1 in 2D, 3 in 3D. */
static inline int contact_model_springs(const struct contact_model *model)
{
    return !model->frictional ? 0 : model->dimension == 2 ? 1 : 3;
}

#endif
