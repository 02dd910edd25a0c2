#include "sim/law/contact_model.h"

/* A stage with the linear law is hysteretic with k1 = k2, so that a scene may have both. */
static int normal_law_of(const struct scene *scene)
{
    int normal = LAW_LINEAR;
    for (int k = 0; k < scene->n_stages; k++)
        normal = scene->stage[k].material.law > normal ? scene->stage[k].material.law : normal;
    return normal;
}

struct contact_model contact_model_of(const struct scene *scene)
{
    return (struct contact_model){.dimension = (int)scene->dimension,
                                  .normal = normal_law_of(scene),
                                  .frictional = scene_is_frictional(scene),
                                  .single = scene->precision == PRECISION_MIXED};
}
