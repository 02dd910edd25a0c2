#include "common/scene_check.h"
#include "common/scene_keys.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static enum status friction_check(const struct scene_material *m, const config_setting_t *at, const char *where)
{
    if (m->mu_d < 0 && m->mu_d != -1.0)
        return config_fail(at, where, "mu_d (%g) must not be negative; only -1 stands for mu_s", m->mu_d);
    if (m->mu_d > m->mu_s)
        return config_fail(at, where, "mu_d (%g) must not exceed mu_s (%g)", m->mu_d, m->mu_s);
    if (m->mu_rolling > 0 && !(m->kr_n_per_m > 0))
        return config_fail(at, where, "mu_rolling above 0 needs kr_n_per_m above 0");
    if (m->mu_torsion > 0 && !(m->ko_n_per_m > 0))
        return config_fail(at, where, "mu_torsion above 0 needs ko_n_per_m above 0");
    return STATUS_OK;
}

/* Checks between the keys of one material; `where` is its path. */
static enum status material_check(const struct scene_material *m, const config_setting_t *at, const char *where)
{
    const char *k2_key = m->law == LAW_ELASTOPLASTIC ? "kp_n_per_m" : "k2_n_per_m";
    const double k2 = fmax(m->k2_n_per_m, m->kp_n_per_m);
    TRY(scene_check_law_keys(m, at, where));
    if (m->k1_n_per_m > k2)
        return config_fail(at, where, "law \"%s\" needs 0 < k1_n_per_m <= %s (here %g and %g)", scene_law_name(m->law),
                           k2_key, m->k1_n_per_m, k2);
    TRY(friction_check(m, at, where));
    if (m->mu_s > 0 && scene_law_takes(m->law, "kt_n_per_m") && !(m->kt_n_per_m > 0))
        return config_fail(at, where, "friction (mu_s above 0) needs kt_n_per_m above 0");
    return STATUS_OK;
}

/* Contacts of a scene are of one model. */
static bool fit_in_one_scene(int a, int b)
{
    return a == b || scene_law_expresses(a, b) || scene_law_expresses(b, a);
}

/* A law against those of the stages before `end`. */
static enum status laws_check(const struct scene *scene, const struct scene_stage *end, int law,
                              const config_setting_t *at, const char *path)
{
    for (const struct scene_stage *other = scene->stage; other != end; other++)
        if (!fit_in_one_scene(law, other->material.law))
            return config_fail(at, path, "law \"%s\" does not go with law \"%s\" of stage \"%s\"", scene_law_name(law),
                               scene_law_name(other->material.law), other->name);
    return STATUS_OK;
}

enum status scene_check_material(const struct scene *scene, const struct scene_stage *stage, const config_setting_t *at,
                                 const char *where)
{
    char path[128];
    snprintf(path, sizeof path, "%s.material", where);
    TRY(material_check(&stage->material, at, path));
    TRY(laws_check(scene, stage, stage->material.law, at, path));
    for (int k = 0; k < SCENE_AXES; k++) {
        struct scene_material of_walls;
        if ((scene->dimension == 2 && k == AXIS_Y) || !scene_wall_material(stage, (enum axis)k, &of_walls))
            continue;
        snprintf(path, sizeof path, "%s.walls.%c.material", where, "xyz"[k]);
        TRY(material_check(&of_walls, at, path));
        TRY(laws_check(scene, stage + 1, of_walls.law, at, path));
    }
    return STATUS_OK;
}

/* What a name is in that of a checkpoint. */
static char file_character(char c)
{
    return c == '/' ? '_' : c;
}

static bool same_file(const char *a, const char *b)
{
    while (*a && file_character(*a) == file_character(*b))
        a++, b++;
    return file_character(*a) == file_character(*b);
}

enum status scene_check_name(const struct scene *scene, int64_t index, const config_setting_t *at, const char *where)
{
    enum { NAME_LONGEST = 200 }; /* of a file: 255 */
    const char *name = scene->stage[index].name;
    if (!name[0] || strlen(name) > NAME_LONGEST)
        return config_fail(at, where, "name has %zu characters; allowed: 1 to %d", strlen(name), NAME_LONGEST);
    for (int64_t k = 0; k < index; k++)
        if (same_file(name, scene->stage[k].name))
            return config_fail(at, where,
                               "name \"%s\": there is a stage \"%s\" already, and each writes a checkpoint-NAME.h5 "
                               "(with _ for /)",
                               name, scene->stage[k].name);
    return STATUS_OK;
}
