#include "sim/particles.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim/memory.h"

static enum status components_resize(double **component, int n, int count)
{
    for (int c = 0; c < n; c++)
        TRY(array_resize(&component[c], sizeof(double), (size_t)count, 0));
    return STATUS_OK;
}

/* Two particles behind the last that fill up vectors: a metre apart, with radii that touch nothing. */
static void pad(struct particles *p)
{
    p->x[0][p->count + 1] = p->x_list[0][p->count + 1] = 1;
    p->radius[p->count] = p->radius[p->count + 1] = -1e6;
    /* drift does not reach the records of both when the last vector is full */
    p->record[(size_t)(p->count + 1) * RECORD_STRIDE(p->dimension, p->n_rotations > 0)] = 1;
}

enum status particles_init(struct particles *p, int count, int dimension, bool rotations)
{
    memset(p, 0, sizeof *p);
    p->count = count;
    p->dimension = dimension;
    p->n_rotations = !rotations ? 0 : dimension == 2 ? 1 : 3;
    TRY(array_resize(&p->id, sizeof *p->id, (size_t)count, 0));
    TRY(array_resize(&p->slot, sizeof *p->slot, (size_t)count, 0));
    for (int i = 0; i < count; i++)
        p->id[i] = p->slot[i] = i;
    TRY(components_resize(p->x, dimension, count));
    TRY(components_resize(p->v, dimension, count));
    TRY(components_resize(p->a, dimension, count));
    TRY(array_resize(&p->record, RECORD_STRIDE(dimension, rotations) * sizeof(double), (size_t)count, 0));
    TRY(array_resize(&p->force, FORCE_STRIDE(dimension, rotations) * sizeof(double), (size_t)count, 0));
    TRY(components_resize(p->x_list, dimension, count));
    TRY(components_resize(p->omega, p->n_rotations, count));
    TRY(components_resize(p->alpha, p->n_rotations, count));
    TRY(components_resize(&p->radius, 1, count));
    TRY(components_resize(&p->mass, 1, count));
    TRY(components_resize(&p->inv_mass, 1, count));
    if (rotations)
        TRY(components_resize(&p->inv_inertia, 1, count));
    pad(p);
    return STATUS_OK;
}

size_t particles_force_size(const struct particles *p)
{
    return (size_t)(p->count + ARRAY_PADDING) * FORCE_STRIDE(p->dimension, p->n_rotations > 0) * sizeof(double);
}

void particles_force_add(struct particles *p, const void *force, size_t from, size_t to)
{
    double *sum = p->force;
    const double *added = force;
    for (size_t k = from / sizeof *sum; k < to / sizeof *sum; k++)
        sum[k] += added[k];
}

void particles_free(struct particles *p)
{
    for (int c = 0; c < 3; c++) {
        free(p->x[c]);
        free(p->v[c]);
        free(p->a[c]);
        free(p->omega[c]);
        free(p->alpha[c]);
        free(p->x_list[c]);
    }
    free(p->id);
    free(p->slot);
    free(p->record);
    free(p->force);
    free(p->radius);
    free(p->mass);
    free(p->inv_mass);
    free(p->inv_inertia);
    memset(p, 0, sizeof *p);
}

void particles_set_inverse(struct particles *p)
{
    for (int i = 0; i < p->count; i++) {
        double a = p->radius[i];
        p->inv_mass[i] = 1 / p->mass[i];
        if (p->n_rotations)
            p->inv_inertia[i] = 1 / (0.4 * p->mass[i] * a * a);
    }
}

void particles_set_mass(struct particles *p, double density_kg_per_m3)
{
    const double pi = 3.14159265358979323846;
    for (int i = 0; i < p->count; i++) {
        double a = p->radius[i];
        p->mass[i] = 4.0 / 3.0 * pi * density_kg_per_m3 * a * a * a;
    }
    particles_set_inverse(p);
}

double particles_solid_volume(const struct particles *p)
{
    const double pi = 3.14159265358979323846;
    double volume = 0;
    for (int i = 0; i < p->count; i++)
        volume += p->dimension == 2 ? pi * p->radius[i] * p->radius[i] : 4.0 / 3.0 * pi * pow(p->radius[i], 3);
    return volume;
}
