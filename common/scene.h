/* The scene: everything a run is told, as plain data. sim reads what concerns particles and recording, wallctl what
 * concerns walls and stages, the analyzer what concerns the evaluation. No physics here. */
#ifndef SHAKEDOWN_COMMON_SCENE_H
#define SHAKEDOWN_COMMON_SCENE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "common/config_table.h"
#include "common/status.h"

enum { SCENE_STAGES_MAX = 1024, SCENE_AXES = 3, SCENE_WALLS_MAX = 6 };

enum axis { AXIS_X, AXIS_Y, AXIS_Z };

/* Normal laws of contacts: X(name, NAME). Scenes may have those of higher rank beside those of lower. */
#define CONTACT_LAWS(X)                                                                                                \
    X(linear, LINEAR)                                                                                                  \
    X(linear_restitution, LINEAR_RESTITUTION)                                                                          \
    X(hysteretic, HYSTERETIC)                                                                                          \
    X(elastoplastic, ELASTOPLASTIC)                                                                                    \
    X(hertz, HERTZ)
enum contact_law {
#define CONTACT_LAW_ENUM(name, NAME) LAW_##NAME,
    CONTACT_LAWS(CONTACT_LAW_ENUM)
#undef CONTACT_LAW_ENUM
        LAW_COUNT
};

/* Whether the normal dashpot may draw a contact together as it opens; which normal force limits friction: with the
 * dashpot's part or without. */
enum dashpot_pull { DASHPOT_PULL_ALLOWED, DASHPOT_PULL_NONE };
enum friction_limit { FRICTION_LIMIT_TOTAL, FRICTION_LIMIT_ELASTIC };

/* [D] = David et al. 2007, [LH] = Luding & Herrmann 2001 */
struct scene_material {
    int law;           /* enum contact_law */
    double kn_n_per_m; /* linear law: k of [D eq. 1] */
    double k1_n_per_m; /* hysteretic law [LH eq. 1.6] */
    double k2_n_per_m;
    double kc_n_per_m;
    double kp_n_per_m; /* k2 that grows with the largest overlap (Luding 2008): its end, and where that is */
    double phi_f;
    double youngs_modulus_pa; /* Hertz-Mindlin law */
    double poisson_ratio;
    double restitution;
    double gamma_n_kg_per_s; /* gamma_0, normal dissipation */
    int dashpot_pull;        /* enum dashpot_pull */
    int friction_limit;      /* enum friction_limit */
    double mu_s;             /* static and dynamic Coulomb coefficient; both 0: no friction, no rotation */
    double mu_d;             /* negative in the file's default: as mu_s */
    double wall_friction;    /* mu_s and mu_d of walls over those between particles; 0: smooth walls */
    double kt_n_per_m;
    double gamma_t_kg_per_s;
    double mu_rolling; /* rolling and torsion resistance (Luding 2008); both 0 in all stages: none */
    double kr_n_per_m, gamma_r_kg_per_s;
    double mu_torsion;
    double ko_n_per_m, gamma_o_kg_per_s;
    double gamma_b_kg_per_s;  /* background damping of translation */
    double gamma_br_kg_per_s; /* of rotation: torque -gamma_br a^2 omega */
};

enum wall_mode { WALL_FIXED, WALL_STRAIN, WALL_STRESS, WALL_COUPLED };
enum wall_opposite { OPPOSITE_FIXED, OPPOSITE_MIRROR, OPPOSITE_CONSTANT };
enum wall_course { COURSE_SMOOTH, COURSE_RATE, COURSE_COSINE, COURSE_TRIANGLE, COURSE_TABLE };
enum wall_target { TARGET_CONSTANT, TARGET_RAMP, TARGET_COSINE, TARGET_TRIANGLE, TARGET_TABLE };
enum wall_keep { KEEP_VOLUME, KEEP_P, KEEP_Q, KEEP_B, KEEP_PATH };

/* One axis: the wall at its upper end, and what the lower one does. */
struct scene_axis {
    int mode;     /* enum wall_mode */
    int opposite; /* enum wall_opposite */
    /* Strain control: the strain e(t) since the start of the stage, z = z_0 (1 - e). */
    int course;          /* enum wall_course; smooth: [LH eq. 1.1] */
    double strain;       /* at the end; amplitude of cycles */
    double frequency_hz; /* f = omega / 2 pi; a smooth course takes 1/(2f) */
    double rate_per_s;   /* course "rate" */
    double rise_s;       /* in which it rises to that rate */
    double strain_growth;
    /* Stress control, and pressures that are kept. */
    int target;             /* [LH eq. 1.2]: enum wall_target */
    double pressure_pa;     /* constant; start of a ramp; p0 of cycles */
    double pressure_end_pa; /* end of a ramp */
    double ramp_s;
    double amplitude_pa; /* delta sigma: p0 + (amplitude/2) (1 - cos 2 pi t / period) */
    double amplitude_growth_pa;
    double period_s;
    /* Cycles of strain or stress. */
    bool two_way;          /* to both sides of where they start */
    int64_t growth_cycles; /* cycles of one amplitude */
    /* Tables: straight lines between their points. */
    struct config_floats times_s, strains, pressures_pa;
    double mass_kg;
    double damping_kg_per_s;
    double tolerance; /* largest deviation from what the axis bears or keeps; 0: none is asked */
    /* Coupled: what the axis follows the others for. */
    int keep;     /* enum wall_keep */
    double b;     /* KEEP_B: (sigma_yy - sigma_xx)/(sigma_zz - sigma_xx) */
    double dq_dp; /* KEEP_PATH: q - deviator_pa = dq_dp (p - pressure_pa) */
    double deviator_pa;
    struct config_band until_strain, until_stress_pa; /* conditions */
    struct scene_material material; /* of contacts with its walls, NAN: as walls.material (scene_wall_material) */
};

