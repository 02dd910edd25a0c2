#include "common/scene.h"

#include <errno.h>
#include <libgen.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define OF(type, member) offsetof(struct type, member)

static const char *const law_names[] = {"linear", "hysteretic", NULL};
static const char *const mode_names[] = {"fixed", "strain", "stress", NULL};
static const char *const opposite_names[] = {"fixed", "mirror", "constant", NULL};
static const char *const target_names[] = {"constant", "ramp", "cosine", NULL};
static const char *const radius_names[] = {"uniform", "gaussian", NULL};
static const char *const initial_names[] = {"lattice", "random", "checkpoint", NULL};
static const char *const scheme_names[] = {"hold", "jacobian", "pipelined", "adaptive", "impedance", NULL};
static const char *const precision_names[] = {"double", "mixed", NULL};
static const char *const strain_names[] = {"engineering", "logarithmic", NULL};
static const char *const walls_names[] = {"sampled", "full", NULL};

static const struct key material_keys[] = {
    {"law", KEY_CHOICE, OF(scene_material, law), NULL, 0, 0, "linear", law_names, NULL,
     "normal contact law: linear spring [D eq. 1] or linear hysteretic with cohesion [LH eq. 1.6]"},
    {"kn_n_per_m", KEY_FLOAT, OF(scene_material, kn_n_per_m), "N/m", 0, INFINITY, "0", NULL, NULL,
     "stiffness k of the linear law"},
    {"k1_n_per_m", KEY_FLOAT, OF(scene_material, k1_n_per_m), "N/m", 0, INFINITY, "0", NULL, NULL,
     "loading stiffness of the hysteretic law"},
    {"k2_n_per_m", KEY_FLOAT, OF(scene_material, k2_n_per_m), "N/m", 0, INFINITY, "0", NULL, NULL,
     "un- and reloading stiffness of the hysteretic law"},
    {"kc_n_per_m", KEY_FLOAT, OF(scene_material, kc_n_per_m), "N/m", 0, INFINITY, "0", NULL, NULL,
     "slope of the adhesion branch of the hysteretic law"},
    {"gamma_n_kg_per_s", KEY_FLOAT, OF(scene_material, gamma_n_kg_per_s), "kg/s", 0, INFINITY, "0", NULL, NULL,
     "normal dissipation gamma_0"},
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
    {"gamma_b_kg_per_s", KEY_FLOAT, OF(scene_material, gamma_b_kg_per_s), "kg/s", 0, INFINITY, "0", NULL, NULL,
     "background damping: force -gamma_b v on every particle"},
    {"gamma_br_kg_per_s", KEY_FLOAT, OF(scene_material, gamma_br_kg_per_s), "kg/s", 0, INFINITY, "0", NULL, NULL,
     "background damping of rotation: torque -gamma_br a^2 omega (a^2 is our reading of [D])"},
    {0}};

