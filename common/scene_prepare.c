#include "common/scene_prepare.h"

#include <math.h>
#include <stdlib.h>

#include "common/scene_keys.h"

static const double PI = 3.14159265358979323846;

/* Solid fraction at which friction-free particles jam, about: for the size of the box under pressure. */
static const double JAMMED[] = {0.84, 0.64};

/* What the stages are made of. Rates are those of the inertial number I = rate sqrt(m/(p d)), in 2D sqrt(m/p). */
struct plan {
    const struct scene *scene;
    const struct scene_prepare *prepare;
    double inertial_s; /* sqrt(m/(p d)) */
    double rate_per_s;
    double wall_damping_kg_per_s; /* under its pressure the wall moves no faster than at that rate */
    double wall_mass_kg;          /* and takes a tenth of the inertial time to get there */
    double grain_damping_kg_per_s;
    double mu_s; /* while compressing */
};

static struct plan plan_of(const struct scene *scene, const struct scene_prepare *prepare)
{
    const struct scene_sample *s = &scene->sample;
    const int dim = (int)scene->dimension;
    const double mass_kg = 4 * PI / 3 * s->density_kg_per_m3 * s->mean_cube_m3, a = cbrt(s->mean_cube_m3);
    const double solid = (double)s->count * (dim == 2 ? PI * a * a : 4 * PI / 3 * s->mean_cube_m3);
    const double length_m = pow(solid / JAMMED[dim - 2], 1.0 / dim), p = prepare->pressure_pa;
    struct plan plan = {.scene = scene, .prepare = prepare};
    plan.inertial_s = sqrt(mass_kg / (dim == 2 ? p : 2 * a * p));
    plan.rate_per_s = prepare->inertial_number / plan.inertial_s;
    plan.wall_damping_kg_per_s = p * (dim == 2 ? 1 : length_m) / (0.5 * plan.rate_per_s);
    plan.wall_mass_kg = 0.1 * plan.inertial_s * plan.wall_damping_kg_per_s;
    plan.grain_damping_kg_per_s = mass_kg / (5 * plan.inertial_s);
    plan.mu_s = prepare->to == PREPARE_LOOSE ? scene->material.mu_s : 0;
    plan.mu_s = prepare->mu_s >= 0 ? prepare->mu_s : plan.mu_s;
    return plan;
}

static void axes_under_pressure(FILE *out, const struct plan *plan)
{
    fprintf(out, "    walls = {\n");
    for (int k = 0; k < SCENE_AXES; k++)
        if (plan->scene->dimension == 3 || k != AXIS_Y)
            fprintf(out,
                    "      %c = { mode = \"stress\"; target = \"constant\"; pressure_pa = %.9e; mass_kg = %.3e; "
                    "damping_kg_per_s = %.3e; };\n",
                    "xyz"[k], plan -> prepare -> pressure_pa, plan -> wall_mass_kg, plan -> wall_damping_kg_per_s);
    fprintf(out, "    };\n");
}

static void axes_to_volume(FILE *out, const struct plan *plan, double strain)
{
    fprintf(out, "    walls = {\n");
    for (int k = 0; k < SCENE_AXES; k++)
        if (plan->scene->dimension == 3 || k != AXIS_Y)
            fprintf(out, "      %c = { mode = \"%s\"; course = \"smooth\"; strain = %.17e; frequency_hz = %.9e; };\n",
                    "xyz"[k], strain > 0 ? "strain" : "fixed", strain,
                    strain > 0 ? plan->rate_per_s / (PI * strain) : 1.0); /* pi f strain is the largest rate */
    fprintf(out, "    };\n");
}

static void stage_head(FILE *out, const struct plan *plan, const char *name, double duration_s)
{
    fprintf(out, "  {\n    name = \"%s\";\n", name);
    if (plan->prepare->dt_s > 0)
        fprintf(out, "    dt_s = %.9e;\n", plan->prepare->dt_s);
    if (duration_s > 0)
        fprintf(out, "    duration_s = %.3e;\n", duration_s);
}

static void damping(FILE *out, const struct plan *plan, bool compressing)
{
    /* a sphere's 2/5 m a^2 loses its spin as fast as m its speed */
    fprintf(out, "    material = { gamma_b_kg_per_s = %.3e; gamma_br_kg_per_s = %.3e;", plan->grain_damping_kg_per_s,
            0.4 * plan->grain_damping_kg_per_s);
    if (compressing)
        fprintf(out, " mu_s = %.9e; mu_d = %.9e;", plan->mu_s, plan->mu_s);
    fprintf(out, " };\n");
}

