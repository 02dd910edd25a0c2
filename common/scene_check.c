#include "common/scene_check.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static enum status friction_check(const struct scene_material *m, const config_setting_t *at, const char *where)
{
    if (m->mu_d < 0 && m->mu_d != -1.0)
        return config_fail(at, where, "mu_d (%g) must not be negative; only -1 stands for mu_s", m->mu_d);
    if (m->mu_d > m->mu_s)
        return config_fail(at, where, "mu_d (%g) must not exceed mu_s (%g)", m->mu_d, m->mu_s);
    return STATUS_OK;
}

/* Stiffness and damping of both directions follow from the elastic constants. */
static enum status hertz_check(const struct scene_material *m, const config_setting_t *at, const char *where)
{
    if (!(m->youngs_modulus_pa > 0))
        return config_fail(at, where, "law \"hertz\" needs youngs_modulus_pa above 0");
    if (m->kn_n_per_m > 0 || m->k1_n_per_m > 0 || m->k2_n_per_m > 0 || m->kc_n_per_m > 0 || m->kt_n_per_m > 0)
        return config_fail(at, where,
                           "law \"hertz\" takes youngs_modulus_pa and poisson_ratio; kn, k1, k2, kc and kt "
                           "belong to the other laws");
    if (m->gamma_n_kg_per_s > 0 || m->gamma_t_kg_per_s > 0)
        return config_fail(at, where, "law \"hertz\" takes restitution; gamma_n and gamma_t belong to the other laws");
    return friction_check(m, at, where);
}

static enum status linear_check(const struct scene_material *m, const config_setting_t *at, const char *where)
{
    if (!(m->kn_n_per_m > 0))
        return config_fail(at, where, "law \"linear\" needs kn_n_per_m above 0");
    if (m->k1_n_per_m > 0 || m->k2_n_per_m > 0 || m->kc_n_per_m > 0 || m->kp_n_per_m > 0)
        return config_fail(at, where,
                           "k1, k2, kc and kp belong to law \"hysteretic\"; law \"linear\" takes kn_n_per_m");
    if (m->restitution < 1 && m->gamma_n_kg_per_s > 0)
        return config_fail(at, where, "restitution and gamma_n_kg_per_s say the same: one of them");
    return STATUS_OK;
}

static enum status hysteretic_check(const struct scene_material *m, const config_setting_t *at, const char *where)
{
    const bool grows = m->law == LAW_ELASTOPLASTIC;
    const double k2 = grows ? m->kp_n_per_m : m->k2_n_per_m;
    if (!(m->k1_n_per_m > 0 && k2 >= m->k1_n_per_m))
        return config_fail(at, where, "law \"%s\" needs 0 < k1_n_per_m <= %s (here %g and %g)",
                           grows ? "elastoplastic" : "hysteretic", grows ? "kp_n_per_m" : "k2_n_per_m", m->k1_n_per_m,
                           k2);
    if (grows && m->k2_n_per_m > 0)
        return config_fail(at, where, "kp_n_per_m, to which k2 grows, and k2_n_per_m exclude each other");
    if (grows && !(m->phi_f > 0))
        return config_fail(at, where, "law \"elastoplastic\" needs phi_f above 0");
    if (m->kn_n_per_m > 0)
        return config_fail(at, where, "kn_n_per_m belongs to law \"linear\"; law \"hysteretic\" takes k1 and k2");
    if (m->restitution < 1)
        return config_fail(at, where,
                           "restitution belongs to the laws \"linear\" and \"hertz\"; here the history loses");
    return STATUS_OK;
}

/* Checks between the keys of one material; `where` is its path. */
static enum status material_check(const struct scene_material *m, const config_setting_t *at, const char *where)
{
    const bool is_linear = m->law == LAW_LINEAR || m->law == LAW_LINEAR_RESTITUTION;
    if (m->law == LAW_HERTZ)
        return hertz_check(m, at, where);
    if (m->youngs_modulus_pa > 0)
        return config_fail(at, where, "youngs_modulus_pa and poisson_ratio belong to law \"hertz\"");
    TRY(is_linear ? linear_check(m, at, where) : hysteretic_check(m, at, where));
    TRY(friction_check(m, at, where));
    if (m->mu_s > 0 && !(m->kt_n_per_m > 0))
        return config_fail(at, where, "friction (mu_s above 0) needs kt_n_per_m above 0");
    return STATUS_OK;
}

/* Contacts of a scene are of one model: the linear law is the hysteretic one with k1 = k2, or that with a restitution
 * of 1; the hysteretic law is the elastoplastic one whose k2 does not grow. */
static bool fit_in_one_scene(int a, int b)
{
    const int least = a < b ? a : b, most = a < b ? b : a;
    return least == most || (most != LAW_HERTZ && least != LAW_LINEAR_RESTITUTION);
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