static const struct key axis_keys[] = {
    {"mode", KEY_CHOICE, OF(scene_axis, mode), NULL, 0, 0, "fixed", mode_names, NULL,
     "what moves the upper wall: nothing, a strain path [LH eq. 1.1], or a pressure [LH eq. 1.2]"},
    {"opposite", KEY_CHOICE, OF(scene_axis, opposite), NULL, 0, 0, "mirror", opposite_names, NULL,
     "the lower wall: fixed; mirror image of the upper (both driven by the mean force); or stress controlled at the "
     "constant pressure_pa"},
    {"strain", KEY_FLOAT, OF(scene_axis, strain), NULL, -10, 0.95, "0", NULL, NULL,
     "strain control: strain at the end, z_f = z_0 (1 - strain)"},
    {"frequency_hz", KEY_FLOAT, OF(scene_axis, frequency_hz), "1/s", 0, INFINITY, "0", NULL, NULL,
     "strain control: f; the motion takes 1/(2f), then the wall rests"},
    {"target", KEY_CHOICE, OF(scene_axis, target), NULL, 0, 0, "constant", target_names, NULL,
     "stress control: constant pressure_pa; ramp to pressure_end_pa in ramp_s; or cycles pressure_pa + amplitude_pa/2 "
     "(1 - cos(2 pi t/period_s))"},
    {"pressure_pa", KEY_FLOAT, OF(scene_axis, pressure_pa), "N/m^2", -INFINITY, INFINITY, "0", NULL, NULL,
     "stress control: the target, compression positive (2D: force per side length, depth 1 m)"},
    {"pressure_end_pa", KEY_FLOAT, OF(scene_axis, pressure_end_pa), "N/m^2", -INFINITY, INFINITY, "0", NULL, NULL,
     "end of a ramp"},
    {"ramp_s", KEY_FLOAT, OF(scene_axis, ramp_s), "s", 0, INFINITY, "0", NULL, NULL, "length of a ramp"},
    {"amplitude_pa", KEY_FLOAT, OF(scene_axis, amplitude_pa), "N/m^2", -INFINITY, INFINITY, "0", NULL, NULL,
     "cycles: peak to peak, delta sigma"},
    {"period_s", KEY_FLOAT, OF(scene_axis, period_s), "s", 0, INFINITY, "0", NULL, NULL, "cycles: period t0"},
    {"mass_kg", KEY_FLOAT, OF(scene_axis, mass_kg), "kg", 0, INFINITY, "0", NULL, NULL,
     "stress control: mass m_x of the wall"},
    {"damping_kg_per_s", KEY_FLOAT, OF(scene_axis, damping_kg_per_s), "kg/s", 0, INFINITY, "0", NULL, NULL,
     "stress control: damping gamma_x of the wall; mass and damping must not both be 0"},
    {0}};

#define WALLS_OF(type)                                                                                                 \
    {                                                                                                                  \
        {"x", KEY_GROUP, OF(type, axis[AXIS_X]), NULL, 0, 0, NULL, NULL, axis_keys, "lateral walls"},                  \
            {"y", KEY_GROUP, OF(type, axis[AXIS_Y]), NULL, 0, 0, NULL, NULL, axis_keys, "lateral walls, 3D only"},     \
            {"z", KEY_GROUP, OF(type, axis[AXIS_Z]), NULL, 0, 0, NULL, NULL, axis_keys, "axial walls"},                \
        {                                                                                                              \
            0                                                                                                          \
        }                                                                                                              \
    }
static const struct key scene_walls_keys[] = WALLS_OF(scene);
static const struct key stage_walls_keys[] = WALLS_OF(scene_stage);

static const struct key stage_keys[] = {
    {"name", KEY_STRING, OF(scene_stage, name), NULL, 0, 0, NULL, NULL, NULL, "name of the stage"},
    {"dt_s", KEY_FLOAT, OF(scene_stage, dt_s), "s", 1e-12, 1, NULL, NULL, NULL, "time step"},
    {"duration_s", KEY_FLOAT, OF(scene_stage, duration_s), "s", 0, INFINITY, NULL, NULL, NULL,
     "length of the stage; with a condition, the limit in time"},
    {"until_energy_ratio", KEY_FLOAT, OF(scene_stage, until_energy_ratio), NULL, 0, INFINITY, "0", NULL, NULL,
     "condition: the stage ends when E_kin/E_pot is below this; 0: none"},
    {"until_stress_error", KEY_FLOAT, OF(scene_stage, until_stress_error), NULL, 0, INFINITY, "0", NULL, NULL,
     "condition: the stage ends when each stress-controlled axis is within this fraction of its target; 0: none"},
    {"min_duration_s", KEY_FLOAT, OF(scene_stage, min_duration_s), "s", 0, INFINITY, "0", NULL, NULL,
     "conditions are not looked at before"},
    {"sample_interval_s", KEY_FLOAT, OF(scene_stage, sample_interval_s), "s", 0, INFINITY, "0", NULL, NULL,
     "time between samples; 0: duration_s/500"},
    {"frame_interval_s", KEY_FLOAT, OF(scene_stage, frame_interval_s), "s", 0, INFINITY, "0", NULL, NULL,
     "time between frames of particles and contacts; 0: only at frame_strains and at the end of the stage"},
    {"frame_strains", KEY_FLOATS, OF(scene_stage, frame_strains), NULL, -10, 0.95, "", NULL, NULL,
     "strains of the strain-controlled axis at which frames are recorded, in the order they are passed"},
    {"material", KEY_GROUP, OF(scene_stage, material), NULL, 0, 0, NULL, NULL, material_keys, ""},
    {"walls", KEY_GROUP, 0, NULL, 0, 0, NULL, NULL, stage_walls_keys, ""},
    {0}};

