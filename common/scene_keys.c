#include "common/scene_keys.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/scene.h"

#define OF(type, member) offsetof(struct type, member)

#define CONTACT_LAW_NAME(name, NAME) #name,
static const char *const law_names[] = {CONTACT_LAWS(CONTACT_LAW_NAME) NULL};
static const char *const pull_names[] = {"allowed", "none", NULL};
static const char *const limit_names[] = {"total", "elastic", NULL};
static const char *const mode_names[] = {"fixed", "strain", "stress", "coupled", NULL};
static const char *const opposite_names[] = {"fixed", "mirror", "constant", NULL};
static const char *const course_names[] = {"smooth", "rate", "cosine", "triangle", "table", NULL};
static const char *const target_names[] = {"constant", "ramp", "cosine", "triangle", "table", NULL};
static const char *const keep_names[] = {"volume", "p", "q", "b", "path", NULL};
static const char *const radius_names[] = {"uniform", "gaussian", "lognormal", "table", NULL};
static const char *const initial_names[] = {"lattice", "random", "checkpoint", "file", NULL};
static const char *const scheme_names[] = {"hold",      "jacobian",    "pipelined", "adaptive",
                                           "impedance", "compensated", NULL};
static const char *const prepare_names[] = {"dense", "loose", "solid_fraction", NULL};
static const char *const precision_names[] = {"double", "mixed", NULL};
static const char *const strain_names[] = {"engineering", "logarithmic", NULL};
static const char *const auto_names[] = {"auto", NULL};
static const char *const walls_names[] = {"sampled", "full", NULL};

static const struct key material_keys[] = {
    {"law", KEY_CHOICE, OF(scene_material, law), NULL, 0, 0, "linear", law_names, NULL,
     "contact law: linear spring [D eq. 1], also with the restitution of every pair; linear hysteretic with cohesion "
     "[LH eq. "
     "1.6], also with a k2 that grows with the history (elastoplastic: Luding 2008); Hertz-Mindlin"},
    {"kn_n_per_m", KEY_FLOAT, OF(scene_material, kn_n_per_m), "N/m", 0, INFINITY, "0", NULL, NULL,
     "stiffness k of the linear law"},
    {"k1_n_per_m", KEY_FLOAT, OF(scene_material, k1_n_per_m), "N/m", 0, INFINITY, "0", NULL, NULL,
     "loading stiffness of the hysteretic law"},
    {"k2_n_per_m", KEY_FLOAT, OF(scene_material, k2_n_per_m), "N/m", 0, INFINITY, "0", NULL, NULL,
     "un- and reloading stiffness of the hysteretic law"},
    {"kc_n_per_m", KEY_FLOAT, OF(scene_material, kc_n_per_m), "N/m", 0, INFINITY, "0", NULL, NULL,
     "slope of the adhesion branch of the hysteretic law"},
    {"kp_n_per_m", KEY_FLOAT, OF(scene_material, kp_n_per_m), "N/m", 0, INFINITY, "0", NULL, NULL,
     "elastoplastic: what k2 grows to, from k1, with the largest overlap; law \"hysteretic\" with it is elastoplastic"},
    {"phi_f", KEY_FLOAT, OF(scene_material, phi_f), NULL, 0, 10, "0.05", NULL, NULL,
     "elastoplastic: k2 is kp from the overlap kp/(kp - k1) phi_f 2 a_i a_j/(a_i + a_j) on"},
    {"youngs_modulus_pa", KEY_FLOAT, OF(scene_material, youngs_modulus_pa), "N/m^2", 0, INFINITY, "0", NULL, NULL,
     "Young's modulus E of the particles, of the Hertz-Mindlin law"},
    {"poisson_ratio", KEY_FLOAT, OF(scene_material, poisson_ratio), NULL, 0, 0.5, "0", NULL, NULL,
     "Poisson's ratio of the particles, of the Hertz-Mindlin law"},
    {"restitution", KEY_FLOAT, OF(scene_material, restitution), NULL, 0.001, 1, "1", NULL, NULL,
     "coefficient of restitution e, the same for every pair and at any speed, of the laws linear and hertz; 1: no "
     "dashpot "
     "but gamma_n"},
    {"gamma_n_kg_per_s", KEY_FLOAT, OF(scene_material, gamma_n_kg_per_s), "kg/s", 0, INFINITY, "0", NULL, NULL,
     "normal dissipation gamma_0"},
    {"dashpot_pull", KEY_CHOICE, OF(scene_material, dashpot_pull), NULL, 0, 0, "allowed", pull_names, NULL,
     "whether the normal dashpot may pull where a contact opens: allowed, as in [LH], [D]; none: the normal force is "
     "at "
     "least 0, with cohesion -kc delta. An asked-for restitution is kept either way (docs/theory.md)"},
    {"friction_limit", KEY_CHOICE, OF(scene_material, friction_limit), NULL, 0, 0, "total", limit_names, NULL,
     "the normal force that limits friction, rolling and torsion: total, with the dashpot's part, as in [D]; elastic: "
     "without it, so that damped impacts slide by mu times their normal impulse"},
    {"mu_s", KEY_FLOAT, OF(scene_material, mu_s), NULL, 0, 100, "0", NULL, NULL,
     "static friction coefficient; 0 in all stages: no friction and no rotation are modelled"},
    {"mu_d", KEY_FLOAT, OF(scene_material, mu_d), NULL, -1, 100, "-1", NULL, NULL,
     "dynamic friction coefficient, at most mu_s; -1: equal to mu_s"},
    {"wall_friction", KEY_FLOAT, OF(scene_material, wall_friction), NULL, 0, 100, "1", NULL, NULL,
     "mu_s and mu_d of particles on walls over those between particles; 0: smooth walls"},
    {"kt_n_per_m", KEY_FLOAT, OF(scene_material, kt_n_per_m), "N/m", 0, INFINITY, "0", NULL, NULL,
     "tangential stiffness"},
    {"gamma_t_kg_per_s", KEY_FLOAT, OF(scene_material, gamma_t_kg_per_s), "kg/s", 0, INFINITY, "0", NULL, NULL,
     "tangential dissipation"},
    {"mu_rolling", KEY_FLOAT, OF(scene_material, mu_rolling), NULL, 0, 100, "0", NULL, NULL,
     "rolling resistance: the torque of a contact is at most mu_rolling a' f, a' = a_i a_j/(a_i + a_j) or, "
     "on walls, a_i, f the normal force as of friction; 0: none"},
    {"kr_n_per_m", KEY_FLOAT, OF(scene_material, kr_n_per_m), "N/m", 0, INFINITY, "0", NULL, NULL,
     "stiffness of rolling resistance"},
    {"gamma_r_kg_per_s", KEY_FLOAT, OF(scene_material, gamma_r_kg_per_s), "kg/s", 0, INFINITY, "0", NULL, NULL,
     "dissipation of rolling resistance"},
    {"mu_torsion", KEY_FLOAT, OF(scene_material, mu_torsion), NULL, 0, 100, "0", NULL, NULL,
     "3D: the same of torsion, about the normal; 0: none"},
    {"ko_n_per_m", KEY_FLOAT, OF(scene_material, ko_n_per_m), "N/m", 0, INFINITY, "0", NULL, NULL,
     "stiffness of torsion resistance"},
    {"gamma_o_kg_per_s", KEY_FLOAT, OF(scene_material, gamma_o_kg_per_s), "kg/s", 0, INFINITY, "0", NULL, NULL,
     "dissipation of torsion resistance"},
    {"gamma_b_kg_per_s", KEY_FLOAT, OF(scene_material, gamma_b_kg_per_s), "kg/s", 0, INFINITY, "0", NULL, NULL,
     "background damping: force -gamma_b v on every particle"},
    {"gamma_br_kg_per_s", KEY_FLOAT, OF(scene_material, gamma_br_kg_per_s), "kg/s", 0, INFINITY, "0", NULL, NULL,
     "background damping of rotation: torque -gamma_br a^2 omega (a^2 is our reading of [D])"},
    {0}};