struct scene_limits {
    double overlap_ratio; /* a run stops at overlaps beyond this part of the smaller radius */
};

struct scene_stage {
    char name[CONFIG_STRING_MAX]; /* in a group that is repeated with ".1", ".2" ... of its pass */
    int name_length;              /* without that */
    int line;                     /* in scene.source; 0: it stands for prepare, or the text says nothing of it */
    int64_t repeat, group_length; /* of a group, on its first stage: passes, stages in each; else 0 */
    double dt_s;
    double duration_s; /* its length, or the limit in time when a condition is given */
    bool cut_path;     /* it may end before its paths and cycles do */
    /* Conditions; whichever comes first ends it. Rest is one: both of these, if both are given. */
    double until_energy_ratio;  /* E_kin/E_pot is below this; 0: no condition */
    double until_stress_error;  /* every stress-controlled axis is within this fraction of its target */
    double stress_tolerance_pa; /* or this near it */
    struct config_band until_q_pa, until_q_over_p;
    double until_r_u;                   /* (p_ref - p)/p_ref; 0: no condition */
    double reference_pressure_pa;       /* p_ref */
    int64_t until_cycles;               /* 0: no condition */
    int64_t condition_steps;            /* between looks at them */
    double min_duration_s;              /* they are not looked at before */
    double sample_interval_s;           /* 0: duration/500 */
    double frame_interval_s;            /* 0: frames only at frame_strains and at the end of the stage */
    struct config_floats frame_strains; /* of the strain-controlled axis, increasing */
    struct scene_material material;
    struct scene_material wall_material; /* of contacts with walls, NAN: as the particles (scene_wall_material) */
    struct scene_axis axis[SCENE_AXES];
    struct scene_limits limits;
};

enum radius_distribution { RADIUS_UNIFORM, RADIUS_GAUSSIAN, RADIUS_LOGNORMAL, RADIUS_TABLE };
enum initial_state { INITIAL_LATTICE, INITIAL_RANDOM, INITIAL_CHECKPOINT, INITIAL_FILE };

struct scene_sample {
    int64_t count;
    int radius_distribution; /* enum radius_distribution */
    double radius_min_m;     /* uniform: bounds; gaussian: cut-offs */
    double radius_max_m;
    double radius_mean_m; /* gaussian */
    double radius_sd_m;
    double radius_median_m; /* lognormal */
    double radius_log_sd;
    char size_table[CONFIG_STRING_MAX];                /* table: its path; read into these two: */
    struct config_floats diameters_m, passing_by_mass; /* increasing; from 0 to 1 */
    double density_kg_per_m3;
    int initial;                               /* enum initial_state */
    char checkpoint[CONFIG_STRING_MAX];        /* its path, relative to the scene file */
    char file[CONFIG_STRING_MAX];              /* of the grains; absolute once the scene is loaded */
    char file_hash[CONFIG_STRING_MAX];         /* of its content */
    struct config_floats box_min_m, box_max_m; /* file: [dimension], or none */
    double overlap_ratio;                      /* file: of the smaller radius */
    double gap_ratio;                          /* lattice: spacing is 2 r_max (1 + gap_ratio) */
    double solid_fraction;                     /* random: of the starting box */
    double aspect_ratio;                       /* starting box: height z over width x (and y = x) */
    double speed_m_per_s;                      /* starting velocities, uniform in [-speed, speed] per component */
    /* Follow from the above: */
    double mean_radius_m, mean_cube_m3; /* of radii, and of their cubes */
};

enum coupling_scheme {
    SCHEME_HOLD,
    SCHEME_JACOBIAN,
    SCHEME_PIPELINED,
    SCHEME_ADAPTIVE,
    SCHEME_IMPEDANCE,
    SCHEME_COMPENSATED
};

struct scene_coupling {
    int scheme;             /* enum coupling_scheme */
    int64_t interval_steps; /* n; adaptive: the longest */
    int64_t ahead_steps;    /* compensated: a command is asked for so long before it is wanted */
    double tolerance;       /* adaptive: energy mismatch over work at the walls, per interval */
    bool busy_poll;         /* sim and wallctl look for messages without sleeping */
    double timeout_s;       /* without an answer from wallctl or the recorder, sim gives up */
};

