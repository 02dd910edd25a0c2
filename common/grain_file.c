#include "common/grain_file.h"

#include <math.h>

static const char *const names[GRAIN_COLUMNS] = {"x",  "y",       "z",       "radius",  "vx",     "vy",
                                                 "vz", "omega_x", "omega_y", "omega_z", "density"};
static const double RADIUS_MIN_M = 1e-9, RADIUS_MAX_M = 1e3, FAR = 1e9;

static enum status row_check(const struct csv_table *table, const char *path, int64_t row, int dimension)
{
    static const enum grain_column out_of_plane[] = {GRAIN_Y, GRAIN_VY, GRAIN_OMEGA_X, GRAIN_OMEGA_Z};
    const int line = table->line[row];
    const double radius = csv_value(table, row, GRAIN_RADIUS);
    if (!(radius >= RADIUS_MIN_M && radius <= RADIUS_MAX_M))
        return status_fail(STATUS_CONFIG, "%s:%d: radius: %g is out of range; allowed: %g to %g m", path, line, radius,
                           RADIUS_MIN_M, RADIUS_MAX_M);
    if (table->has[GRAIN_DENSITY] && !(csv_value(table, row, GRAIN_DENSITY) > 0))
        return status_fail(STATUS_CONFIG, "%s:%d: density: %g; allowed: above 0", path, line,
                           csv_value(table, row, GRAIN_DENSITY));
    for (int c = 0; c < GRAIN_COLUMNS; c++)
        if (!(fabs(csv_value(table, row, c)) <= FAR))
            return status_fail(STATUS_CONFIG, "%s:%d: %s: %g is out of range; allowed: -%g to %g", path, line, names[c],
                               csv_value(table, row, c), FAR, FAR);
    for (int k = 0; k < 4 && dimension == 2; k++)
        if (csv_value(table, row, (int)out_of_plane[k]) != 0)
            return status_fail(STATUS_CONFIG, "%s:%d: %s: %g; allowed in 2D: 0 (the plane is that of x and z)", path,
                               line, names[out_of_plane[k]], csv_value(table, row, (int)out_of_plane[k]));
    return STATUS_OK;
}

enum status grain_file_read(struct csv_table *table, const char *path, int dimension)
{
    struct csv_format format = {names, GRAIN_COLUMNS, 1U << GRAIN_X | 1U << GRAIN_Z | 1U << GRAIN_RADIUS, GRAINS_MAX};
    if (dimension == 3)
        format.required |= 1U << GRAIN_Y;
    TRY(csv_table_read(table, path, &format));
    enum status status = STATUS_OK;
    for (int64_t row = 0; row < table->rows && status == STATUS_OK; row++)
        status = row_check(table, path, row, dimension);
    if (status != STATUS_OK)
        csv_table_free(table);
    return status;
}
