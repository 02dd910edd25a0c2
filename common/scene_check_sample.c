/* The sample: checks between its keys, the files it names, and what follows from them. */
#include <inttypes.h>
#include <libgen.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/grain_file.h"
#include "common/scene_check.h"

/* Least part of a Gaussian between its cut-offs. */
static const double GAUSSIAN_PART = 1e-3;

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

/* Cut so narrowly, a distribution is drawn from for ever. */
static double gaussian_part(const struct scene_sample *s)
{
    double scale = 1 / (s->radius_sd_m * sqrt(2));
    return 0.5 *
           (erf((s->radius_max_m - s->radius_mean_m) * scale) - erf((s->radius_min_m - s->radius_mean_m) * scale));
}

static enum status gaussian_check(const struct scene_sample *s, const config_setting_t *at)
{
    if (!(s->radius_sd_m > 0 && s->radius_mean_m >= s->radius_min_m && s->radius_mean_m <= s->radius_max_m))
        return config_fail(at, "sample",
                           "gaussian radii need radius_sd_m above 0 and radius_mean_m between the cut-offs");
    if (!(gaussian_part(s) >= GAUSSIAN_PART))
        return config_fail(at, "sample",
                           "gaussian radii: only %g of them lie between radius_min_m and radius_max_m; allowed: at "
                           "least %g. For one size, or a narrow range, take radius_distribution = \"uniform\"",
                           gaussian_part(s), GAUSSIAN_PART);
    return STATUS_OK;
}

static enum status radii_check(const struct scene_sample *s, const config_setting_t *at)
{
    if (s->radius_min_m == 0 || s->radius_max_m == 0)
        return config_fail(at, "sample", "%s: missing; only initial = \"file\" says it otherwise",
                           s->radius_min_m == 0 ? "radius_min_m" : "radius_max_m");
    if (s->radius_max_m < s->radius_min_m)
        return config_fail(at, "sample", "radius_max_m (%g) must be at least radius_min_m (%g)", s->radius_max_m,
                           s->radius_min_m);
    return s->radius_distribution == RADIUS_GAUSSIAN ? gaussian_check(s, at) : STATUS_OK;
}

/* Of the distribution as it is drawn from; a cut Gaussian as if it were not cut. */
static void radii_moments(struct scene_sample *s)
{
    const double lo = s->radius_min_m, hi = s->radius_max_m, sd = s->radius_sd_m;
    if (s->radius_distribution == RADIUS_GAUSSIAN) {
        s->mean_radius_m = s->radius_mean_m;
        s->mean_cube_m3 = s->radius_mean_m * (s->radius_mean_m * s->radius_mean_m + 3 * sd * sd);
        return;
    }
    s->mean_radius_m = 0.5 * (lo + hi);
    s->mean_cube_m3 = 0.25 * (lo + hi) * (lo * lo + hi * hi); /* (hi^4 - lo^4)/(4 (hi - lo)) */
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
    TRY(radii_check(s, at));
    radii_moments(s);
    if (s->initial != INITIAL_CHECKPOINT)
        return STATUS_OK;
    if (!s->checkpoint[0])
        return config_fail(at, "sample", "initial = \"checkpoint\" needs the path in checkpoint");
    return path ? path_resolve(path, s->checkpoint, at, "checkpoint") : STATUS_OK;
}
