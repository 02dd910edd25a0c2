#include "common/size_distribution.h"

#include <math.h>

static double phi(double x)
{
    return 0.5 * erfc(-x / sqrt(2));
}

/* Part of the k-th moment of a lognormal distribution between the cut-offs, over that of the whole. */
static double lognormal_part(const struct scene_sample *s, int k)
{
    const double sd = s->radius_log_sd, middle = log(s->radius_median_m) + k * sd * sd;
    return phi((log(s->radius_max_m) - middle) / sd) - phi((log(s->radius_min_m) - middle) / sd);
}

double size_part_within(const struct scene_sample *s)
{
    if (s->radius_distribution == RADIUS_LOGNORMAL)
        return lognormal_part(s, 0);
    return phi((s->radius_max_m - s->radius_mean_m) / s->radius_sd_m) -
           phi((s->radius_min_m - s->radius_mean_m) / s->radius_sd_m);
}

static double lognormal_moment(const struct scene_sample *s, int k)
{
    const double whole = pow(s->radius_median_m, k) * exp(0.5 * k * k * s->radius_log_sd * s->radius_log_sd);
    return whole * lognormal_part(s, k) / lognormal_part(s, 0);
}

/* --- Tables --- */

/* Class c: between diameters c and c + 1. Its mass lies evenly in ln(d), so that the number of particles of mass 1 for
 * d = 1 between d and D is slope/3 (d^-3 - D^-3). */
static double slope_of(const struct scene_sample *s, int c)
{
    return (s->passing_by_mass.value[c + 1] - s->passing_by_mass.value[c]) /
           log(s->diameters_m.value[c + 1] / s->diameters_m.value[c]);
}

/* Integral over class c, from its start to d, of d^-power against mass. */
static double class_part(const struct scene_sample *s, int c, double d, int power)
{
    return slope_of(s, c) / power * (pow(s->diameters_m.value[c], -power) - pow(d, -power));
}

static double table_integral(const struct scene_sample *s, int power)
{
    double sum = 0;
    for (int c = 0; c + 1 < s->diameters_m.count; c++)
        sum += class_part(s, c, s->diameters_m.value[c + 1], power);
    return sum;
}

double size_table_passing(const struct scene_sample *s, double diameter_m)
{
    int c = 0;
    if (diameter_m <= s->diameters_m.value[0])
        return 0;
    while (c + 2 < s->diameters_m.count && diameter_m > s->diameters_m.value[c + 1])
        c++;
    return fmin(1, s->passing_by_mass.value[c] + slope_of(s, c) * log(diameter_m / s->diameters_m.value[c]));
}

/* Where `number` particles of the curve are finer. */
static double diameter_of_number(const struct scene_sample *s, double number)
{
    int c = 0;
    for (; c + 2 < s->diameters_m.count; c++) {
        const double part = class_part(s, c, s->diameters_m.value[c + 1], 3);
        if (number < part)
            break;
        number -= part;
    }
    const double slope = slope_of(s, c), last = s->diameters_m.value[c + 1];
    const double inverse = slope > 0 ? pow(s->diameters_m.value[c], -3) - 3 * number / slope : 0;
    return inverse > pow(last, -3) ? pow(inverse, -1.0 / 3) : last;
}

double size_table_radius_m(const struct scene_sample *s, int64_t k, int64_t count)
{
    const double part = table_integral(s, 3) / (double)count;
    const double low = k == 0 ? s->diameters_m.value[0] : diameter_of_number(s, (double)k * part);
    const double high = k == count - 1 ? 2 * s->radius_max_m : diameter_of_number(s, (double)(k + 1) * part);
    const double cube = (size_table_passing(s, high) - size_table_passing(s, low)) / part;
    return 0.5 * fmin(high, fmax(low, cbrt(cube)));
}

double size_table_diameter_m(const struct scene_sample *s, double passing)
{
    int c = 0;
    while (c + 2 < s->diameters_m.count && passing > s->passing_by_mass.value[c + 1])
        c++;
    const double slope = slope_of(s, c);
    return s->diameters_m.value[c] * (slope > 0 ? exp((passing - s->passing_by_mass.value[c]) / slope) : 1);
}

void size_moments_set(struct scene_sample *s)
{
    const double lo = s->radius_min_m, hi = s->radius_max_m, sd = s->radius_sd_m;
    switch (s->radius_distribution) {
    case RADIUS_GAUSSIAN:
        s->mean_radius_m = s->radius_mean_m;
        s->mean_cube_m3 = s->radius_mean_m * (s->radius_mean_m * s->radius_mean_m + 3 * sd * sd);
        break;
    case RADIUS_LOGNORMAL:
        s->mean_radius_m = lognormal_moment(s, 1);
        s->mean_cube_m3 = lognormal_moment(s, 3);
        break;
    case RADIUS_TABLE:
        s->mean_radius_m = 0.5 * table_integral(s, 2) / table_integral(s, 3);
        s->mean_cube_m3 = 0.125 / table_integral(s, 3);
        break;
    default:
        s->mean_radius_m = 0.5 * (lo + hi);
        s->mean_cube_m3 = 0.25 * (lo + hi) * (lo * lo + hi * hi); /* (hi^4 - lo^4)/(4 (hi - lo)) */
        break;
    }
}
