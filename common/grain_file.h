/* A sample's grains in a table: CSV with a line of names, SI units. */
#ifndef SHAKEDOWN_COMMON_GRAIN_FILE_H
#define SHAKEDOWN_COMMON_GRAIN_FILE_H

#include "common/csv_table.h"

enum grain_column {
    GRAIN_X, /* m */
    GRAIN_Y,
    GRAIN_Z,
    GRAIN_RADIUS, /* m */
    GRAIN_VX,     /* m/s */
    GRAIN_VY,
    GRAIN_VZ,
    GRAIN_OMEGA_X, /* rad/s */
    GRAIN_OMEGA_Y,
    GRAIN_OMEGA_Z,
    GRAIN_DENSITY, /* kg/m^3; 0: that of the scene */
    GRAIN_COLUMNS
};

enum { GRAINS_MAX = 10000000 };

/* Reads the table of a scene of this dimension. In 2D nothing lies or moves out of the plane: y, vy, omega_x and
 * omega_z may be missing, or are 0. Errors: as of csv_table_read; STATUS_CONFIG for radii out of range. */
enum status grain_file_read(struct csv_table *table, const char *path, int dimension) MUST_USE;

#endif