/* Of contacts with walls. */
static const char *const particles_names[] = {"particles", NULL};
#define OF_WALL(member, unit, least, most, doc)                                                                        \
    {                                                                                                                  \
#member, KEY_FLOAT, OF(scene_material, member), unit, least, most, "particles", particles_names, NULL, doc     \
    }
const struct key scene_wall_material_keys[] = {
    OF_WALL(kn_n_per_m, "N/m", 0, INFINITY,
            "stiffness of contacts with the wall; \"particles\": that of the particles"),
    OF_WALL(k1_n_per_m, "N/m", 0, INFINITY, "the same, hysteretic law"),
    OF_WALL(k2_n_per_m, "N/m", 0, INFINITY, "the same"),
    OF_WALL(kc_n_per_m, "N/m", 0, INFINITY, "the same"),
    OF_WALL(kp_n_per_m, "N/m", 0, INFINITY, "the same, elastoplastic law"),
    OF_WALL(phi_f, NULL, 0, 10, "the same"),
    OF_WALL(youngs_modulus_pa, "N/m^2", 0, INFINITY, "Young's modulus of the wall itself, Hertz-Mindlin law"),
    OF_WALL(poisson_ratio, NULL, 0, 0.5, "Poisson's ratio of the wall itself"),
    OF_WALL(restitution, NULL, 0.001, 1, "coefficient of restitution of particles on the wall, laws linear and hertz"),
    OF_WALL(gamma_n_kg_per_s, "kg/s", 0, INFINITY, "normal dissipation of contacts with the wall"),
    OF_WALL(mu_s, NULL, 0, 100,
            "static friction coefficient of particles on the wall; \"particles\": theirs times material.wall_friction"),
    OF_WALL(mu_d, NULL, 0, 100, "dynamic one, at most mu_s; where only mu_s is given, equal to it"),
    OF_WALL(kt_n_per_m, "N/m", 0, INFINITY, "tangential stiffness of contacts with the wall"),
    OF_WALL(mu_rolling, NULL, 0, 100, "rolling resistance of particles on the wall"),
    OF_WALL(kr_n_per_m, "N/m", 0, INFINITY, "stiffness of that"),
    OF_WALL(gamma_r_kg_per_s, "kg/s", 0, INFINITY, "dissipation of that"),
    OF_WALL(mu_torsion, NULL, 0, 100, "torsion resistance of particles on the wall, 3D"),
    OF_WALL(ko_n_per_m, "N/m", 0, INFINITY, "stiffness of that"),
    OF_WALL(gamma_o_kg_per_s, "kg/s", 0, INFINITY, "dissipation of that"),
    OF_WALL(gamma_t_kg_per_s, "kg/s", 0, INFINITY, "tangential dissipation of contacts with the wall"),
    {0}};

static bool is_one_of(const char *const *names, const char *name)
{
    while (*names && strcmp(*names, name) != 0)
        names++;
    return *names != NULL;
}

/* Keys that only some laws take; of these, `needed` ones must be above 0. */
#define LAW(name) (1u << LAW_##name)
static const struct law_key {
    const char *name;
    unsigned laws;
    bool needed;
} law_keys[] = {
    {"kn_n_per_m", LAW(LINEAR) | LAW(LINEAR_RESTITUTION), true},
    {"k1_n_per_m", LAW(HYSTERETIC) | LAW(ELASTOPLASTIC), true},
    {"k2_n_per_m", LAW(HYSTERETIC), true},
    {"kc_n_per_m", LAW(HYSTERETIC) | LAW(ELASTOPLASTIC), false},
    {"kp_n_per_m", LAW(ELASTOPLASTIC), true},
    {"phi_f", LAW(ELASTOPLASTIC), true},
    {"youngs_modulus_pa", LAW(HERTZ), true},
    {"poisson_ratio", LAW(HERTZ), false},
    {"restitution", LAW(LINEAR_RESTITUTION) | LAW(HERTZ), false},
    {"gamma_n_kg_per_s", ~(LAW(LINEAR_RESTITUTION) | LAW(HERTZ)), false},
    {"kt_n_per_m", ~LAW(HERTZ), false},
    {"gamma_t_kg_per_s", ~LAW(HERTZ), false},
};

