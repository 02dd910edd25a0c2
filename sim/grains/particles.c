#include "sim/grains/particles.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim/base/aligned_array.h"

static enum status components_resize(double **component, int n, int count)
{
    for (int c = 0; c < n; c++)
        TRY(array_resize(&component[c], sizeof(double), (size_t)count, 0));
    return STATUS_OK;
}

static bool frictional(const struct particles *p)
{
    return p->n_rotations > 0;
}

int particles_padding(const struct particles *p)
{
    return p->n_padded - 1;
}

int particles_spare_padding(const struct particles *p, int k)
{
    return particles_padding(p) - k * ARRAY_PADDING;
}

static int paddings(const struct particles *p)
{
    return p->count < PARTICLES_LARGE_SAMPLE ? 1 : PARTICLES_PADDINGS;
}

static void pad_row(struct particles *p, int row)
{
    const size_t stride = RECORD_STRIDE(p->dimension, frictional(p), p->mixed);
    double *record = (double *)p->record + (size_t)row * stride;
    memset(record, 0, stride * sizeof *record);
    if (!p->mixed)
        record[0] = 1e9; /* its first coordinate [m]; with a reach of 0 it touches nothing wherever it is */
}

static enum status rests_init(struct particles *p)
{
    for (int c = 0; p->mixed && c < p->dimension; c++) {
        TRY(array_resize(&p->u_rest[c], sizeof(float), (size_t)p->count, 0));
        TRY(array_resize(&p->v_rest[c], sizeof(float), (size_t)p->count, 0));
    }
    for (int c = 0; p->mixed && c < p->n_rotations; c++)
        TRY(array_resize(&p->omega_rest[c], sizeof(float), (size_t)p->count, 0));
    return STATUS_OK;
}

int particles_view_columns(const struct particles *p)
{
    return VIEW_COLUMNS(p->dimension, frictional(p), p->mixed);
}

size_t particles_view_at(const struct particles *p, int i)
{
    return COLUMN_AT(particles_view_columns(p), i);
}

/* The columns' places, one after the other. */
static enum status views_init(struct particles *p)
{
    const size_t real = p->mixed ? sizeof(float) : sizeof(double);
    TRY(array_resize(&p->view, real, (size_t)particles_view_columns(p) * (size_t)p->n_padded, 0));
    char *next = p->view;
    for (int c = 0; p->mixed && c < p->dimension; c++, next += PARTICLES_BLOCK * real)
        p->view_u[c] = (int32_t *)(void *)next;
    for (int c = 0; c < p->dimension; c++, next += PARTICLES_BLOCK * real)
        p->view_v[c] = next;
    for (int c = 0; c < p->n_rotations; c++, next += PARTICLES_BLOCK * real)
        p->view_omega[c] = next;
    for (int c = 0; frictional(p) && c < LAG_COLUMNS(p->dimension, p->mixed); c++, next += PARTICLES_BLOCK * real)
        p->view_lag[c] = next;
    p->view_radius = frictional(p) ? next : NULL;
    return STATUS_OK;
}

static enum status records_init(struct particles *p)
{
    const size_t stride = RECORD_STRIDE(p->dimension, frictional(p), p->mixed);
    const size_t real = p->mixed ? sizeof(float) : sizeof(double);
    p->n_padded = (p->count + ARRAY_PADDING - 1) / ARRAY_PADDING * ARRAY_PADDING + paddings(p) * ARRAY_PADDING;
    p->n_rows = p->n_padded;
    TRY(array_resize(&p->record, stride * sizeof(double), (size_t)p->n_padded, 0));
    TRY(array_resize(&p->force, 1, particles_force_size(p), 0));
    TRY(views_init(p));
    TRY(rests_init(p));
    for (int k = 0; !p->mixed && k < ARRAY_PADDING; k++) /* no two behind the last particle at one place */
        p->x[0][p->count + k] = p->x_list[0][p->count + k] = -1e6 * (k + 1);
    for (int k = 0; k < paddings(p); k++)
        pad_row(p, particles_spare_padding(p, k));
    TRY(array_resize(&p->view_inv_mass, real, (size_t)p->count, 0));
    TRY(array_resize(&p->view_minus_lever, real, (size_t)p->count, 0));
    particles_set_views(p, 0);
    return STATUS_OK;
}

enum status particles_init(struct particles *p, int count, int dimension, bool rotations, bool mixed)
{
    memset(p, 0, sizeof *p);
    p->count = count;
    p->dimension = dimension;
    p->n_rotations = rotations ? ROTATIONS(dimension) : 0;
    TRY(array_resize(&p->id, sizeof *p->id, (size_t)count, 0));
    TRY(array_resize(&p->slot, sizeof *p->slot, (size_t)count, 0));
    for (int i = 0; i < count; i++)
        p->id[i] = p->slot[i] = i;
    p->mixed = mixed;
    p->speed_unit = p->force_unit = 1;
    TRY(components_resize(p->x, dimension, count));
    TRY(components_resize(p->v, dimension, count));
    TRY(components_resize(p->a, dimension, count));
    TRY(components_resize(p->x_list, dimension, count));
    TRY(components_resize(p->omega, p->n_rotations, count));
    TRY(components_resize(p->alpha, p->n_rotations, count));
    TRY(components_resize(&p->radius, 1, count));
    TRY(components_resize(&p->mass, 1, count));
    TRY(components_resize(&p->inv_mass, 1, count));
    if (rotations)
        TRY(components_resize(&p->inv_inertia, 1, count));
    return records_init(p);
}

