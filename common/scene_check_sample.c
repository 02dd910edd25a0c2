/* The sample: checks between its keys, the files it names, and what follows from them. */
#include <inttypes.h>
#include <libgen.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/grain_file.h"
#include "common/scene_check.h"
#include "common/size_distribution.h"

/* Least part of a distribution between its cut-offs: cut more narrowly, it is drawn from for ever. */
static const double LEAST_PART = 1e-3;

/* Paths in a scene are relative to the scene file. */
static enum status path_resolve(const char *scene, char *path, const config_setting_t *at, const char *key)
{
    char copy[1024], joined[1024];
    if (!path[0] || path[0] == '/')
        return STATUS_OK;
    snprintf(copy, sizeof copy, "%s", scene);
    int length = snprintf(joined, sizeof joined, "%s/%s", dirname(copy), path);
    if (length >= CONFIG_STRING_MAX)
        return config_fail(at, "sample", "%s: '%s' is too long", key, joined);
    memcpy(path, joined, (size_t)length + 1);
    return STATUS_OK;
}

/* Records and the scenes of studies name the file from other folders. */
static enum status path_make_absolute(char *path, const config_setting_t *at, const char *key)
{
    char *real = realpath(path, NULL);
    enum status status = STATUS_OK;
    if (real && strlen(real) >= CONFIG_STRING_MAX)
        status = config_fail(at, "sample", "%s: '%s' is too long", key, real);
    else if (real)
        memcpy(path, real, strlen(real) + 1);
    free(real); /* none: reading says what is wrong */
    return status;
}

/* --- Grains from a file --- */

static enum status radii_take(struct scene_sample *s, const struct csv_table *table, const config_setting_t *at)
{
    double least = INFINITY, largest = 0, sum = 0, cubes = 0;
    for (int64_t k = 0; k < table->rows; k++) {
        const double a = csv_value(table, k, GRAIN_RADIUS);
        least = fmin(least, a);
        largest = fmax(largest, a);
        sum += a;
        cubes += a * a * a;
    }
    if ((s->radius_min_m != 0 && s->radius_min_m != least) || (s->radius_max_m != 0 && s->radius_max_m != largest))
        return config_fail(at, "sample",
                           "radius_min_m and radius_max_m are those of the file, %g and %g; they need not "
                           "be given",
                           least, largest);
    s->radius_min_m = least;
    s->radius_max_m = largest;
    s->mean_radius_m = sum / (double)table->rows;
    s->mean_cube_m3 = cubes / (double)table->rows;
    return STATUS_OK;
}

static enum status table_take(struct scene_sample *s, const struct csv_table *table, const config_setting_t *at)
{
    char hash[20];
    snprintf(hash, sizeof hash, "%016" PRIx64, table->hash);
    if (s->file_hash[0] && strcmp(s->file_hash, hash) != 0)
        return config_fail(at, "sample", "%s has the hash %s, not file_hash = \"%s\": its content is another", s->file,
                           hash, s->file_hash);
    memcpy(s->file_hash, hash, strlen(hash) + 1);
    if (s->count != 0 && s->count != table->rows)
        return config_fail(at, "sample", "count = %lld, but %s holds %lld grains", (long long)s->count, s->file,
                           (long long)table->rows);
    s->count = table->rows;
    return radii_take(s, table, at);
}

static enum status box_check(const struct scene *scene, const config_setting_t *at)
{
    const struct config_floats *lo = &scene->sample.box_min_m, *hi = &scene->sample.box_max_m;
    const struct config_floats *both[] = {lo, hi};
    for (int k = 0; k < 2; k++)
        if (both[k]->count != 0 && both[k]->count != scene->dimension)
            return config_fail(at, "sample", "%s must have %d members, %s, or none", k ? "box_max_m" : "box_min_m",
                               (int)scene->dimension, scene->dimension == 2 ? "[x, z]" : "[x, y, z]");
    for (int c = 0; c < lo->count && c < hi->count; c++)
        if (!(hi->value[c] > lo->value[c]))
            return config_fail(at, "sample", "box_max_m (%g) must be above box_min_m (%g)", hi->value[c], lo->value[c]);
    return STATUS_OK;
}

static enum status file_take(struct scene *scene, const char *path, const config_setting_t *at)
{
    struct scene_sample *s = &scene->sample;
    struct csv_table table;
    if (!s->file[0])
        return config_fail(at, "sample", "initial = \"file\" needs the path of a table in file");
    if (s->speed_m_per_s > 0)
        return config_fail(at, "sample", "speed_m_per_s: velocities are those of the file (vx, vy, vz)");
    TRY(box_check(scene, at));
    if (!path)
        return STATUS_OK;
    TRY(path_resolve(path, s->file, at, "file"));
    TRY(path_make_absolute(s->file, at, "file"));
    TRY(grain_file_read(&table, s->file, (int)scene->dimension));
    enum status status = table_take(s, &table, at);
    csv_table_free(&table);
    return status;
}

/* --- Radii that are drawn --- */

static enum status cut_check(const struct scene_sample *s, const char *name, const config_setting_t *at)
{
    if (size_part_within(s) >= LEAST_PART)
        return STATUS_OK;
    return config_fail(at, "sample",
                       "%s radii: only %g of them lie between radius_min_m and radius_max_m; allowed: at "
                       "least %g. For one size, or a narrow range, take size_distribution = \"uniform\"",
                       name, size_part_within(s), LEAST_PART);
}