/* Laws that are others with constants of their own: linear is hysteretic with k1 = k2, or has a restitution of 1;
 * hysteretic is elastoplastic with a k2 that does not grow. */
static const unsigned law_expresses[LAW_COUNT] = {
    [LAW_LINEAR_RESTITUTION] = LAW(LINEAR),
    [LAW_HYSTERETIC] = LAW(LINEAR),
    [LAW_ELASTOPLASTIC] = LAW(LINEAR) | LAW(HYSTERETIC),
};

bool scene_law_expresses(int law, int other)
{
    return law_expresses[law] >> other & 1;
}

bool scene_law_takes(int law, const char *key)
{
    for (size_t k = 0; k < sizeof law_keys / sizeof law_keys[0]; k++)
        if (strcmp(law_keys[k].name, key) == 0)
            return law_keys[k].laws >> law & 1;
    return true;
}

/* The laws of a set, for a message. */
static void laws_text(unsigned laws, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (int law = 0; law < LAW_COUNT && used < size; law++)
        if (laws >> law & 1)
            used += (size_t)snprintf(text + used, size - used, "%s\"%s\"", used ? ", " : "", law_names[law]);
}

enum status scene_check_law_keys(const struct scene_material *material, const config_setting_t *at, const char *where)
{
    char owners[128];
    for (size_t k = 0; k < sizeof law_keys / sizeof law_keys[0]; k++) {
        const struct law_key *rule = &law_keys[k];
        const struct key *key = material_keys;
        while (strcmp(key->name, rule->name) != 0)
            key++;
        const double value = *(const double *)((const char *)material + key->offset);
        const bool takes = rule->laws >> material->law & 1;
        if (takes && rule->needed && !(value > 0))
            return config_fail(at, where, "law \"%s\" needs %s above 0", law_names[material->law], key->name);
        if (takes || value == strtod(key->preset, NULL))
            continue;
        laws_text(rule->laws, owners, sizeof owners);
        return config_fail(at, where, "law \"%s\" does not take %s, which belongs to %s", law_names[material->law],
                           key->name, owners);
    }
    return STATUS_OK;
}