size_t particles_force_size(const struct particles *p)
{
    size_t columns = (size_t)(p->dimension + p->n_rotations) * (p->mixed ? sizeof(float) : sizeof(double));
    return PARTICLES_COLUMNS_OFFSET(p->n_rows, p->dimension, frictional(p), p->mixed) + columns * (size_t)p->n_padded;
}

enum status particles_reserve_rows(struct particles *p, int rows)
{
    const size_t record = sizeof(double) * RECORD_STRIDE(p->dimension, frictional(p), p->mixed),
                 sums = SUMS_BYTES(p->dimension, frictional(p), p->mixed);
    const int before = p->n_padded;
    if (rows <= p->n_rows)
        return STATUS_OK;
    p->n_rows = rows + rows / 16;
    TRY(array_resize(&p->record, record, (size_t)p->n_rows, (size_t)before));
    return array_resize(&p->force, 1, particles_force_size(p), sums * (size_t)before);
}

void particles_start_rows(struct particles *p, int row, int count)
{
    const size_t sums = SUMS_BYTES(p->dimension, frictional(p), p->mixed);
    memset((char *)p->force + sums * (size_t)row, 0, sums * (size_t)count);
    pad_row(p, row + count - 1);
}

/* Another core may have what is read: records and sums are asked for so many turns before. Who adds does not write to
 * the copies: their lines stay with the core that does. */
enum { COPIES_AHEAD = 24 };

static inline __attribute__((always_inline)) void copy_records(void *records, const size_t bytes, int to,
                                                               const int32_t *of, int count)
{
    char *record = records;
    for (int k = 0; k < count; k++) {
        if (k + COPIES_AHEAD < count)
            __builtin_prefetch(record + bytes * (size_t)of[k + COPIES_AHEAD]);
        memcpy(record + bytes * (size_t)(to + k), record + bytes * (size_t)of[k], bytes);
    }
}

void particles_copy_rows(struct particles *p, int to, const int32_t *of, int count)
{
    const size_t bytes = sizeof(double) * RECORD_STRIDE(p->dimension, frictional(p), p->mixed);
    const size_t sums = SUMS_BYTES(p->dimension, frictional(p), p->mixed);
    memset((char *)p->force + sums * (size_t)to, 0, sums * (size_t)count);
    if (bytes == 16)
        copy_records(p->record, 16, to, of, count);
    else if (bytes == 32)
        copy_records(p->record, 32, to, of, count);
    else if (bytes == 64)
        copy_records(p->record, 64, to, of, count);
    else if (bytes == 128)
        copy_records(p->record, 128, to, of, count);
    else
        copy_records(p->record, bytes, to, of, count);
}

#define DEFINE_ADD_ROWS(real)                                                                                          \
    static inline __attribute__((always_inline)) void add_##real##_rows(                                               \
        real *sums, const size_t width, const int32_t *of, const int32_t *copy, int count)                             \
    {                                                                                                                  \
        for (int k = 0; k < count; k++) {                                                                              \
            real *restrict to = sums + width * (size_t)of[k];                                                          \
            const real *restrict from = sums + width * (size_t)copy[k];                                                \
            if (k + COPIES_AHEAD < count)                                                                              \
                __builtin_prefetch(sums + width * (size_t)copy[k + COPIES_AHEAD]);                                     \
            for (size_t c = 0; c < width; c++)                                                                         \
                to[c] += from[c];                                                                                      \
        }                                                                                                              \
    }
DEFINE_ADD_ROWS(double)
DEFINE_ADD_ROWS(float)

void particles_add_rows(struct particles *p, const int32_t *of, const int32_t *copy, int count)
{
    const size_t width =
        (size_t)SUMS_BYTES(p->dimension, frictional(p), p->mixed) / (p->mixed ? sizeof(float) : sizeof(double));
    if (p->mixed && width == 8)
        add_float_rows(p->force, 8, of, copy, count);
    else if (p->mixed)
        add_float_rows(p->force, width, of, copy, count);
    else if (width == 8)
        add_double_rows(p->force, 8, of, copy, count);
    else
        add_double_rows(p->force, width, of, copy, count);
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
        free(p->u_rest[c]);
        free(p->v_rest[c]);
        free(p->omega_rest[c]);
    }
    free(p->id);
    free(p->slot);
    free(p->view_inv_mass);
    free(p->view_minus_lever);
    free(p->view);
    free(p->record);
    free(p->force);
    free(p->radius);
    free(p->mass);
    free(p->inv_mass);
    free(p->inv_inertia);
    memset(p, 0, sizeof *p);
}