static const struct key sample_keys[] = {
    {"count", KEY_INT, OF(scene_sample, count), NULL, 1, 10000000, NULL, NULL, NULL, "number of particles N"},
    {"radius_distribution", KEY_CHOICE, OF(scene_sample, radius_distribution), NULL, 0, 0, "uniform", radius_names,
     NULL, "uniform in [radius_min_m, radius_max_m], or gaussian cut to that interval"},
    {"radius_min_m", KEY_FLOAT, OF(scene_sample, radius_min_m), "m", 1e-9, 1e3, NULL, NULL, NULL, "smallest radius"},
    {"radius_max_m", KEY_FLOAT, OF(scene_sample, radius_max_m), "m", 1e-9, 1e3, NULL, NULL, NULL, "largest radius"},
    {"radius_mean_m", KEY_FLOAT, OF(scene_sample, radius_mean_m), "m", 0, 1e3, "0", NULL, NULL, "gaussian: mean"},
    {"radius_sd_m", KEY_FLOAT, OF(scene_sample, radius_sd_m), "m", 0, 1e3, "0", NULL, NULL,
     "gaussian: standard deviation before cutting"},
    {"density_kg_per_m3", KEY_FLOAT, OF(scene_sample, density_kg_per_m3), "kg/m^3", 1e-6, 1e6, NULL, NULL, NULL,
     "density; the mass is a sphere's in 2D too [LH, D]"},
    {"initial", KEY_CHOICE, OF(scene_sample, initial), NULL, 0, 0, "lattice", initial_names, NULL,
     "lattice without overlap; random without overlap; or the final state of another run"},
    {"checkpoint", KEY_STRING, OF(scene_sample, checkpoint), NULL, 0, 0, "", NULL, NULL,
     "initial = \"checkpoint\": path of checkpoint.h5, relative to the scene file"},
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
     "(pipelined: with a delay of one)"},
    {"interval_steps", KEY_INT, OF(scene_coupling, interval_steps), "steps", 1, 1000000, "1", NULL, NULL,
     "exchange interval n; 1 is exact; adaptive: the longest"},
    {"tolerance", KEY_FLOAT, OF(scene_coupling, tolerance), NULL, 1e-9, 1, "1e-3", NULL, NULL,
     "adaptive: energy mismatch at the walls over their work, wanted in each interval"},
    {"busy_poll", KEY_BOOL, OF(scene_coupling, busy_poll), NULL, 0, 0, "false", NULL, NULL,
     "sim and wallctl wait for each other without sleeping: shorter waits, but a core each is always busy"},
    {"timeout_s", KEY_FLOAT, OF(scene_coupling, timeout_s), "s", 0.1, 86400, "30", NULL, NULL,
     "sim gives up after this long without an answer from wallctl or the recorder"},
    {0}};

static const struct key record_keys[] = {{"walls", KEY_CHOICE, OF(scene_record, walls), NULL, 0, 0, "sampled",
                                          walls_names, NULL, "wall states: with every sample, or each exchange"},
                                         {"event_log", KEY_BOOL, OF(scene_record, event_log), NULL, 0, 0, "false", NULL,
                                          NULL, "keep the raw messages as run.lcm, for lcm-logplayer and replays"},
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
    {0}};