static const struct key axis_keys[] = {
    {"mode", KEY_CHOICE, OF(scene_axis, mode), NULL, 0, 0, "fixed", mode_names, NULL,
     "what moves the upper wall: nothing, a course of strain [LH eq. 1.1], a pressure [LH eq. 1.2], or what the other "
     "axes do, so that something is kept"},
    {"opposite", KEY_CHOICE, OF(scene_axis, opposite), NULL, 0, 0, "mirror", opposite_names, NULL,
     "the lower wall: fixed; mirror image of the upper (both driven by the mean force); or stress controlled at the "
     "constant pressure_pa"},
    {"course", KEY_CHOICE, OF(scene_axis, course), NULL, 0, 0, "smooth", course_names, NULL,
     "strain control, e(t) from the start of the stage, z = z_0 (1 - e): smooth: strain/2 (1 - cos 2 pi f t) for half "
     "a "
     "period, then at rest; rate: at rate_per_s until strain; cosine, triangle: cycles; table: strains at times_s"},
    {"strain", KEY_FLOAT, OF(scene_axis, strain), NULL, -10, 0.95, "0", NULL, NULL,
     "strain control: strain at the end, z_f = z_0 (1 - strain); rate: 0 is no end; cycles: from 0 to strain and back, "
     "with two_way between strain and -strain"},
    {"frequency_hz", KEY_FLOAT, OF(scene_axis, frequency_hz), "1/s", 0, INFINITY, "0", NULL, NULL,
     "strain control: f; a smooth course takes 1/(2f), a cycle 1/f"},
    {"rate_per_s", KEY_FLOAT, OF(scene_axis, rate_per_s), "1/s", -INFINITY, INFINITY, "0", NULL, NULL,
     "course \"rate\": the strain rate, negative in extension"},
    {"rise_s", KEY_FLOAT, OF(scene_axis, rise_s), "s", 0, INFINITY, "0", NULL, NULL,
     "course \"rate\": time in which it rises from 0 to rate_per_s, so that no wave starts from the wall"},
    {"strain_growth", KEY_FLOAT, OF(scene_axis, strain_growth), NULL, -1, 1, "0", NULL, NULL,
     "strain cycles: what the amplitude grows by every growth_cycles"},
    {"target", KEY_CHOICE, OF(scene_axis, target), NULL, 0, 0, "constant", target_names, NULL,
     "stress control: constant pressure_pa; ramp to pressure_end_pa in ramp_s; cycles pressure_pa + amplitude_pa/2 "
     "(1 - cos(2 pi t/period_s)), or triangles; table: pressures_pa at times_s"},
    {"pressure_pa", KEY_FLOAT, OF(scene_axis, pressure_pa), "N/m^2", -INFINITY, INFINITY, "0", NULL, NULL,
     "stress control: the target, compression positive (2D: force per side length, depth 1 m); keep = \"p\" or \"q\": "
     "p or q, "
     "with any target; keep = \"path\": p where the path starts"},
    {"pressure_end_pa", KEY_FLOAT, OF(scene_axis, pressure_end_pa), "N/m^2", -INFINITY, INFINITY, "0", NULL, NULL,
     "end of a ramp"},
    {"ramp_s", KEY_FLOAT, OF(scene_axis, ramp_s), "s", 0, INFINITY, "0", NULL, NULL, "length of a ramp"},
    {"amplitude_pa", KEY_FLOAT, OF(scene_axis, amplitude_pa), "N/m^2", -INFINITY, INFINITY, "0", NULL, NULL,
     "cycles: peak to peak, delta sigma; with two_way half of it to either side: pressure_pa + amplitude_pa/2 "
     "sin(2 pi t/period_s)"},
    {"amplitude_growth_pa", KEY_FLOAT, OF(scene_axis, amplitude_growth_pa), "N/m^2", -INFINITY, INFINITY, "0", NULL,
     NULL, "stress cycles: what the amplitude grows by every growth_cycles"},
    {"period_s", KEY_FLOAT, OF(scene_axis, period_s), "s", 0, INFINITY, "0", NULL, NULL, "stress cycles: period t0"},
    {"two_way", KEY_BOOL, OF(scene_axis, two_way), NULL, 0, 0, "false", NULL, NULL,
     "cycles of strain or stress: to both sides of where they start, beginning with a quarter towards compression"},
    {"growth_cycles", KEY_INT, OF(scene_axis, growth_cycles), "cycles", 1, 1000000, "1", NULL, NULL,
     "amplitude series: cycles of one amplitude"},
    {"times_s", KEY_FLOATS, OF(scene_axis, times_s), "s", 0, INFINITY, "", NULL, NULL,
     "tables: times from the start of the stage, the first one 0, increasing; straight lines between, the last value "
     "after"},
    {"strains", KEY_FLOATS, OF(scene_axis, strains), NULL, -10, 0.95, "", NULL, NULL,
     "course \"table\": strain at each time, the first one 0"},
    {"pressures_pa", KEY_FLOATS, OF(scene_axis, pressures_pa), "N/m^2", -INFINITY, INFINITY, "", NULL, NULL,
     "target \"table\": pressure at each time"},
    {"mass_kg", KEY_FLOAT, OF(scene_axis, mass_kg), "kg", 0, INFINITY, "0", NULL, NULL,
     "stress control: mass m_x of the wall"},
    {"damping_kg_per_s", KEY_FLOAT, OF(scene_axis, damping_kg_per_s), "kg/s", 0, INFINITY, "0", NULL, NULL,
     "stress control: damping gamma_x of the wall; mass and damping must not both be 0"},
    {"tolerance", KEY_FLOAT, OF(scene_axis, tolerance), NULL, 0, 1, "0", NULL, NULL,
     "mode \"stress\" or \"coupled\": largest deviation from what the axis bears or keeps, measured as kept.* "
     "(docs/analysis.md), that the test is to have; beyond it the verdict is doubtful; 0: none is asked"},
    {"keep", KEY_CHOICE, OF(scene_axis, keep), NULL, 0, 0, "volume", keep_names, NULL,
     "mode \"coupled\": what the axis is moved for: the volume of the start of the stage; the mean stress p; "
     "q (in z); b (in y); or a straight path in p and q"},
    {"b", KEY_FLOAT, OF(scene_axis, b), NULL, 0, 1, "0", NULL, NULL,
     "keep = \"b\": (sigma_yy - sigma_xx)/(sigma_zz - sigma_xx)"},
    {"dq_dp", KEY_FLOAT, OF(scene_axis, dq_dp), NULL, -INFINITY, INFINITY, "3", NULL, NULL,
     "keep = \"path\": slope of q - deviator_pa = dq_dp (p - pressure_pa); q = sigma_zz - the lateral mean"},
    {"deviator_pa", KEY_FLOAT, OF(scene_axis, deviator_pa), "N/m^2", -INFINITY, INFINITY, "0", NULL, NULL,
     "keep = \"path\": q where the path starts"},
    {"until_strain", KEY_BAND, OF(scene_axis, until_strain), NULL, -10, 0.95, "", NULL, NULL,
     "condition: the stage ends when the strain of this axis since its start is beyond this (a negative number: "
     "below it), or outside [low, high]"},
    {"until_stress_pa", KEY_BAND, OF(scene_axis, until_stress_pa), "N/m^2", -INFINITY, INFINITY, "", NULL, NULL,
     "condition: the same for the stress of this axis, the mean of both walls"},
    {"material", KEY_GROUP, OF(scene_axis, material), NULL, 0, 0, NULL, NULL, scene_wall_material_keys, ""},
    {0}};

#define WALLS_OF(type)                                                                                                 \
    {                                                                                                                  \
        {"material", KEY_GROUP, OF(type, wall_material), NULL, 0, 0, NULL, NULL, scene_wall_material_keys, ""},        \
            {"x", KEY_GROUP, OF(type, axis[AXIS_X]), NULL, 0, 0, NULL, NULL, axis_keys, "lateral walls"},              \
            {"y", KEY_GROUP, OF(type, axis[AXIS_Y]), NULL, 0, 0, NULL, NULL, axis_keys, "lateral walls, 3D only"},     \
            {"z", KEY_GROUP, OF(type, axis[AXIS_Z]), NULL, 0, 0, NULL, NULL, axis_keys, "axial walls"},                \
        {                                                                                                              \
            0                                                                                                          \
        }                                                                                                              \
    }
static const struct key scene_walls_keys[] = WALLS_OF(scene);
static const struct key stage_walls_keys[] = WALLS_OF(scene_stage);

static const struct key limits_keys[] = {{"overlap_ratio", KEY_FLOAT, OF(scene_limits, overlap_ratio), NULL, 0, 2,
                                          "0.3", NULL, NULL,
                                          "a run stops when it sees an overlap beyond this part of the smaller radius; "
                                          "from 5 % on there is a note. A violent "
                                          "preparation may need more in its own stage"},
                                         {0}};