static void view(const struct particles *p, void *array, size_t at, double value)
{
    if (p->mixed)
        ((float *)array)[at] = (float)value;
    else
        ((double *)array)[at] = value;
}

static double power_of_2(double value)
{
    int exponent = 0;
    (void)frexp(value, &exponent);
    return ldexp(1, exponent);
}

static double mean(const double *values, int count)
{
    double sum = 0;
    for (int i = 0; i < count; i++)
        sum += values[i];
    return sum / count;
}

void particles_set_units(struct particles *p, double time_s)
{
    const double radius_m = mean(p->radius, p->count), mass_kg = mean(p->mass, p->count);
    if (!p->mixed || !(radius_m > 0 && mass_kg > 0 && time_s > 0))
        return;
    p->speed_unit = power_of_2(radius_m / time_s);
    p->force_unit = power_of_2(mass_kg * radius_m / (time_s * time_s));
}

void particles_set_views(struct particles *p, double skin)
{
    const double per_force = p->force_unit / p->speed_unit;
    int exponent = 0;
    (void)frexp(skin > 0 ? skin : 1, &exponent);
    p->quantum = ldexp(1, exponent - 29);
    for (int i = 0; i < p->count; i++) {
        view(p, p->view_inv_mass, (size_t)i, p->inv_mass[i] * per_force);
        if (!frictional(p))
            continue;
        view(p, p->view_radius, particles_view_at(p, i), p->radius[i]);
        view(p, p->view_minus_lever, (size_t)i, -p->radius[i] * p->inv_inertia[i] * per_force);
    }
}

/* Single: the records and views say that every particle is where it was listed. */
static void set_home(struct particles *p)
{
    const size_t stride = RECORD_STRIDE(p->dimension, frictional(p), true);
    const size_t bytes = (size_t)p->dimension * sizeof(int32_t);
    for (int c = 0; p->mixed && c < p->dimension; c++) {
        for (int i = 0; i < p->count; i++)
            p->view_u[c][particles_view_at(p, i)] = 0;
        memset(p->u_rest[c], 0, (size_t)p->count * sizeof(float));
    }
    for (int i = 0; p->mixed && i < p->count; i++)
        memset((double *)p->record + (size_t)i * stride, 0, bytes);
}

void particles_mark_listed(struct particles *p, double skin)
{
    for (int c = 0; c < p->dimension; c++)
        memcpy(p->x_list[c], p->x[c], (size_t)p->count * sizeof(double));
    particles_set_views(p, skin);
    set_home(p);
}

/* The nearest float in units, and what it leaves. */
static void split(const struct particles *p, const double *values, float *nearest, float *rest)
{
    for (int i = 0; i < p->count; i++) {
        const double value = values[i] / p->speed_unit;
        const float near = (float)value;
        nearest[particles_view_at(p, i)] = near;
        rest[i] = (float)(value - (double)near);
    }
}

void particles_import_state(struct particles *p)
{
    for (int c = 0; p->mixed && c < p->dimension; c++) {
        split(p, p->v[c], p->view_v[c], p->v_rest[c]);
        for (int i = 0; i < p->count; i++) {
            double u = (p->x[c][i] - p->x_list[c][i]) / p->quantum, whole = nearbyint(u);
            p->view_u[c][particles_view_at(p, i)] = (int32_t)whole;
            p->u_rest[c][i] = (float)(u - whole);
        }
    }
    for (int c = 0; p->mixed && c < p->n_rotations; c++)
        split(p, p->omega[c], p->view_omega[c], p->omega_rest[c]);
}

/* One component; a block of a column at a time, as these lie apart. */
static void export_component(struct particles *p, int c)
{
    const double quantum = p->quantum;
    for (int from = 0; from < p->count; from += PARTICLES_BLOCK) {
        const int n = p->count - from < PARTICLES_BLOCK ? p->count - from : PARTICLES_BLOCK;
        const int32_t *u = p->view_u[c] + particles_view_at(p, from);
        const float *rest = p->u_rest[c] + from;
        const double *listed = p->x_list[c] + from;
        double *x = p->x[c] + from;
        for (int k = 0; k < n; k++)
            x[k] = listed[k] + quantum * ((double)u[k] + (double)rest[k]);
    }
}

void particles_export_positions(struct particles *p)
{
    for (int c = 0; p->mixed && c < p->dimension; c++)
        export_component(p, c);
}

double particles_velocity(const struct particles *p, int c, int i)
{
    return p->mixed ? p->speed_unit * (double)((const float *)p->view_v[c])[particles_view_at(p, i)] : p->v[c][i];
}

double particles_moved2_m2(const struct particles *p, int i)
{
    double moved2 = 0;
    for (int c = 0; c < p->dimension; c++) {
        double moved = p->mixed ? p->quantum * p->view_u[c][particles_view_at(p, i)] : p->x[c][i] - p->x_list[c][i];
        moved2 += moved * moved;
    }
    return moved2;
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