static const struct key scene_keys[] = {
    {"name", KEY_STRING, OF(scene, name), NULL, 0, 0, "", NULL, NULL, "title of the scene"},
    {"dimension", KEY_INT, OF(scene, dimension), NULL, 2, 3, NULL, NULL, NULL,
     "2: biaxial box in x, z (depth 1 m); 3: triaxial box"},
    {"seed", KEY_INT, OF(scene, seed), NULL, 0, 9e15, "1", NULL, NULL, "seed of radii, order and velocities"},
    {"precision", KEY_CHOICE, OF(scene, precision), NULL, 0, 0, "double", precision_names, NULL,
     "of contacts; mixed: in float, from positions relative to where lists were built; forces off by 2e-7, faster. "
     "The ledger is double in either, the state keeps at least as many digits (docs/theory.md)"},
    {"gravity_m_per_s2", KEY_FLOATS, OF(scene, gravity_m_per_s2), "m/s^2", -1e6, 1e6, "", NULL, NULL,
     "[x, y, z]; empty: none"},
    {"checkpoint_interval_s", KEY_FLOAT, OF(scene, checkpoint_interval_s), "s", 0, INFINITY, "0", NULL, NULL,
     "wall-clock time between checkpoints; 0: none but at stage ends"},
    {"threads", KEY_INT, OF(scene, threads), NULL, 0, 256, "0", NULL, NULL,
     "threads of sim: speed only, never the result; 0: one below 10000 particles, else as many as there are CPUs"},
    {"sample", KEY_GROUP, OF(scene, sample), NULL, 0, 0, NULL, NULL, sample_keys, ""},
    {"material", KEY_GROUP, OF(scene, material), NULL, 0, 0, NULL, NULL, material_keys, ""},
    {"walls", KEY_GROUP, 0, NULL, 0, 0, NULL, NULL, scene_walls_keys, ""},
    {"coupling", KEY_GROUP, OF(scene, coupling), NULL, 0, 0, NULL, NULL, coupling_keys, ""},
    {"record", KEY_GROUP, OF(scene, record), NULL, 0, 0, NULL, NULL, record_keys, ""},
    {"neighbor", KEY_GROUP, OF(scene, neighbor), NULL, 0, 0, NULL, NULL, neighbor_keys, ""},
    {"analysis", KEY_GROUP, OF(scene, analysis), NULL, 0, 0, NULL, NULL, analysis_keys, ""},
    {0}};

/* Checks between the keys of one material; `where` is its path. */
static enum status material_check(const struct scene_material *m, const config_setting_t *at, const char *where)
{
    if (m->law == LAW_LINEAR && !(m->kn_n_per_m > 0))
        return config_fail(at, where, "law \"linear\" needs kn_n_per_m above 0");
    if (m->law == LAW_LINEAR && (m->k1_n_per_m > 0 || m->k2_n_per_m > 0 || m->kc_n_per_m > 0))
        return config_fail(at, where, "k1, k2 and kc belong to law \"hysteretic\"; law \"linear\" takes kn_n_per_m");
    if (m->law == LAW_HYSTERETIC && !(m->k1_n_per_m > 0 && m->k2_n_per_m >= m->k1_n_per_m))
        return config_fail(at, where, "law \"hysteretic\" needs 0 < k1_n_per_m <= k2_n_per_m (here %g and %g)",
                           m->k1_n_per_m, m->k2_n_per_m);
    if (m->law == LAW_HYSTERETIC && m->kn_n_per_m > 0)
        return config_fail(at, where, "kn_n_per_m belongs to law \"linear\"; law \"hysteretic\" takes k1 and k2");
    if (m->mu_d > m->mu_s)
        return config_fail(at, where, "mu_d (%g) must not exceed mu_s (%g)", m->mu_d, m->mu_s);
    if (m->mu_s > 0 && !(m->kt_n_per_m > 0))
        return config_fail(at, where, "friction (mu_s above 0) needs kt_n_per_m above 0");
    return STATUS_OK;
}