const struct key scene_stage_keys[] = {
    {"name", KEY_STRING, OF(scene_stage, name), NULL, 0, 0, NULL, NULL, NULL,
     "name of the stage, its own: its checkpoint is checkpoint-NAME.h5"},
    {"dt_s", KEY_FLOAT, OF(scene_stage, dt_s), "s", 1e-18, 1e6, "auto", auto_names, NULL,
     "time step; \"auto\": a twentieth of the contact time pi sqrt(m/(2 k)) of two particles of the mean mass, at most "
     "a "
     "seventh of that of the smallest ones and a third of what their dashpots bear (docs/verdict.md); k the stiffest "
     "of "
     "the material, of Hertz-Mindlin contacts that under four times the mean force. What contacts do not bear is "
     "refused"},
    {"duration_s", KEY_FLOAT, OF(scene_stage, duration_s), "s", 0, INFINITY, "0", NULL, NULL,
     "length of the stage; with a condition, the limit in time; 0: as long as until_cycles, or as its courses, ramps "
     "and "
     "tables take"},
    {"cut_path", KEY_BOOL, OF(scene_stage, cut_path), NULL, 0, 0, "false", NULL, NULL,
     "duration_s may end the stage before its courses, ramps, tables and cycles do; otherwise that is refused"},
    {"until_energy_ratio", KEY_FLOAT, OF(scene_stage, until_energy_ratio), NULL, 0, INFINITY, "0", NULL, NULL,
     "condition (rest): the stage ends when E_kin/E_pot is below this; 0: none. Of several conditions the first that "
     "is "
     "met ends the stage; the two of rest count as one, met when both are"},
    {"until_stress_error", KEY_FLOAT, OF(scene_stage, until_stress_error), NULL, 0, INFINITY, "0", NULL, NULL,
     "condition (rest): the stage ends when each stress-controlled axis is within this fraction of its target; 0: "
     "none"},
    {"stress_tolerance_pa", KEY_FLOAT, OF(scene_stage, stress_tolerance_pa), "N/m^2", 0, INFINITY, "0", NULL, NULL,
     "until_stress_error: an axis this near its target is near enough, however small the target"},
    {"until_q_pa", KEY_BAND, OF(scene_stage, until_q_pa), "N/m^2", -INFINITY, INFINITY, "", NULL, NULL,
     "condition: the stage ends when q = sigma_zz - the lateral mean is beyond this, or outside [low, high]"},
    {"until_q_over_p", KEY_BAND, OF(scene_stage, until_q_over_p), NULL, -3, 3, "", NULL, NULL,
     "condition: the same for q/p, p the mean of the stresses"},
    {"until_r_u", KEY_FLOAT, OF(scene_stage, until_r_u), NULL, 0, 2, "0", NULL, NULL,
     "condition: the stage ends when r_u = 1 - p/reference_pressure_pa is above this; 0: none"},
    {"reference_pressure_pa", KEY_FLOAT, OF(scene_stage, reference_pressure_pa), "N/m^2", 0, INFINITY, "0", NULL, NULL,
     "of r_u: p before a test at constant volume"},
    {"until_cycles", KEY_INT, OF(scene_stage, until_cycles), "cycles", 0, 100000000, "0", NULL, NULL,
     "condition: the stage ends after so many cycles; 0: none"},
    {"condition_steps", KEY_INT, OF(scene_stage, condition_steps), "steps", 1, 1000000, "256", NULL, NULL,
     "conditions are looked at every so many steps of the stage, whatever is recorded and however long its limit"},
    {"min_duration_s", KEY_FLOAT, OF(scene_stage, min_duration_s), "s", 0, INFINITY, "0", NULL, NULL,
     "conditions are not looked at before (but for until_cycles)"},
    {"sample_interval_s", KEY_FLOAT, OF(scene_stage, sample_interval_s), "s", 0, INFINITY, "0", NULL, NULL,
     "time between samples; 0: duration_s/500"},
    {"frame_interval_s", KEY_FLOAT, OF(scene_stage, frame_interval_s), "s", 0, INFINITY, "0", NULL, NULL,
     "time between frames of particles and contacts; 0: only at frame_strains and at the end of the stage"},
    {"frame_strains", KEY_FLOATS, OF(scene_stage, frame_strains), NULL, -10, 0.95, "", NULL, NULL,
     "strains of the strain-controlled axis at which frames are recorded, in the order they are passed"},
    {"material", KEY_GROUP, OF(scene_stage, material), NULL, 0, 0, NULL, NULL, material_keys, ""},
    {"walls", KEY_GROUP, 0, NULL, 0, 0, NULL, NULL, stage_walls_keys, ""},
    {"limits", KEY_GROUP, OF(scene_stage, limits), NULL, 0, 0, NULL, NULL, limits_keys, ""},
    {0}};