/* Until the stress is there and the grains have come to rest; then with the friction of the test. */
static void write_to_pressure(FILE *out, const struct plan *plan)
{
    stage_head(out, plan, "prepare-compress", 2 / plan->rate_per_s + 300 * plan->inertial_s);
    fprintf(out, "    until_energy_ratio = 1e-3;\n    until_stress_error = 1e-2;\n");
    damping(out, plan, true);
    axes_under_pressure(out, plan);
    fprintf(out, "  },\n");
    stage_head(out, plan, "prepare-settle", 500 * plan->inertial_s);
    fprintf(out, "    until_energy_ratio = 1e-6;\n    until_stress_error = 1e-3;\n    min_duration_s = %.3e;\n",
            10 * plan->inertial_s);
    damping(out, plan, false);
    axes_under_pressure(out, plan);
    fprintf(out, "  }\n");
}

static void write_to_fraction(FILE *out, const struct plan *plan)
{
    const double from = plan->scene->sample.solid_fraction, to = plan->prepare->solid_fraction;
    const double strain = 1 - pow(from / to, 1.0 / (double)plan->scene->dimension);
    stage_head(out, plan, "prepare-compress", 0);
    damping(out, plan, true);
    axes_to_volume(out, plan, strain);
    fprintf(out, "  },\n");
    stage_head(out, plan, "prepare-settle", 500 * plan->inertial_s);
    fprintf(out, "    until_energy_ratio = 1e-6;\n    min_duration_s = %.3e;\n", 10 * plan->inertial_s);
    damping(out, plan, false);
    axes_to_volume(out, plan, 0);
    fprintf(out, "  }\n");
}

static enum status prepare_check(const struct scene *scene, const struct scene_prepare *p, const config_setting_t *at)
{
    const double from = scene->sample.solid_fraction;
    if (!(p->pressure_pa > 0))
        return config_fail(at, "prepare",
                           "needs pressure_pa above 0: the pressure, or about that of the solid fraction, "
                           "which sets the pace");
    if (p->to == PREPARE_LOOSE && !(scene->material.mu_s > 0) && !(p->mu_s > 0))
        return config_fail(at, "prepare", "to = \"loose\" needs friction: mu_s in material, or here");
    if ((p->to == PREPARE_SOLID_FRACTION) != (p->solid_fraction > 0))
        return config_fail(at, "prepare", "solid_fraction goes with to = \"solid_fraction\"");
    if (p->to == PREPARE_SOLID_FRACTION && scene->sample.initial != INITIAL_RANDOM)
        return config_fail(at, "prepare",
                           "to = \"solid_fraction\" needs sample.initial = \"random\", whose solid fraction is known");
    if (p->to == PREPARE_SOLID_FRACTION && !(p->solid_fraction > from))
        return config_fail(at, "prepare", "solid_fraction (%g) must be above sample.solid_fraction (%g)",
                           p->solid_fraction, from);
    return STATUS_OK;
}

enum status scene_prepare_text(const struct scene *scene, const config_setting_t *root, char **text)
{
    const config_setting_t *at = config_setting_get_member(root, "prepare");
    struct scene_prepare prepare;
    size_t size = 0;
    *text = NULL;
    if (!at)
        return STATUS_OK;
    if (!config_setting_is_group(at))
        return config_fail(at, "prepare", "must be a group: prepare = { to = \"dense\"; pressure_pa = ...; }");
    config_defaults(scene_prepare_keys, &prepare);
    TRY(config_group_read(at, scene_prepare_keys, "prepare", NULL, &prepare));
    TRY(config_require(at, scene_prepare_keys, "prepare"));
    TRY(prepare_check(scene, &prepare, at));
    const struct plan plan = plan_of(scene, &prepare);
    FILE *out = open_memstream(text, &size);
    if (!out)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    fprintf(out, "stages = (\n");
    if (prepare.to == PREPARE_SOLID_FRACTION)
        write_to_fraction(out, &plan);
    else
        write_to_pressure(out, &plan);
    fprintf(out, ");\n");
    if (fclose(out) == 0)
        return STATUS_OK;
    free(*text);
    *text = NULL;
    return status_fail(STATUS_NO_MEMORY, "out of memory");
}