static enum status gaussian_check(const struct scene_sample *s, const config_setting_t *at)
{
    if (!(s->radius_sd_m > 0 && s->radius_mean_m >= s->radius_min_m && s->radius_mean_m <= s->radius_max_m))
        return config_fail(at, "sample",
                           "gaussian radii need radius_sd_m above 0 and radius_mean_m between the cut-offs");
    return cut_check(s, "gaussian", at);
}

static enum status lognormal_check(const struct scene_sample *s, const config_setting_t *at)
{
    if (!(s->radius_log_sd > 0 && s->radius_median_m > 0))
        return config_fail(at, "sample", "lognormal radii need radius_median_m and radius_log_sd above 0");
    return cut_check(s, "lognormal", at);
}

static enum status radii_check(const struct scene_sample *s, const config_setting_t *at)
{
    if (s->radius_min_m == 0 || s->radius_max_m == 0)
        return config_fail(at, "sample", "%s: missing; only a table says it otherwise",
                           s->radius_min_m == 0 ? "radius_min_m" : "radius_max_m");
    if (s->radius_max_m < s->radius_min_m)
        return config_fail(at, "sample", "radius_max_m (%g) must be at least radius_min_m (%g)", s->radius_max_m,
                           s->radius_min_m);
    if (s->radius_distribution == RADIUS_LOGNORMAL)
        return lognormal_check(s, at);
    return s->radius_distribution == RADIUS_GAUSSIAN ? gaussian_check(s, at) : STATUS_OK;
}

/* --- Grading curves --- */

/* The file becomes the two lists. */
static enum status size_table_read(struct scene_sample *s, const char *path, const config_setting_t *at)
{
    static const char *const names[] = {"diameter", "passing"};
    const struct csv_format format = {names, 2, 3, CONFIG_FLOATS_MAX};
    struct csv_table table;
    if (s->diameters_m.count > 0 || s->passing_by_mass.count > 0)
        return config_fail(at, "sample", "size_table, and diameters_m with passing_by_mass, say the same: one of them");
    TRY(path_resolve(path, s->size_table, at, "size_table"));
    TRY(csv_table_read(&table, s->size_table, &format));
    for (int64_t k = 0; k < table.rows; k++) {
        s->diameters_m.value[k] = csv_value(&table, k, 0);
        s->passing_by_mass.value[k] = csv_value(&table, k, 1);
    }
    s->diameters_m.count = s->passing_by_mass.count = table.rows;
    memset(s->size_table, 0, sizeof s->size_table);
    csv_table_free(&table);
    return STATUS_OK;
}

static enum status size_table_check(const struct scene_sample *s, const config_setting_t *at)
{
    const struct config_floats *d = &s->diameters_m, *m = &s->passing_by_mass;
    if (d->count < 2 || d->count != m->count)
        return config_fail(
            at, "sample", "a grading curve needs diameters_m and passing_by_mass, two or more of each (here %d and %d)",
            (int)d->count, (int)m->count);
    if (m->value[0] != 0 || m->value[m->count - 1] != 1)
        return config_fail(at, "sample", "passing_by_mass goes from %g to %g; allowed: from 0 to 1", m->value[0],
                           m->value[m->count - 1]);
    for (int k = 0; k < d->count; k++) {
        if (!(d->value[k] >= 2e-9 && d->value[k] <= 2e3))
            return config_fail(at, "sample", "diameter %g is out of range; allowed: 2e-09 to 2000 m", d->value[k]);
        if (k > 0 && !(d->value[k] > d->value[k - 1] && m->value[k] >= m->value[k - 1]))
            return config_fail(at, "sample",
                               "grading curve: (%g m, %g) comes after (%g m, %g); allowed: increasing diameters, and "
                               "passing that does not fall",
                               d->value[k], m->value[k], d->value[k - 1], m->value[k - 1]);
    }
    return STATUS_OK;
}

/* Sieves that nothing passes, or all, are no bounds of the radii. */
static enum status size_table_take(struct scene_sample *s, const char *path, const config_setting_t *at)
{
    if (s->size_table[0] && path)
        TRY(size_table_read(s, path, at));
    TRY(size_table_check(s, at));
    const struct config_floats *d = &s->diameters_m, *m = &s->passing_by_mass;
    int first = 0, last = (int)d->count - 1;
    while (m->value[first + 1] == 0)
        first++;
    while (m->value[last - 1] == 1)
        last--;
    const double least = 0.5 * d->value[first], largest = 0.5 * d->value[last];
    if ((s->radius_min_m != 0 && s->radius_min_m != least) || (s->radius_max_m != 0 && s->radius_max_m != largest))
        return config_fail(at, "sample",
                           "radius_min_m and radius_max_m are those of the grading curve, %g and %g; they need not be "
                           "given",
                           least, largest);
    s->radius_min_m = least;
    s->radius_max_m = largest;
    return STATUS_OK;
}

enum status scene_check_sample(struct scene *scene, const char *path, const config_setting_t *at)
{
    struct scene_sample *s = &scene->sample;
    if (s->initial == INITIAL_FILE)
        TRY(file_take(scene, path, at));
    if (s->initial == INITIAL_FILE && path)
        return STATUS_OK;
    if (s->count < 1)
        return config_fail(at, "sample", "count: missing; the number of particles");
    if (s->radius_distribution == RADIUS_TABLE && s->initial != INITIAL_FILE)
        TRY(size_table_take(s, path, at));
    TRY(radii_check(s, at));
    size_moments_set(s);
    if (s->initial != INITIAL_CHECKPOINT)
        return STATUS_OK;
    if (!s->checkpoint[0])
        return config_fail(at, "sample", "initial = \"checkpoint\" needs the path in checkpoint");
    return path ? path_resolve(path, s->checkpoint, at, "checkpoint") : STATUS_OK;
}
