/* The tables of a scene's keys. Internal to common/scene*.c. */
#ifndef SHAKEDOWN_COMMON_SCENE_KEYS_H
#define SHAKEDOWN_COMMON_SCENE_KEYS_H

#include "common/config_table.h"

/* A group of stages in the list: { repeat = N; stages = ( ... ); } */
struct scene_group {
    int64_t repeat;
};

/* prepare = { ... } */
enum { PREPARE_DENSE, PREPARE_LOOSE, PREPARE_SOLID_FRACTION };
struct scene_prepare {
    int to;
    double pressure_pa;
    double solid_fraction;
    double mu_s; /* negative: by `to` */
    double inertial_number;
    double dt_s; /* 0: "auto" */
};

/* What a stage has before its own keys are read, and what follows from those once they are checked. */
struct scene;
struct scene_material;
struct scene_stage;
void scene_stage_start(const struct scene *scene, struct scene_stage *stage);
void scene_stage_complete(struct scene_stage *stage);

/* The law that keys of others refine: linear with a restitution, hysteretic with a k2 that grows. */
void scene_material_refine(struct scene_material *material);

/* STATUS_CONFIG if the material has a key that its law does not take, or lacks one that it needs. */
enum status scene_check_law_keys(const struct scene_material *material, const config_setting_t *at,
                                 const char *where) MUST_USE;
bool scene_law_takes(int law, const char *key);

/* Whether a key at its default means something in a group (config_applies): it says what is computed, evaluated or
 * recorded. Those of other laws, of axes and of walls' materials do not, nor does what is empty by default. */
bool scene_key_applies(const struct key *table, const struct key *key, const void *group);
bool stage_key_applies(const struct key *table, const struct key *key, const void *group); /* of a stage, besides */

/* Whether contacts of law `other` can be computed as such of law `law`: a scene may have both. */
bool scene_law_expresses(int law, int other);

extern const struct key scene_keys[];       /* struct scene */
extern const struct key scene_stage_keys[]; /* struct scene_stage */
extern const struct key scene_group_keys[]; /* struct scene_group */
extern const struct key scene_prepare_keys[];
extern const struct key scene_wall_material_keys[];

#endif