static const struct key sample_keys[] = {
    {"count", KEY_INT, OF(scene_sample, count), NULL, 1, 10000000, "0", NULL, NULL,
     "number of particles N; initial = \"file\": may be missing, or is that of the file"},
    {"radius_distribution", KEY_CHOICE, OF(scene_sample, radius_distribution), NULL, 0, 0, "uniform", radius_names,
     NULL, "another name of size_distribution; the later of the two counts"},
    {"size_distribution", KEY_CHOICE, OF(scene_sample, radius_distribution), NULL, 0, 0, "uniform", radius_names, NULL,
     "radii by number: uniform in [radius_min_m, radius_max_m]; gaussian or lognormal, cut to that interval; table: a "
     "grading curve, passing by mass against diameter"},
    {"radius_min_m", KEY_FLOAT, OF(scene_sample, radius_min_m), "m", 1e-9, 1e3, "0", NULL, NULL,
     "smallest radius; initial = \"file\": that of the file"},
    {"radius_max_m", KEY_FLOAT, OF(scene_sample, radius_max_m), "m", 1e-9, 1e3, "0", NULL, NULL,
     "largest radius, likewise"},
    {"radius_mean_m", KEY_FLOAT, OF(scene_sample, radius_mean_m), "m", 0, 1e3, "0", NULL, NULL, "gaussian: mean"},
    {"radius_sd_m", KEY_FLOAT, OF(scene_sample, radius_sd_m), "m", 0, 1e3, "0", NULL, NULL,
     "gaussian: standard deviation before cutting"},
    {"radius_median_m", KEY_FLOAT, OF(scene_sample, radius_median_m), "m", 0, 1e3, "0", NULL, NULL,
     "lognormal: median before cutting"},
    {"radius_log_sd", KEY_FLOAT, OF(scene_sample, radius_log_sd), NULL, 0, 5, "0", NULL, NULL,
     "lognormal: standard deviation of ln(radius) before cutting"},
    {"diameters_m", KEY_FLOATS, OF(scene_sample, diameters_m), "m", 2e-9, 2e3, "", NULL, NULL,
     "table: diameters of the sieves, increasing; straight lines in the logarithm of the diameter between"},
    {"passing_by_mass", KEY_FLOATS, OF(scene_sample, passing_by_mass), NULL, 0, 1, "", NULL, NULL,
     "table: part of the mass that is finer than each diameter, from 0 to 1. The sample has this curve at every "
     "diameter within one particle, whatever the seed"},
    {"size_table", KEY_STRING, OF(scene_sample, size_table), NULL, 0, 0, "", NULL, NULL,
     "table: path of a table with a line diameter,passing, instead of the two lists; relative to the scene file, "
     "recorded as the lists"},
    {"density_kg_per_m3", KEY_FLOAT, OF(scene_sample, density_kg_per_m3), "kg/m^3", 1e-6, 1e6, NULL, NULL, NULL,
     "density; the mass is a sphere's in 2D too [LH, D]"},
    {"initial", KEY_CHOICE, OF(scene_sample, initial), NULL, 0, 0, "lattice", initial_names, NULL,
     "lattice without overlap; random without overlap; the final state of another run; or grains with positions, "
     "radii, velocities and spins of their own"},
    {"checkpoint", KEY_STRING, OF(scene_sample, checkpoint), NULL, 0, 0, "", NULL, NULL,
     "initial = \"checkpoint\": path of checkpoint.h5, relative to the scene file"},
    {"file", KEY_STRING, OF(scene_sample, file), NULL, 0, 0, "", NULL, NULL,
     "initial = \"file\": path of a table of grains, relative to the scene file: a line x,y,z,radius, which may go on "
     "with ,vx,vy,vz and ,omega_x,omega_y,omega_z and ,density, then one line per grain; m, m/s, rad/s, kg/m^3"},
    {"file_hash", KEY_STRING, OF(scene_sample, file_hash), NULL, 0, 0, "", NULL, NULL,
     "initial = \"file\": FNV-1a of its bytes, 16 hexadecimal digits; recorded. If given, the file must have it"},
    {"box_min_m", KEY_FLOATS, OF(scene_sample, box_min_m), "m", -1e9, 1e9, "", NULL, NULL,
     "initial = \"file\": lower walls [x, y, z], in 2D [x, z]; empty: where the outermost grains touch"},
    {"box_max_m", KEY_FLOATS, OF(scene_sample, box_max_m), "m", -1e9, 1e9, "", NULL, NULL,
     "initial = \"file\": upper walls, likewise"},
    {"overlap_ratio", KEY_FLOAT, OF(scene_sample, overlap_ratio), NULL, 0, 0.5, "1e-9", NULL, NULL,
     "initial = \"file\": overlaps of grains up to this part of the smaller radius, and of a grain and a wall, are "
     "taken"},
    {"gap_ratio", KEY_FLOAT, OF(scene_sample, gap_ratio), NULL, 0, 100, "0.01", NULL, NULL,
     "lattice: its spacing is 2 radius_max_m (1 + gap_ratio)"},
    {"solid_fraction", KEY_FLOAT, OF(scene_sample, solid_fraction), NULL, 1e-6, 0.6, "0.3", NULL, NULL,
     "random: solid fraction of the starting box"},
    {"aspect_ratio", KEY_FLOAT, OF(scene_sample, aspect_ratio), NULL, 1e-3, 1e3, "1", NULL, NULL,
     "starting box: height (z) over width (x; y = x)"},
    {"speed_m_per_s", KEY_FLOAT, OF(scene_sample, speed_m_per_s), "m/s", 0, 1e3, "0", NULL, NULL,
     "starting velocities: each component uniform in [-speed, speed]"},
    {0}};

static const struct key coupling_keys[] = {
    {"scheme", KEY_CHOICE, OF(scene_coupling, scheme), NULL, 0, 0, "hold", scheme_names, NULL,
     "how wallctl answers forces between exchanges: docs/coupling.md; all are the exact loop at an interval of 1 "
     "(pipelined: with a delay of one); impedance: the inner loop in the drive, sim closes it"},
    {"interval_steps", KEY_INT, OF(scene_coupling, interval_steps), "steps", 1, 1000000, "1", NULL, NULL,
     "exchange interval n; 1 is exact; adaptive: the longest"},
    {"ahead_steps", KEY_INT, OF(scene_coupling, ahead_steps), "steps", 0, 500000, "0", NULL, NULL,
     "compensated: the next command is asked for so many steps before it is wanted, at most half an interval, and "
     "comes while sim goes on; 0: sim waits"},
    {"tolerance", KEY_FLOAT, OF(scene_coupling, tolerance), NULL, 1e-9, 1, "1e-3", NULL, NULL,
     "adaptive: energy mismatch at the walls over their work, wanted in each interval"},
    {"busy_poll", KEY_BOOL, OF(scene_coupling, busy_poll), NULL, 0, 0, "false", NULL, NULL,
     "sim and wallctl wait for each other without ever sleeping; false: without sleeping where waits are short and "
     "nobody "
     "else wants the core"},
    {"timeout_s", KEY_FLOAT, OF(scene_coupling, timeout_s), "s", 0.1, 86400, "180", NULL, NULL,
     "sim gives up after this long without an answer from wallctl or the recorder"},
    {0}};

static const struct key record_keys[] = {
    {"walls", KEY_CHOICE, OF(scene_record, walls), NULL, 0, 0, "sampled", walls_names, NULL,
     "wall states: with every sample, or each exchange"},
    {"event_log", KEY_BOOL, OF(scene_record, event_log), NULL, 0, 0, "false", NULL, NULL,
     "keep the raw messages as run.lcm, for lcm-logplayer and replays"},
    {"contact_history", KEY_BOOL, OF(scene_record, contact_history), NULL, 0, 0, "true", NULL, NULL,
     "frames hold what contacts remember (springs, largest overlaps; "
     "docs/file-format.md): 8 to 56 bytes per contact beside the 56 to 73 of the rest"},
    {0}};

