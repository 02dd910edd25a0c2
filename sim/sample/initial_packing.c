/* Starting radii, positions and velocities. */
#include <math.h>
#include <stdlib.h>

#include "sim/base/random.h"
#include "sim/sample/initial_packing.h"

static void draw_radii(struct particles *p, const struct scene_sample *sample, struct random *random)
{
    for (int i = 0; i < p->count; i++) {
        double a;
        do {
            a = sample->radius_distribution == RADIUS_UNIFORM
                    ? sample->radius_min_m + (sample->radius_max_m - sample->radius_min_m) * random_uniform(random)
                    : sample->radius_mean_m + sample->radius_sd_m * random_normal(random);
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

/* Grid of cells at least as large as the largest particle, and not many more of them than particles; each lists its
 * particles by links. */
struct grid {
    int cells[3];
    double size[3];
    int *first; /* of each cell, -1 ends */
    int *next;  /* of each particle */
};

static int grid_coordinate(const struct grid *grid, int c, double x)
{
    int k = (int)(x / grid->size[c]);
    return k < 0 ? 0 : k >= grid->cells[c] ? grid->cells[c] - 1 : k;
}

static bool overlaps(const struct particles *p, const struct grid *grid, const double *x, double radius)
{
    int from[3] = {0, 0, 0}, to[3] = {0, 0, 0};
    for (int c = 0; c < p->dimension; c++) {
        int k = grid_coordinate(grid, c, x[c]);
        from[c] = k > 0 ? k - 1 : 0;
        to[c] = k + 1 < grid->cells[c] ? k + 1 : k;
    }
    for (int k2 = from[2]; k2 <= to[2]; k2++)
        for (int k1 = from[1]; k1 <= to[1]; k1++)
            for (int k0 = from[0]; k0 <= to[0]; k0++)
                for (int j = grid->first[(k2 * grid->cells[1] + k1) * grid->cells[0] + k0]; j >= 0; j = grid->next[j]) {
                    double d2 = 0, reach = radius + p->radius[j];
                    for (int c = 0; c < p->dimension; c++)
                        d2 += (x[c] - p->x[c][j]) * (x[c] - p->x[c][j]);
                    if (d2 < reach * reach)
                        return true;
                }
    return false;
}

static enum status grid_init(struct grid *grid, const struct particles *p, const double *hi, double diameter)
{
    size_t total = 1;
    const double cells_max = ceil(pow(4.0 * p->count, 1.0 / p->dimension));
    double volume = 1;
    for (int c = 0; c < p->dimension; c++)
        volume *= hi[c];
    diameter = fmax(diameter, pow(volume, 1.0 / p->dimension) / cells_max);
    for (int c = 0; c < 3; c++) {
        grid->cells[c] = 1;
        grid->size[c] = 1;
        if (c >= p->dimension)
            continue;
        grid->cells[c] = (int)fmax(1, floor(hi[c] / diameter));
        grid->size[c] = hi[c] / grid->cells[c];
        total *= (size_t)grid->cells[c];
    }
    grid->first = malloc(total * sizeof *grid->first);
    grid->next = malloc((size_t)p->count * sizeof *grid->next);
    if (!grid->first || !grid->next)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    for (size_t k = 0; k < total; k++)
        grid->first[k] = -1;
    return STATUS_OK;
}

static void grid_insert(struct grid *grid, const struct particles *p, int i)
{
    int at[3] = {0, 0, 0};
    for (int c = 0; c < p->dimension; c++)
        at[c] = grid_coordinate(grid, c, p->x[c][i]);
    int cell = (at[2] * grid->cells[1] + at[1]) * grid->cells[0] + at[0];
    grid->next[i] = grid->first[cell];
    grid->first[cell] = i;
}

static int larger_radius_first(const void *a, const void *b)
{
    double ra = *(const double *)a, rb = *(const double *)b;
    return (ra < rb) - (ra > rb);
}

/* Random sequential addition, the largest first. */
static enum status insert_all(struct particles *p, struct grid *grid, const double *hi, struct random *random)
{
    enum { TRIES = 20000 };
    for (int i = 0; i < p->count; i++) {
        double x[3];
        int tries = 0;
        do {
            for (int c = 0; c < p->dimension; c++)
                x[c] = p->radius[i] + (hi[c] - 2 * p->radius[i]) * random_uniform(random);
        } while (overlaps(p, grid, x, p->radius[i]) && ++tries < TRIES);
        if (tries == TRIES)
            return status_fail(
                STATUS_LIMIT, "random start: no room for particle %d of %d after %d tries; lower sample.solid_fraction",
                i, p->count, TRIES);
        for (int c = 0; c < p->dimension; c++)
            p->x[c][i] = x[c];
        grid_insert(grid, p, i);
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
    struct grid grid = {0};
    enum status status = grid_init(&grid, p, hi, 2 * sample->radius_max_m);
    if (status == STATUS_OK)
        status = insert_all(p, &grid, hi, random);
    free(grid.first);
    free(grid.next);
    return status;
}

enum status initial_packing_make(struct particles *p, const struct scene *scene, double *box_lo_m, double *box_hi_m)
{
    struct random random;
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