static enum status axis_check(const struct scene_axis *a, const config_setting_t *at, const char *where)
{
    if (a->mode == WALL_STRAIN && !(a->frequency_hz > 0))
        return config_fail(at, where, "mode \"strain\" needs frequency_hz above 0");
    if (a->mode == WALL_STRAIN && a->opposite == OPPOSITE_CONSTANT)
        return config_fail(at, where,
                           "opposite \"constant\" goes with mode \"stress\"; allowed here: \"fixed\", "
                           "\"mirror\"");
    if (a->mode != WALL_STRESS)
        return STATUS_OK;
    if (!(a->mass_kg > 0 || a->damping_kg_per_s > 0))
        return config_fail(at, where, "mode \"stress\" needs mass_kg or damping_kg_per_s above 0");
    if (a->target == TARGET_RAMP && !(a->ramp_s > 0))
        return config_fail(at, where, "target \"ramp\" needs ramp_s above 0");
    if (a->target == TARGET_COSINE && !(a->period_s > 0))
        return config_fail(at, where, "target \"cosine\" needs period_s above 0");
    return STATUS_OK;
}

static enum status stage_check(const struct scene *scene, const struct scene_stage *stage, const config_setting_t *at,
                               const char *where)
{
    char path[128];
    if (!(stage->duration_s >= stage->dt_s))
        return config_fail(at, where, "duration_s (%g) must be at least dt_s (%g)", stage->duration_s, stage->dt_s);
    if (stage->duration_s / stage->dt_s > 1e12)
        return config_fail(at, where, "duration_s/dt_s is above 1e12 steps");
    snprintf(path, sizeof path, "%s.material", where);
    TRY(material_check(&stage->material, at, path));
    int strained = 0;
    for (int k = 0; k < SCENE_AXES; k++) {
        snprintf(path, sizeof path, "%s.walls.%c", where, "xyz"[k]);
        if (scene->dimension == 2 && k == AXIS_Y && stage->axis[k].mode != WALL_FIXED)
            return config_fail(at, path, "a 2D scene has no walls in y");
        TRY(axis_check(&stage->axis[k], at, path));
        strained += stage->axis[k].mode == WALL_STRAIN;
    }
    if (stage->frame_strains.count > 0 && strained != 1)
        return config_fail(at, where, "frame_strains needs exactly one strain-controlled axis (here %d)", strained);
    return STATUS_OK;
}

static enum status sample_check(const struct scene_sample *sample, const config_setting_t *at)
{
    if (sample->radius_max_m < sample->radius_min_m)
        return config_fail(at, "sample", "radius_max_m (%g) must be at least radius_min_m (%g)", sample->radius_max_m,
                           sample->radius_min_m);
    if (sample->radius_distribution == RADIUS_GAUSSIAN &&
        !(sample->radius_sd_m > 0 && sample->radius_mean_m >= sample->radius_min_m &&
          sample->radius_mean_m <= sample->radius_max_m))
        return config_fail(at, "sample",
                           "gaussian radii need radius_sd_m above 0 and radius_mean_m between the cut-offs");
    if (sample->initial == INITIAL_CHECKPOINT && !sample->checkpoint[0])
        return config_fail(at, "sample", "initial = \"checkpoint\" needs the path in checkpoint");
    return STATUS_OK;
}

static enum status stages_read(struct scene *scene, const config_setting_t *root)
{
    const config_setting_t *list = config_setting_get_member(root, "stages");
    if (!list)
        return config_fail(root, "stages", "missing; a list of stages: stages = ( { ... }, { ... } )");
    int count = config_setting_length(list);
    if (!config_setting_is_list(list) || count < 1 || count > SCENE_STAGES_MAX)
        return config_fail(list, "stages", "must be a list of 1 to %d groups: stages = ( { ... }, { ... } )",
                           SCENE_STAGES_MAX);
    scene->n_stages = count;
    for (int k = 0; k < count; k++) {
        const config_setting_t *setting = config_setting_get_elem(list, (unsigned)k);
        struct scene_stage *stage = &scene->stage[k];
        char where[32];
        snprintf(where, sizeof where, "stages.%d", k);
        if (!config_setting_is_group(setting))
            return config_fail(setting, where, "must be a group: { name = ...; ... }");
        config_defaults(stage_keys, stage);
        stage->material = scene->material;
        memcpy(stage->axis, scene->axis, sizeof stage->axis);
        TRY(config_group_read(setting, stage_keys, where, NULL, stage));
        TRY(config_require(setting, stage_keys, where));
        if (stage->material.mu_d < 0)
            stage->material.mu_d = stage->material.mu_s;
        if (stage->sample_interval_s <= 0)
            stage->sample_interval_s = stage->duration_s / 500;
        TRY(stage_check(scene, stage, setting, where));
    }
    return STATUS_OK;
}

