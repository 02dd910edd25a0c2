/* Starting radii, positions and velocities. */
#include <math.h>
#include <stdlib.h>

#include "common/size_distribution.h"
#include "sim/base/random.h"
#include "sim/sample/grains_from_file.h"
#include "sim/sample/initial_packing.h"
#include "sim/sample/packing_grid.h"

static double draw_radius(const struct scene_sample *sample, struct random *random)
{
    switch (sample->radius_distribution) {
    case RADIUS_GAUSSIAN:
        return sample->radius_mean_m + sample->radius_sd_m * random_normal(random);
    case RADIUS_LOGNORMAL:
        return sample->radius_median_m * exp(sample->radius_log_sd * random_normal(random));
    default:
        return sample->radius_min_m + (sample->radius_max_m - sample->radius_min_m) * random_uniform(random);
    }
}

/* Those of a grading curve, in any order. */
static void deal_radii(struct particles *p, const struct scene_sample *sample, struct random *random)
{
    for (int i = 0; i < p->count; i++)
        p->radius[i] = size_table_radius_m(sample, i, p->count);
    for (int i = p->count - 1; i > 0; i--) {
        const int j = (int)(random_uniform(random) * (i + 1));
        const double a = p->radius[i];
        p->radius[i] = p->radius[j];
        p->radius[j] = a;
    }
}

static void draw_radii(struct particles *p, const struct scene_sample *sample, struct random *random)
{
    if (sample->radius_distribution == RADIUS_TABLE) {
        deal_radii(p, sample, random);
        return;
    }
    for (int i = 0; i < p->count; i++) {
        double a;
        do {
            a = draw_radius(sample, random);
        } while (a < sample->radius_min_m || a > sample->radius_max_m);
        p->radius[i] = a;
    }
}

static void draw_velocities(struct particles *p, double speed, struct random *random)
{
    for (int i = 0; i < p->count; i++)
        for (int c = 0; c < p->dimension; c++)
            p->v[c][i] = speed * (2 * random_uniform(random) - 1);
}

/* Cells of a lattice for `count` particles: x (and y) alike, z so that the box has the aspect ratio. */
static void lattice_cells(int count, int dimension, double aspect, int *cells)
{
    int last = dimension - 1, layer = 1;
    int across = (int)ceil(pow(count / aspect, 1.0 / dimension));
    for (int c = 0; c < last; c++) {
        cells[c] = across > 0 ? across : 1;
        layer *= cells[c];
    }
    cells[last] = (count + layer - 1) / layer;
}

static void place_lattice(struct particles *p, const struct scene_sample *sample, double *lo, double *hi)
{
    int cells[3] = {1, 1, 1};
    lattice_cells(p->count, p->dimension, sample->aspect_ratio, cells);
    double spacing = 2 * sample->radius_max_m * (1 + sample->gap_ratio);
    for (int c = 0; c < p->dimension; c++) {
        lo[c] = 0;
        hi[c] = spacing * cells[c];
    }
    for (int i = 0; i < p->count; i++) {
        int rest = i;
        for (int c = 0; c < p->dimension; c++) {
            p->x[c][i] = spacing * (rest % cells[c] + 0.5);
            rest /= cells[c];
        }
    }
}

static int larger_radius_first(const void *a, const void *b)
{
    double ra = *(const double *)a, rb = *(const double *)b;
    return (ra < rb) - (ra > rb);
}

/* Random sequential addition, the largest first. */
static enum status insert_all(struct particles *p, struct packing_grid *grid, const double *hi, struct random *random)
{
    enum { TRIES = 20000 };
    for (int i = 0; i < p->count; i++) {
        double x[3];
        int tries = 0;
        do {
            for (int c = 0; c < p->dimension; c++)
                x[c] = p->radius[i] + (hi[c] - 2 * p->radius[i]) * random_uniform(random);
        } while (packing_grid_overlap(grid, p, x, p->radius[i], 0) >= 0 && ++tries < TRIES);
        if (tries == TRIES)
            return status_fail(
                STATUS_LIMIT, "random start: no room for particle %d of %d after %d tries; lower sample.solid_fraction",
                i, p->count, TRIES);
        for (int c = 0; c < p->dimension; c++)
            p->x[c][i] = x[c];
        packing_grid_insert(grid, p, i);
    }
    return STATUS_OK;
}

static enum status place_random(struct particles *p, const struct scene_sample *sample, struct random *random,
                                double *lo, double *hi)
{
    double volume = particles_solid_volume(p) / sample->solid_fraction;
    double width = pow(volume / sample->aspect_ratio, 1.0 / p->dimension);
    for (int c = 0; c < p->dimension; c++) {
        lo[c] = 0;
        hi[c] = c == p->dimension - 1 ? width * sample->aspect_ratio : width;
        if (hi[c] < 2 * sample->radius_max_m)
            return status_fail(
                STATUS_LIMIT,
                "random start: the box is smaller than the largest particle; lower sample.solid_fraction");
    }
    qsort(p->radius, (size_t)p->count, sizeof *p->radius, larger_radius_first);
    struct packing_grid grid;
    enum status status = packing_grid_init(&grid, p, lo, hi, 2 * sample->radius_max_m);
    if (status == STATUS_OK)
        status = insert_all(p, &grid, hi, random);
    packing_grid_free(&grid);
    return status;
}

enum status initial_packing_make(struct particles *p, const struct scene *scene, double *box_lo_m, double *box_hi_m)
{
    struct random random;
    if (scene->sample.initial == INITIAL_FILE)
        return grains_from_file(p, scene, box_lo_m, box_hi_m);
    random_init(&random, (uint64_t)scene->seed);
    draw_radii(p, &scene->sample, &random);
    if (scene->sample.initial == INITIAL_RANDOM)
        TRY(place_random(p, &scene->sample, &random, box_lo_m, box_hi_m));
    else
        place_lattice(p, &scene->sample, box_lo_m, box_hi_m);
    particles_set_mass(p, scene->sample.density_kg_per_m3);
    draw_velocities(p, scene->sample.speed_m_per_s, &random);
    return STATUS_OK;
}