static const struct key neighbor_keys[] = {
    {"skin_ratio", KEY_FLOAT, OF(scene_neighbor, skin_ratio), NULL, 0, 10, "0", NULL, NULL,
     "skin of the Verlet list over the mean radius: speed, and the order in which forces are summed up; 0: tuned while "
     "running"},
    {"renumber_steps", KEY_INT, OF(scene_neighbor, renumber_steps), NULL, -1, 9e15, "-1", NULL, NULL,
     "particles are put into an order every so many steps, from neighbour to neighbour (forces are then summed in "
     "another order); 0: never; -1: 4096 from 1000 particles on. Ids in records stay"},
    {0}};

static const struct key analysis_keys[] = {
    {"stage", KEY_STRING, OF(scene_analysis, stage), NULL, 0, 0, "", NULL, NULL,
     "name of the stage to evaluate; empty: the last one"},
    {"strain", KEY_CHOICE, OF(scene_analysis, strain), NULL, 0, 0, "engineering", strain_names, NULL,
     "measure of the strains in the report, in its windows and plots: 1 - L/L0 and 1 - V/V0, or -ln(L/L0) and "
     "-ln(V/V0); slopes are always those of logarithmic strains"},
    {"modulus_strain", KEY_FLOAT, OF(scene_analysis, modulus_strain), NULL, 1e-9, 1, "0.001", NULL, NULL,
     "window of the initial slopes: axial strain from 0 to this"},
    {"residual_strain", KEY_FLOAT, OF(scene_analysis, residual_strain), NULL, 0, 1, "0.005", NULL, NULL,
     "window of residual stress and critical state: this last part of the axial strain"},
    {"dilatancy_min_strain", KEY_FLOAT, OF(scene_analysis, dilatancy_min_strain), NULL, 0, 1, "0.01", NULL, NULL,
     "window of the dilatancy slope: from"},
    {"dilatancy_max_strain", KEY_FLOAT, OF(scene_analysis, dilatancy_max_strain), NULL, 0, 1, "0", NULL, NULL,
     "to; 0: the end of the stage"},
    {"negligible_rate", KEY_FLOAT, OF(scene_analysis, negligible_rate), NULL, 0, 1, "1e-4", NULL, NULL,
     "cycles: strain gained per cycle, over the strain amplitude of a cycle, below which it has no practical meaning"},
    {0}};

const struct key scene_keys[] = {
    {"name", KEY_STRING, OF(scene, name), NULL, 0, 0, "", NULL, NULL, "title of the scene"},
    {"dimension", KEY_INT, OF(scene, dimension), NULL, 2, 3, NULL, NULL, NULL,
     "2: biaxial box in x, z (depth 1 m); 3: triaxial box"},
    {"seed", KEY_INT, OF(scene, seed), NULL, 0, 9e15, "1", NULL, NULL, "seed of radii, order and velocities"},
    {"precision", KEY_CHOICE, OF(scene, precision), NULL, 0, 0, "double", precision_names, NULL,
     "of contacts; mixed: in float, from positions relative to where lists were built; forces off by 2e-7, faster. "
     "The ledger is double in either, the state keeps at least as many digits (docs/theory.md)"},
    {"gravity_m_per_s2", KEY_FLOATS, OF(scene, gravity_m_per_s2), "m/s^2", -1e6, 1e6, "", NULL, NULL,
     "[x, y, z]; empty: none"},
    {"checkpoint_interval_s", KEY_FLOAT, OF(scene, checkpoint_interval_s), "s", 0, INFINITY, "60", NULL, NULL,
     "wall-clock time between checkpoints, longer where they would take more than 1 % of the run; 0: none but at stage "
     "ends"},
    {"threads", KEY_INT, OF(scene, threads), NULL, 0, 256, "0", NULL, NULL,
     "threads of sim, at most: speed only, never the result; 0: one below 10000 particles, else as many as there are "
     "CPUs. As many of them are at work as shorten a step, which sim finds out while it runs"},
    {"sample", KEY_GROUP, OF(scene, sample), NULL, 0, 0, NULL, NULL, sample_keys, ""},
    {"material", KEY_GROUP, OF(scene, material), NULL, 0, 0, NULL, NULL, material_keys, ""},
    {"walls", KEY_GROUP, 0, NULL, 0, 0, NULL, NULL, scene_walls_keys, ""},
    {"coupling", KEY_GROUP, OF(scene, coupling), NULL, 0, 0, NULL, NULL, coupling_keys, ""},
    {"record", KEY_GROUP, OF(scene, record), NULL, 0, 0, NULL, NULL, record_keys, ""},
    {"neighbor", KEY_GROUP, OF(scene, neighbor), NULL, 0, 0, NULL, NULL, neighbor_keys, ""},
    {"limits", KEY_GROUP, OF(scene, limits), NULL, 0, 0, NULL, NULL, limits_keys, ""},
    {"analysis", KEY_GROUP, OF(scene, analysis), NULL, 0, 0, NULL, NULL, analysis_keys, ""},
    {0}};

/* Keys of the material that another one gives a meaning. */
static bool material_key_applies(const struct scene_material *material, const char *name)
{
    static const char *const of_friction[] = {"mu_d",       "wall_friction", "kt_n_per_m",        "gamma_t_kg_per_s",
                                              "mu_rolling", "mu_torsion",    "gamma_br_kg_per_s", "friction_limit",
                                              NULL};
    static const char *const of_rolling[] = {"kr_n_per_m", "gamma_r_kg_per_s", NULL};
    static const char *const of_torsion[] = {"ko_n_per_m", "gamma_o_kg_per_s", NULL};
    if (!scene_law_takes(material->law, name))
        return false;
    return (material->mu_s > 0 || !is_one_of(of_friction, name)) &&
           (material->mu_rolling > 0 || !is_one_of(of_rolling, name)) &&
           (material->mu_torsion > 0 || !is_one_of(of_torsion, name));
}