static enum status scene_read(struct scene *scene, const config_setting_t *root)
{
    static const char *const own[] = {"stages", NULL};
    config_defaults(scene_keys, scene);
    TRY(config_group_read(root, scene_keys, "", own, scene));
    TRY(config_require(root, scene_keys, ""));
    if (scene->gravity_m_per_s2.count != 0 && scene->gravity_m_per_s2.count != SCENE_AXES)
        return config_fail(config_setting_get_member(root, "gravity_m_per_s2"), "gravity_m_per_s2",
                           "must have 3 members [x, y, z], or none");
    TRY(sample_check(&scene->sample, config_setting_get_member(root, "sample")));
    TRY(stages_read(scene, root));
    if (scene_stage_find(scene, scene->analysis.stage) < 0)
        return config_fail(config_setting_get_member(root, "analysis"), "analysis.stage", "there is no stage \"%s\"",
                           scene->analysis.stage);
    return STATUS_OK;
}

static enum status parse(struct scene *scene, const char *text, const char *name, const char *const *overrides,
                         int n_overrides)
{
    config_t config;
    enum status status = STATUS_OK;
    memset(scene, 0, sizeof *scene);
    config_source_name(name);
    config_init(&config);
    if (config_read_string(&config, text) != CONFIG_TRUE)
        status = status_fail(STATUS_CONFIG, "%s:%d: %s", name, config_error_line(&config), config_error_text(&config));
    for (int k = 0; status == STATUS_OK && k < n_overrides; k++)
        status = config_override(&config, overrides[k]);
    if (status == STATUS_OK)
        status = scene_read(scene, config_root_setting(&config));
    config_destroy(&config);
    if (status != STATUS_OK)
        return status;
    scene->text = strdup(text);
    return scene->text ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "out of memory");
}

/* The whole file as a string; it travels in one message with the effective configuration. */
static enum status file_read(const char *path, char **text)
{
    enum { LIMIT = 24 * 1024 };
    FILE *file = fopen(path, "rb");
    if (!file)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    char *buffer = calloc(LIMIT + 1, 1);
    size_t length = buffer ? fread(buffer, 1, LIMIT + 1, file) : 0;
    int failed = ferror(file);
    fclose(file);
    enum status status = STATUS_OK;
    if (!buffer)
        status = status_fail(STATUS_NO_MEMORY, "out of memory");
    else if (failed)
        status = status_fail(STATUS_IO, "%s: cannot be read: %s", path, strerror(errno));
    else if (length > LIMIT)
        status = status_fail(STATUS_CONFIG, "%s: larger than %d bytes", path, LIMIT);
    else if (memchr(buffer, '\0', length))
        status = status_fail(STATUS_CONFIG, "%s: not a text file", path);
    if (status != STATUS_OK) {
        free(buffer);
        return status;
    }
    *text = buffer;
    return STATUS_OK;
}

/* Paths in a scene are relative to the scene file. */
static enum status checkpoint_resolve(struct scene *scene, const char *path)
{
    char copy[1024], joined[1024];
    if (!scene->sample.checkpoint[0] || scene->sample.checkpoint[0] == '/')
        return STATUS_OK;
    snprintf(copy, sizeof copy, "%s", path);
    int length = snprintf(joined, sizeof joined, "%s/%s", dirname(copy), scene->sample.checkpoint);
    if (length >= CONFIG_STRING_MAX)
        return status_fail(STATUS_CONFIG, "%s: sample.checkpoint: '%s' is too long", path, joined);
    memcpy(scene->sample.checkpoint, joined, (size_t)length + 1);
    return STATUS_OK;
}

