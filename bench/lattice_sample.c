#include "bench/lattice_sample.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/scene_file.h"
#include "sim/base/random.h"
#include "sim/sample/stage.h"
#include "sim/sample/time_step.h"

static const struct lattice_kind KINDS[] = {
    {2, 0.90, 0.1,
     "dimension = 2; threads = %d; precision = \"%s\";\nlimits = { overlap_ratio = 1.5; };\nneighbor = { skin_ratio = "
     "0.2; };\nsample = { count = %d; "
     "radius_min_m = 0.5e-3; radius_max_m = "
     "1.5e-3; "
     "density_kg_per_m3 = 2000.0; "
     "};\n"
     "material = { law = \"hysteretic\"; k1_n_per_m = 5e4; k2_n_per_m = 1e5; gamma_n_kg_per_s = 0.1; };\n"
     "stages = ( { name = \"relax\"; dt_s = 1e-6; duration_s = 1.0; material = { gamma_b_kg_per_s = 0.5; }; },\n"
     "  { name = \"test\"; dt_s = 5e-7; duration_s = 1.0; material = { gamma_b_kg_per_s = 0.01; }; } );\n"},
    {3, 0.645, 0.1,
     "dimension = 3; threads = %d; precision = \"%s\";\nlimits = { overlap_ratio = 1.5; };\nneighbor = { skin_ratio = "
     "0.15; };\nsample = { count = %d; "
     "radius_distribution = \"gaussian\"; "
     "radius_mean_m = 5e-3;\n"
     "  radius_sd_m = 0.7e-3; radius_min_m = 3e-3; radius_max_m = 7e-3; density_kg_per_m3 = 2000.0; };\n"
     "material = { kn_n_per_m = 5000.0; gamma_n_kg_per_s = 0.05; mu_s = 0.1; kt_n_per_m = 1000.0;\n"
     "  gamma_t_kg_per_s = 0.01; gamma_br_kg_per_s = 0.05; };\n"
     "stages = ( { name = \"relax\"; dt_s = 2e-5; duration_s = 10.0; material = { mu_s = 0.0; gamma_b_kg_per_s = 5.0; "
     "}; },\n"
     "  { name = \"test\"; dt_s = 2e-5; duration_s = 10.0; material = { gamma_b_kg_per_s = 0.2; }; } );\n"}};

const struct lattice_kind *lattice_kind_of(int dimension)
{
    return dimension == 2 ? &KINDS[0] : dimension == 3 ? &KINDS[1] : NULL;
}

enum status lattice_scene(struct scene *scene, const struct lattice_kind *kind, int threads, const char *precision,
                          int count)
{
    char text[2048];
    snprintf(text, sizeof text, kind->text, threads, precision, count);
    return scene_parse(scene, text, kind->dimension == 2 ? "discs" : "spheres");
}

/* The particle that gets each place: at random, or in order. */
static enum status draw_places(int count, bool ordered, int **place)
{
    struct random random;
    random_init(&random, 7);
    *place = malloc((size_t)count * sizeof **place);
    if (!*place)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    for (int k = 0; k < count; k++)
        (*place)[k] = k;
    for (int k = count - 1; !ordered && k > 0; k--) {
        int m = (int)(random_uniform(&random) * (k + 1)), swap = (*place)[k];
        (*place)[k] = (*place)[m];
        (*place)[m] = swap;
    }
    return STATUS_OK;
}

enum status lattice_pack(struct sample *sample, const struct lattice_kind *kind, bool ordered)
{
    struct particles *p = &sample->particles;
    struct random random;
    int *place;
    double volume = 1, *copy = malloc((size_t)p->count * sizeof *copy);
    random_init(&random, 1);
    TRY(draw_places(p->count, ordered, &place));
    if (!copy) {
        free(place);
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    }
    for (int c = 0; c < p->dimension; c++)
        volume *= sample_box_length_m(sample, c);
    double shrink = pow(particles_solid_volume(p) / kind->solid_fraction / volume, 1.0 / p->dimension);
    double spacing = shrink * 2.02 * sample->scene->sample.radius_max_m;
    for (int c = 0; c < p->dimension; c++) {
        memcpy(copy, p->x[c], (size_t)p->count * sizeof *copy);
        for (int i = 0; i < p->count; i++)
            p->x[c][i] = shrink * copy[place[i]] + kind->jitter * spacing * (2 * random_uniform(&random) - 1);
        sample->walls[2 * c].x *= shrink;
        sample->walls[2 * c + 1].x *= shrink;
    }
    free(copy);
    free(place);
    return sample_build_lists(sample);
}

enum status lattice_begin(struct sample *sample, int stage)
{
    struct wall_command command = {
        .stage = stage, .step = sample->step, .n_steps = INT_MAX, .n_walls = sample->n_walls};
    for (int w = 0; w < sample->n_walls; w++)
        command.position_m[w] = sample->walls[w].x;
    return sample_command(sample, &command);
}

enum status lattice_steps(struct sample *sample, int n)
{
    for (int k = 0; k < n; k++)
        TRY(sample_step_open(sample));
    return STATUS_OK;
}
