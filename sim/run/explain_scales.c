#include "sim/run/explain_scales.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/bus.h"
#include "common/signals.h"
#include "sim/sample/stage.h"
#include "sim/sample/time_step.h"

static const double PI = 3.14159265358979323846;
static const double PACKED[] = {0.83, 0.62}, CONTACTS[] = {4, 6}, CONSTRAINED = 1.8;

static double pressure_of(const struct scene_stage *stage)
{
    double p = 0;
    for (int k = 0; k < SCENE_AXES; k++) {
        const struct scene_axis *a = &stage->axis[k];
        if (a->mode != WALL_STRESS && a->mode != WALL_COUPLED)
            continue;
        p = fmax(p, fmax(fabs(a->pressure_pa) + fabs(a->amplitude_pa), fabs(a->pressure_end_pa)));
        for (int j = 0; j < a->pressures_pa.count; j++)
            p = fmax(p, fabs(a->pressures_pa.value[j]));
    }
    return p;
}

static double largest_rate(const struct scene_stage *stage)
{
    double rate = 0;
    for (int k = 0; k < SCENE_AXES; k++) {
        const struct scene_axis *a = &stage->axis[k];
        if (a->mode != WALL_STRAIN)
            continue;
        const double cycle = fabs(a->strain) * a->frequency_hz * (a->two_way ? 2 : 1);
        if (a->course == COURSE_SMOOTH || a->course == COURSE_COSINE)
            rate = fmax(rate, PI * cycle);
        if (a->course == COURSE_TRIANGLE)
            rate = fmax(rate, 2 * cycle);
        if (a->course == COURSE_RATE)
            rate = fmax(rate, fabs(a->rate_per_s));
    }
    return rate;
}

struct stage_scales stage_scales_of(const struct sample *sample, int s)
{
    const struct particles *p = &sample->particles;
    const struct scene_stage *stage = &sample->scene->stage[s];
    const struct scene_material *m = &stage->material;
    const int dim = p->dimension;
    struct stage_scales scales = {.pressure_pa = pressure_of(stage), .rate_per_s = largest_rate(stage)};
    double radius = 0;
    for (int i = 0; i < p->count; i++) {
        radius += p->radius[i] / p->count;
        scales.grain_kg += p->mass[i] / p->count;
    }
    const double d = 2 * radius, phi = PACKED[dim - 2];
    scales.length_m = pow(particles_solid_volume(p) / phi, 1.0 / dim);
    if (!(scales.pressure_pa > 0))
        return scales;
    const double load = scales.pressure_pa * (dim == 2 ? 1 : d); /* N/m */
    struct contact_law_constants law = contact_law_constants_of(m, sample->pairs.model.normal);
    /* mean force of a contact: p d^2, in 2D p d */
    contact_law_set_scale(&law, sample->pairs.model.normal, radius, load * d);
    scales.stiffness_n_per_m = law.stiffness;
    scales.kappa = law.stiffness / load;
    if (m->law == LAW_HERTZ)
        scales.modulus_over_p =
            m->youngs_modulus_pa / (2 * (1 - m->poisson_ratio * m->poisson_ratio)) / scales.pressure_pa;
    scales.contact_s = PI * sqrt(scales.grain_kg / (2 * law.stiffness));
    scales.inertial_s = sqrt(scales.grain_kg / load);
    scales.inertial_number = scales.rate_per_s * scales.inertial_s;
    const double bulk = CONTACTS[dim - 2] * phi * law.stiffness / (dim == 2 ? 2 * PI : 3 * PI * d);
    const double density = scales.grain_kg * p->count / pow(scales.length_m, dim);
    scales.wave_s = 2 * scales.length_m / sqrt(CONSTRAINED * bulk / density);
    const double force = scales.pressure_pa * (dim == 2 ? scales.length_m : scales.length_m * scales.length_m);
    scales.wall_damping_kg_per_s = 1e-3 * force / (0.5 * scales.length_m * 1e-3 / scales.inertial_s);
    return scales;
}