/* RUN_INFO carries the text and the effective configuration in one message of at most 60 kB. */
static enum status check_message_size(const struct scene *scene, const char *path)
{
    enum { LIMIT = 58000 };
    char *effective = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&effective, &size);
    if (!out)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    scene_print(out, scene);
    bool failed = fclose(out) != 0;
    free(effective);
    if (failed)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    if (size + strlen(scene->text) > LIMIT)
        return status_fail(
            STATUS_CONFIG,
            "%s: the file and its effective configuration (%zu bytes) exceed the %d bytes that a message "
            "can carry; fewer stages or shorter comments would fit",
            path, size + strlen(scene->text), LIMIT);
    return STATUS_OK;
}

enum status scene_load(struct scene *scene, const char *path, const char *const *overrides, int n_overrides)
{
    char *text = NULL;
    TRY(file_read(path, &text));
    enum status status = parse(scene, text, path, overrides, n_overrides);
    free(text);
    if (status == STATUS_OK)
        status = check_message_size(scene, path);
    return status == STATUS_OK ? checkpoint_resolve(scene, path) : status;
}

enum status scene_parse(struct scene *scene, const char *text, const char *name)
{
    return parse(scene, text, name, NULL, 0);
}

void scene_free(struct scene *scene)
{
    free(scene->text);
    scene->text = NULL;
}

void scene_print(FILE *out, const struct scene *scene)
{
    config_print(out, scene_keys, scene, 0);
    fprintf(out, "stages = (\n");
    for (int k = 0; k < scene->n_stages; k++) {
        fprintf(out, "  {\n");
        config_print(out, stage_keys, &scene->stage[k], 4);
        fprintf(out, "  }%s\n", k + 1 < scene->n_stages ? "," : "");
    }
    fprintf(out, ");\n");
}

void scene_print_reference(FILE *out)
{
    static const char header[] = "| key | allowed | default | meaning |\n|---|---|---|---|\n";
    fprintf(
        out,
        "# Scene reference\n\nMade by `sim --reference` from the table of keys in `common/scene.c`: do not edit.\n\n"
        "A scene is a libconfig file. An unknown key is an error. Integers are taken where a number is asked for. "
        "Compression is positive in stress and strain.\nSources: [LH] Luding & Herrmann (2001), [D] David et al. "
        "(2007), see `theory.md`.\n\n## Scene\n\n`material` and `walls` hold for every stage that does not say "
        "otherwise.\n\n%s",
        header);
    config_print_reference(out, scene_keys, "");
    fprintf(
        out,
        "\n## Stages\n\n`stages = ( { ... }, { ... } )`, run in order. A stage takes its `material` and `walls` from "
        "the scene and overrides key by key.\n\n%s",
        header);
    config_print_reference(out, stage_keys, "");
}

bool scene_is_frictional(const struct scene *scene)
{
    bool any = false;
    for (int k = 0; k < scene->n_stages; k++)
        any = any || scene->stage[k].material.mu_s > 0;
    return any;
}

bool scene_is_hysteretic(const struct scene *scene)
{
    bool any = false;
    for (int k = 0; k < scene->n_stages; k++)
        any = any || scene->stage[k].material.law == LAW_HYSTERETIC;
    return any;
}

int scene_wall_count(const struct scene *scene)
{
    return 2 * (int)scene->dimension;
}

enum axis scene_pair_axis(const struct scene *scene, int pair)
{
    return scene->dimension == 3 ? (enum axis)pair : (pair == 0 ? AXIS_X : AXIS_Z);
}

int scene_stage_find(const struct scene *scene, const char *name)
{
    if (!name[0])
        return (int)scene->n_stages - 1;
    for (int k = 0; k < scene->n_stages; k++)
        if (strcmp(scene->stage[k].name, name) == 0)
            return k;
    return -1;
}

double scene_total_time_s(const struct scene *scene)
{
    double total = 0;
    for (int k = 0; k < scene->n_stages; k++)
        total += scene->stage[k].duration_s;
    return total;
}
