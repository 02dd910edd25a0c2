#include "sim/run/explain.h"

#include <math.h>
#include <string.h>
#include <unistd.h>

#include "common/auto_time_step.h"
#include "sim/measure/step_limit.h"
#include "sim/measure/strain_limit.h"
#include "sim/run/explain_scales.h"
#include "sim/run/sample_source.h"

static double mean_radius_m(const struct particles *p)
{
    double sum = 0;
    for (int i = 0; i < p->count; i++)
        sum += p->radius[i];
    return sum / p->count;
}

static size_t bytes_per_particle(const struct particles *p)
{
    bool frictional = p->n_rotations > 0;
    size_t real = p->mixed ? sizeof(float) : sizeof(double);
    size_t reals =
        4 * (size_t)p->dimension + 2 * (size_t)p->n_rotations + 3; /* x v a x_list, omega alpha, radius ... */
    size_t sums = (size_t)SUMS_BYTES(p->dimension, frictional, p->mixed);
    size_t record = RECORD_STRIDE(p->dimension, frictional, p->mixed) * sizeof(double);
    size_t columns = (size_t)(p->dimension + p->n_rotations) * real;
    /* mixed: and a rest of each; with friction lags */
    size_t views = p->mixed ? (size_t)(4 * p->dimension + 2 * p->n_rotations + frictional) * sizeof(float) : 0;
    size_t lags = frictional ? LAG_COLUMNS(p->dimension, p->mixed) * real : 0;
    return (reals + frictional) * sizeof(double) + record + sums + columns + views + lags;
}

/* What the kernels read and write. */
static size_t bytes_per_candidate(const struct contact_list *list, int dimension)
{
    size_t real = list->model.mixed ? sizeof(float) : sizeof(double), reals = 1;
    for (int c = 0; c < HISTORY_COLUMNS; c++)
        reals += history_has(&list->model, c);
    return sizeof(uint32_t) + (list->model.mixed ? (1 + (size_t)dimension) * sizeof(float) : 0) + reals * real;
}

static void explain_contacts(FILE *out, const struct contact_list *list, int dimension)
{
    const char *last = "";
    fprintf(out, "modelled per candidate contact: force");
    for (int c = 0; c < HISTORY_COLUMNS; c++) {
        const char *name = history_field(c)->name;
        if (history_has(&list->model, c) && strcmp(name, last) != 0)
            fprintf(out, ", %s", last = name);
    }
    fprintf(out, "%s: %zu bytes\n", list->model.frictional ? "" : "; no tangential force",
            bytes_per_candidate(list, dimension));
}

/* Walls whose material is not that of the particles. */
static void explain_walls(FILE *out, const struct sample *sample, const struct scene_stage *stage)
{
    for (int c = 0; c < sample->particles.dimension; c++) {
        const enum axis axis = sample_axis(sample, c);
        const int normal = sample->pairs.model.normal;
        struct scene_material material;
        if (!scene_wall_material(stage, axis, &material))
            continue;
        struct contact_law_constants law = contact_law_constants_of_walls(stage, axis, normal);
        contact_law_set_scale(&law, normal, mean_radius_m(&sample->particles), 0);
        fprintf(out, "    walls in %c of a material of their own: law %s, stiffness %.3g N/m", "xyz"[axis],
                scene_law_name(material.law), law.stiffness);
        if (sample->pairs.model.frictional)
            fprintf(out, ", mu_s %g, mu_d %g", law.mu_s, law.mu_d);
        fprintf(out, "\n");
    }
}

static void explain_time_step(FILE *out, const struct sample *sample)
{
    for (int s = 0; s < sample->scene->n_stages; s++) {
        const struct scene_stage *stage = &sample->scene->stage[s];
        const struct step_limit limit = step_limit_of(sample, stage);
        fprintf(out, "  stage %d %-12s dt %.3g s", s, stage->name, stage->dt_s);
        const double recommended_s = time_step_of_stage_s(sample->scene, stage);
        if (recommended_s > 0)
            fprintf(out, " (recommended, dt_s = \"auto\": %.3g s)", recommended_s);
        fprintf(out, ", shortest contact time %.3g s = %.0f steps; stable up to %.2g s", limit.contact_s,
                limit.contact_s / stage->dt_s, limit.stable_s);
        if (isfinite(limit.wall_stable_s))
            fprintf(out, ", wall %c up to %.2g s", limit.wall_axis, limit.wall_stable_s);
        fprintf(out, "\n");
        explain_walls(out, sample, stage);
    }
}

enum status explain_check(const struct scene *scene)
{
    struct sample *sample;
    /* a sample that another run is to make first cannot be looked at yet */
    if (scene->sample.initial == INITIAL_CHECKPOINT && access(scene->sample.checkpoint, R_OK) != 0)
        return STATUS_OK;
    TRY(sample_from_scene(&sample, scene));
    enum status status = step_limit_check(sample);
    if (status == STATUS_OK)
        status = strain_limit_check(sample, 0);
    sample_free(sample);
    return status;
}

enum status explain_scene(FILE *out, const struct scene *scene)
{
    struct sample *sample;
    char kernel_set[64];
    TRY(sample_from_scene(&sample, scene));
    sample_kernel_set(sample, kernel_set, sizeof kernel_set);
    const struct particles *p = &sample->particles;
    fprintf(out, "scene %s: %d particles, %d walls, %d stages\n", scene->name, p->count, sample->n_walls,
            (int)scene->n_stages);
    fprintf(out, "kernel  %s\n", kernel_set);
    fprintf(out, "modelled per particle: position, velocity, acceleration, force (%d components each)%s: %zu bytes\n",
            p->dimension, p->n_rotations ? ", rotation" : "; no rotation", bytes_per_particle(p));
    explain_contacts(out, &sample->pairs, p->dimension);
    fprintf(out, "starting box %g x %g", sample_box_length_m(sample, 0), sample_box_length_m(sample, 1));
    if (p->dimension == 3)
        fprintf(out, " x %g", sample_box_length_m(sample, 2));
    fprintf(out, " m, skin of the lists %g m%s\n", sample->verlet.skin,
            sample->verlet.skin_fixed > 0 ? "" : " to begin with (tuned while running)");
    explain_time_step(out, sample);
    enum status status = explain_scales(out, sample);
    if (status == STATUS_OK && scene->prepared)
        fprintf(out, "prepare stands for these stages:\n%s", scene->prepared);
    sample_free(sample);
    return status;
}