static void print_stage(FILE *out, const struct sample *sample, int s)
{
    const struct scene_stage *stage = &sample->scene->stage[s];
    const struct stage_scales x = stage_scales_of(sample, s);
    const char *dimension = sample->particles.dimension == 2 ? "k/p" : "k/(p d)";
    fprintf(out, "  stage %d %-12s ", s, stage->name);
    if (!(x.pressure_pa > 0)) {
        fprintf(out, "no pressure as a target: no scales\n");
        return;
    }
    fprintf(out, "p %.3g Pa: stiffness number %s = %.3g%s", x.pressure_pa, dimension, x.kappa,
            x.kappa < 1000 ? " (below 1000: soft)" : "");
    if (x.modulus_over_p > 0)
        fprintf(out, ", E*/p = %.3g", x.modulus_over_p);
    fprintf(out,
            "\n    contact stiffness %.3g N/m; contact time %.3g s = %.0f steps; inertial time sqrt(m/(p d)) %.3g s: "
            "rates up to %.3g 1/s for I = 1e-3",
            x.stiffness_n_per_m, x.contact_s, x.contact_s / stage->dt_s, x.inertial_s, 1e-3 / x.inertial_s);
    if (x.rate_per_s > 0)
        fprintf(out, "; largest rate here %.3g 1/s, I = %.2g%s", x.rate_per_s, x.inertial_number,
                x.inertial_number > 1e-3 ? " (above 1e-3: not quasi-static)" : "");
    fprintf(out,
            "\n    a wave there and back through %.3g m takes about %.3g s; walls: mass about that of a grain, %.2g "
            "kg, damping up "
            "to %.2g kg/s (0.1 %% of p at I = 1e-3)\n",
            x.length_m, x.wave_s, x.grain_kg, x.wall_damping_kg_per_s);
}

static enum status time_steps(struct sample *sample, double *seconds_per_step)
{
    struct wall_command command = {.n_steps = INT_MAX, .n_walls = sample->n_walls};
    for (int w = 0; w < sample->n_walls; w++)
        command.position_m[w] = sample->walls[w].x;
    TRY(sample_command(sample, &command));
    const double start_s = clock_now_s();
    int n = 0;
    for (; n < 100000 && (n < 3 || clock_now_s() - start_s < 0.1); n++)
        TRY(sample_step_open(sample));
    *seconds_per_step = (clock_now_s() - start_s) / n;
    return STATUS_OK;
}

/* A lattice of mean particles that touch and rest. */
static enum status seconds_per_step_of(const struct scene *scene, double mean_radius_m, double *seconds)
{
    struct sample *sample;
    struct scene *lattice = malloc(sizeof *lattice);
    if (!lattice)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    *lattice = *scene;
    lattice->sample.initial = INITIAL_LATTICE;
    lattice->sample.radius_distribution = RADIUS_UNIFORM;
    lattice->sample.radius_min_m = lattice->sample.radius_max_m = mean_radius_m;
    lattice->sample.gap_ratio = 0;
    lattice->sample.speed_m_per_s = 0;
    enum status status = sample_create(&sample, lattice);
    if (status == STATUS_OK) {
        status = time_steps(sample, seconds);
        sample_free(sample);
    }
    free(lattice);
    return status;
}

enum status explain_scales(FILE *out, const struct sample *sample)
{
    const struct scene *scene = sample->scene;
    double steps = 0, radius = 0, seconds = 0;
    fprintf(
        out,
        "scales, estimated for a packed sample under the largest pressure of each stage (docs/your-own-material.md)\n");
    for (int s = 0; s < scene->n_stages; s++) {
        print_stage(out, sample, s);
        steps += scene->stage[s].duration_s / scene->stage[s].dt_s;
    }
    for (int i = 0; i < sample->particles.count; i++)
        radius += sample->particles.radius[i] / sample->particles.count;
    TRY(seconds_per_step_of(scene, radius, &seconds));
    fprintf(out,
            "cost: at most %.3g steps of about %.3g us on this machine, %.3g s, limits of stages counted in full\n",
            steps, 1e6 * seconds, steps * seconds);
    return STATUS_OK;
}
