#include "sim/sample/grains_from_file.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/grain_file.h"
#include "sim/sample/packing_grid.h"

/* The scene's axis that component c is. */
static int axis_of(const struct particles *p, int c)
{
    return p->dimension == 2 && c == 1 ? AXIS_Z : c;
}

static enum status take_spin(struct particles *p, const struct scene *scene, const struct csv_table *table, int i)
{
    const double *row = table->value + (int64_t)i * table->n_columns;
    if (p->n_rotations == 1)
        p->omega[0][i] = -row[GRAIN_OMEGA_Y]; /* ours is about x cross z, which is -y */
    for (int c = 0; c < 3 && p->n_rotations == 3; c++)
        p->omega[c][i] = row[GRAIN_OMEGA_X + c];
    if (p->n_rotations > 0 || (row[GRAIN_OMEGA_X] == 0 && row[GRAIN_OMEGA_Y] == 0 && row[GRAIN_OMEGA_Z] == 0))
        return STATUS_OK;
    return status_fail(
        STATUS_CONFIG,
        "%s:%d: a spin, but no stage has friction: rotations are not modelled; allowed: 0, or mu_s above "
        "0 in a stage",
        scene->sample.file, table->line[i]);
}

static enum status take_grains(struct particles *p, const struct scene *scene, const struct csv_table *table)
{
    for (int i = 0; i < p->count; i++) {
        p->radius[i] = csv_value(table, i, GRAIN_RADIUS);
        for (int c = 0; c < p->dimension; c++) {
            p->x[c][i] = csv_value(table, i, GRAIN_X + axis_of(p, c));
            p->v[c][i] = csv_value(table, i, GRAIN_VX + axis_of(p, c));
        }
        TRY(take_spin(p, scene, table, i));
    }
    return STATUS_OK;
}

/* Masses and moments of inertia. */
static void set_masses(struct particles *p, const struct scene_sample *s, const struct csv_table *table)
{
    particles_set_mass(p, s->density_kg_per_m3);
    if (!table->has[GRAIN_DENSITY])
        return;
    for (int i = 0; i < p->count; i++)
        p->mass[i] *= csv_value(table, i, GRAIN_DENSITY) / s->density_kg_per_m3;
    particles_set_inverse(p);
}

static void make_box(const struct particles *p, const struct scene_sample *s, double *lo, double *hi)
{
    for (int c = 0; c < p->dimension; c++) {
        lo[c] = INFINITY;
        hi[c] = -INFINITY;
        for (int i = 0; i < p->count; i++) {
            lo[c] = fmin(lo[c], p->x[c][i] - p->radius[i]);
            hi[c] = fmax(hi[c], p->x[c][i] + p->radius[i]);
        }
        lo[c] = s->box_min_m.count ? s->box_min_m.value[c] : lo[c];
        hi[c] = s->box_max_m.count ? s->box_max_m.value[c] : hi[c];
    }
}

static enum status check_inside(const struct particles *p, const struct scene_sample *s, const struct csv_table *table,
                                const double *lo, const double *hi)
{
    for (int i = 0; i < p->count; i++) {
        const double reach = (1 - s->overlap_ratio) * p->radius[i];
        for (int c = 0; c < p->dimension; c++)
            if (!(p->x[c][i] - reach >= lo[c] && p->x[c][i] + reach <= hi[c]))
                return status_fail(
                    STATUS_CONFIG,
                    "%s:%d: the grain is not inside the box, which goes from %g to %g m in %c (box_min_m, "
                    "box_max_m)",
                    s->file, table->line[i], lo[c], hi[c], "xyz"[axis_of(p, c)]);
    }
    return STATUS_OK;
}

static enum status check_apart(const struct particles *p, struct packing_grid *grid, const struct scene_sample *s,
                               const struct csv_table *table)
{
    for (int i = 0; i < p->count; i++) {
        double x[3];
        for (int c = 0; c < p->dimension; c++)
            x[c] = p->x[c][i];
        const int j = packing_grid_overlap(grid, p, x, p->radius[i], s->overlap_ratio);
        if (j >= 0)
            return status_fail(STATUS_CONFIG,
                               "%s:%d: the grain overlaps that of line %d; allowed: up to overlap_ratio = %g of the "
                               "smaller radius",
                               s->file, table->line[i], table->line[j], s->overlap_ratio);
        packing_grid_insert(grid, p, i);
    }
    return STATUS_OK;
}

static enum status place(struct particles *p, const struct scene *scene, const struct csv_table *table, double *lo,
                         double *hi)
{
    const struct scene_sample *s = &scene->sample;
    char hash[20];
    snprintf(hash, sizeof hash, "%016" PRIx64, table->hash);
    if (table->rows != p->count || strcmp(hash, s->file_hash) != 0)
        return status_fail(STATUS_CONFIG, "%s: its content has changed since the scene was read", s->file);
    TRY(take_grains(p, scene, table));
    make_box(p, s, lo, hi);
    TRY(check_inside(p, s, table, lo, hi));
    struct packing_grid grid;
    enum status status = packing_grid_init(&grid, p, lo, hi, 2 * s->radius_max_m);
    if (status == STATUS_OK)
        status = check_apart(p, &grid, s, table);
    packing_grid_free(&grid);
    set_masses(p, s, table);
    return status;
}

enum status grains_from_file(struct particles *p, const struct scene *scene, double *box_lo_m, double *box_hi_m)
{
    struct csv_table table;
    TRY(grain_file_read(&table, scene->sample.file, (int)scene->dimension));
    enum status status = place(p, scene, &table, box_lo_m, box_hi_m);
    csv_table_free(&table);
    return status;
}
