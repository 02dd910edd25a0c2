#include "sim/law/contact_model.h"

#include "sim/law/contact_law.h"

/* A stage with the linear law is hysteretic with k1 = k2, so that a scene may have both; and so are walls. */
static int normal_law_of(const struct scene *scene)
{
    int normal = LAW_LINEAR;
    for (int k = 0; k < scene->n_stages; k++)
        for (int axis = 0; axis < SCENE_AXES; axis++) {
            const int law = scene->stage[k].material.law;
            struct scene_material of_walls;
            (void)scene_wall_material(&scene->stage[k], (enum axis)axis, &of_walls);
            normal = law > normal ? law : normal;
            normal = of_walls.law > normal ? of_walls.law : normal;
        }
    return normal;
}

struct contact_model contact_model_make(int dimension, int normal, bool frictional, bool mixed)
{
    return (struct contact_model){.dimension = dimension,
                                  .normal = normal,
                                  .frictional = frictional,
                                  .mixed = mixed,
                                  .traits = contact_law_traits(normal)};
}

struct contact_model contact_model_of(const struct scene *scene)
{
    struct contact_model model = contact_model_make((int)scene->dimension, normal_law_of(scene),
                                                    scene_is_frictional(scene), scene->precision == PRECISION_MIXED);
    model.rolling = scene_resists_rolling(scene);
    model.torsion = scene->dimension == 3 && scene_resists_torsion(scene);
    return model;
}