/* Keys of the sample by what it is made from. */
static bool sample_key_applies(const struct scene_sample *sample, const char *name)
{
    static const char *const of_distribution[] = {"radius_distribution", "radius_mean_m", "radius_sd_m",
                                                  "radius_median_m",     "radius_log_sd", NULL};
    static const char *const of_file[] = {"overlap_ratio", NULL};
    static const char *const of_lattice[] = {"gap_ratio", NULL}, *const of_random[] = {"solid_fraction", NULL};
    static const char *const of_both[] = {"aspect_ratio", "speed_m_per_s", NULL};
    const int initial = sample->initial;
    return !is_one_of(of_distribution, name) && (initial == INITIAL_FILE || !is_one_of(of_file, name)) &&
           (initial == INITIAL_LATTICE || !is_one_of(of_lattice, name)) &&
           (initial == INITIAL_RANDOM || !is_one_of(of_random, name)) &&
           (initial == INITIAL_LATTICE || initial == INITIAL_RANDOM || !is_one_of(of_both, name));
}

bool scene_key_applies(const struct key *table, const struct key *key, const void *group)
{
    if (table == axis_keys || table == scene_wall_material_keys || (key->preset && !key->preset[0]))
        return false;
    if (table == material_keys)
        return material_key_applies(group, key->name);
    return table != sample_keys || sample_key_applies(group, key->name);
}

/* What the check wants to be given (scene_check_stage.c): a pressure of 0 is a free wall, not the default. */
bool stage_key_applies(const struct key *table, const struct key *key, const void *group)
{
    const struct scene_axis *axis = group;
    if (table != axis_keys || (axis->mode != WALL_STRESS && axis->mode != WALL_COUPLED))
        return false;
    return (strcmp(key->name, "pressure_pa") == 0 && axis->pressure_pa == 0) ||
           (strcmp(key->name, "amplitude_pa") == 0 && scene_axis_period_s(axis) > 0 && axis->amplitude_pa == 0) ||
           (strcmp(key->name, "pressure_end_pa") == 0 && axis->target == TARGET_RAMP && axis->pressure_end_pa == 0);
}

const struct key scene_prepare_keys[] = {
    {"to", KEY_CHOICE, OF(scene_prepare, to), NULL, 0, 0, NULL, prepare_names, NULL,
     "dense: compressed without friction, which comes after; loose: with that of the material; both at pressure_pa; or "
     "a "
     "solid fraction, at which the walls stand still"},
    {"pressure_pa", KEY_FLOAT, OF(scene_prepare, pressure_pa), "N/m^2", 0, INFINITY, "0", NULL, NULL,
     "pressure of all walls; for a solid fraction about the one expected, which sets the pace"},
    {"solid_fraction", KEY_FLOAT, OF(scene_prepare, solid_fraction), NULL, 0, 0.95, "0", NULL, NULL,
     "to = \"solid_fraction\": of the volume between the walls, overlaps counted twice"},
    {"mu_s", KEY_FLOAT, OF(scene_prepare, mu_s), NULL, -1, 100, "-1", NULL, NULL,
     "coefficient of friction while compressing; -1: 0, or the material's for loose"},
    {"inertial_number", KEY_FLOAT, OF(scene_prepare, inertial_number), NULL, 1e-6, 0.1, "3e-3", NULL, NULL,
     "of the compression, at that pressure: the largest rate times sqrt(m/(p d)), in 2D sqrt(m/p)"},
    {"dt_s", KEY_FLOAT, OF(scene_prepare, dt_s), "s", 1e-18, 1e6, "auto", auto_names, NULL, "time step, as of a stage"},
    {0}};

const struct key scene_group_keys[] = {{"repeat", KEY_INT, OF(scene_group, repeat), NULL, 1, SCENE_STAGES_MAX, NULL,
                                        NULL, NULL, "how often the stages of the group are run, one after the other"},
                                       {0}};

void scene_stage_start(const struct scene *scene, struct scene_stage *stage)
{
    config_defaults(scene_stage_keys, stage);
    stage->material = scene->material;
    stage->wall_material = scene->wall_material;
    memcpy(stage->axis, scene->axis, sizeof stage->axis);
    stage->limits = scene->limits;
}

/* What the stage says of its length otherwise. */
static double stage_length_s(const struct scene_stage *stage)
{
    double length_s = 0;
    for (int k = 0; k < SCENE_AXES; k++) {
        const double period_s = scene_axis_period_s(&stage->axis[k]);
        if (period_s > 0 && stage->until_cycles > 0)
            return (double)stage->until_cycles * period_s;
    }
    for (int k = 0; k < SCENE_AXES; k++)
        length_s = fmax(length_s, scene_axis_length_s(&stage->axis[k]));
    return length_s;
}

void scene_material_refine(struct scene_material *material)
{
    if (material->law == LAW_LINEAR && material->restitution < 1)
        material->law = LAW_LINEAR_RESTITUTION;
    if (material->law == LAW_HYSTERETIC && material->kp_n_per_m > 0)
        material->law = LAW_ELASTOPLASTIC;
}

bool scene_wall_material(const struct scene_stage *stage, enum axis axis, struct scene_material *material)
{
    const struct scene_material *said[] = {&stage->wall_material, &stage->axis[axis].material};
    int taken = 0;
    *material = stage->material;
    material->mu_d = material->wall_friction * (material->mu_d < 0 ? material->mu_s : material->mu_d);
    material->mu_s *= material->wall_friction;
    for (int k = 0; k < 2; k++) {
        taken += config_overlay(scene_wall_material_keys, said[k], material);
        if (!isnan(said[k]->mu_s) && isnan(said[k]->mu_d))
            material->mu_d = material->mu_s;
    }
    if (taken == 0)
        return false;
    if (material->law == LAW_LINEAR_RESTITUTION && !(material->restitution < 1))
        material->law = LAW_LINEAR;
    scene_material_refine(material);
    return true;
}

void scene_stage_complete(struct scene_stage *stage)
{
    if (stage->duration_s <= 0)
        stage->duration_s = stage_length_s(stage);
    if (stage->material.mu_d < 0)
        stage->material.mu_d = stage->material.mu_s;
    if (stage->sample_interval_s <= 0)
        stage->sample_interval_s = stage->duration_s / 500;
}