enum precision { PRECISION_DOUBLE, PRECISION_MIXED };

enum record_walls { RECORD_WALLS_SAMPLED, RECORD_WALLS_FULL };

struct scene_record {
    int walls;            /* enum record_walls: in every sample, or each exchange */
    bool event_log;       /* also keep the raw messages as run.lcm */
    bool contact_history; /* frames hold what contacts remember */
};

struct scene_neighbor {
    double skin_ratio;      /* skin of the Verlet list over the mean radius; 0: tuned */
    int64_t renumber_steps; /* steps between renumberings of the particles; 0: never, -1: by their number */
};

enum strain_measure { STRAIN_ENGINEERING, STRAIN_LOGARITHMIC };

struct scene_analysis {
    char stage[CONFIG_STRING_MAX]; /* name of the stage to evaluate; "" = the last */
    int strain;                    /* enum strain_measure: of reported strains, windows and plots */
    double modulus_strain;         /* window of the initial slopes: strain 0 to this */
    double residual_strain;        /* window of the residual stress: the last part of the strain */
    double dilatancy_min_strain;   /* window of the dilatancy slope */
    double negligible_rate;        /* of cycles: gain per cycle over the strain amplitude without practical meaning */
    double dilatancy_max_strain;   /* 0: to the end of the test */
};

struct scene {
    char name[CONFIG_STRING_MAX];
    int64_t dimension; /* 2 or 3 */
    int64_t seed;
    int precision;                         /* enum precision: of contacts */
    struct config_floats gravity_m_per_s2; /* x y z; empty: none */
    struct scene_sample sample;
    struct scene_material material;      /* of every stage that does not say otherwise */
    struct scene_material wall_material; /* the same of contacts with walls */
    struct scene_axis axis[SCENE_AXES];
    struct scene_coupling coupling;
    struct scene_record record;
    struct scene_neighbor neighbor;
    struct scene_limits limits; /* as material and axis: of every stage that does not say otherwise */
    struct scene_analysis analysis;
    int64_t threads;              /* of sim; 0: by the number of particles */
    double checkpoint_interval_s; /* wall-clock */
    int64_t n_stages;
    struct scene_stage *stage; /* [n_stages], owned */
    char *text;                /* the file as read, owned */
    char *source;              /* its name in messages, owned */
    char *prepared;            /* the stages that prepare = { ... } stands for, owned; NULL: none */
};

/* Releases what `scene` owns; harmless for one that is all zero, or was released. */
void scene_free(struct scene *scene);

/* Writes the effective configuration: what was set, and defaults where they mean something in this scene; of stages
 * what they do not have from the scene, or by default. scene_parse reads it back to the same scene. */
void scene_print(FILE *out, const struct scene *scene);

/* The same with every key of the scene and of each stage, whether it means something or not: to look values up. */
void scene_print_every_key(FILE *out, const struct scene *scene);

/* Writes docs/scene-reference.md. */
void scene_print_reference(FILE *out);

/* Whether the axis has a target in time: of its stress, or of p or q if it keeps one of them. */
bool scene_axis_has_target(const struct scene_axis *axis);

/* Period of the cycles that are run along an axis; 0: none are. */
double scene_axis_period_s(const struct scene_axis *axis);

/* Until a table, a ramp or a course of strain of an axis has come to its end [s]; 0: it has none. */
double scene_axis_length_s(const struct scene_axis *axis);

/* The largest strain that the axis comes to, by its course; of cycles that grow: in `duration_s`. 0: no strain control.
 */
double scene_axis_largest_strain(const struct scene_axis *axis, double duration_s);

/* Where a stage stands, for messages: `scene.cfg:12: stage "test"`. */
void scene_stage_place(const struct scene *scene, const struct scene_stage *stage, char *text, size_t size);

/* When a course "rate" comes to its strain, which is not 0 [s]. */
double scene_axis_rate_end_s(const struct scene_axis *axis);

/* Material of contacts with the walls of an axis in a stage: that of the particles, with friction times wall_friction,
 * but for what walls.material and the axis's own say. Elastic constants are those of the wall alone. True if they say
 * anything. */
bool scene_wall_material(const struct scene_stage *stage, enum axis axis, struct scene_material *material);

/* What the scene needs modelled, over all stages. */
bool scene_is_frictional(const struct scene *scene);
bool scene_resists_rolling(const struct scene *scene); /* or torsion */
bool scene_resists_torsion(const struct scene *scene);
bool scene_is_hysteretic(const struct scene *scene);

/* Name of an enum contact_law. */
const char *scene_law_name(int law);

/* Number of walls (4 or 6), and the axis of the k-th pair of walls: 2D has x, z; 3D x, y, z. */
int scene_wall_count(const struct scene *scene);
enum axis scene_pair_axis(const struct scene *scene, int pair);

/* "dense", ... : the index of a stage by name; -1 if there is none. "" is the last. */
int scene_stage_find(const struct scene *scene, const char *name);

/* Time of all stages, limits counted in full. */
double scene_total_time_s(const struct scene *scene);

#endif
