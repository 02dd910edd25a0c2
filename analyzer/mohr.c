#include "analyzer/mohr.h"

#include <errno.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analyzer/report_json.h"

static const double degrees = 180 / M_PI;
static const double spread_min = 0.05;

static double centre(const struct mohr_circle *circle)
{
    return (circle->major_pa.value + circle->minor_pa.value) / 2;
}

static double radius(const struct mohr_circle *circle)
{
    return (circle->major_pa.value - circle->minor_pa.value) / 2;
}

/* Variance of t - m s: both come from the same two stresses, t - m s = major (1 - m)/2 - minor (1 + m)/2. NaN without
 * uncertainties. */
static double variance(const struct mohr_circle *circle, double m)
{
    const double a = circle->major_pa.error * (1 - m) / 2, b = circle->minor_pa.error * (1 + m) / 2;
    return a * a + b * b;
}

static bool has_errors(const struct mohr_circle *circle, size_t n)
{
    for (size_t k = 0; k < n; k++)
        if (!(variance(&circle[k], 0) > 0))
            return false;
    return true;
}

/* Polynomial of t over s/scale by weighted least squares: coefficients and their covariance, without the scatter. */
struct line {
    double c[3], covariance[9], chi_square;
};

static bool line_fit(struct line *line, const struct mohr_circle *circle, size_t n, size_t columns, double scale,
                     double m, bool weighted)
{
    gsl_matrix *x = gsl_matrix_alloc(n, columns);
    gsl_vector *y = gsl_vector_alloc(n), *w = gsl_vector_alloc(n);
    gsl_multifit_linear_workspace *room = gsl_multifit_linear_alloc(n, columns);
    gsl_vector_view c = gsl_vector_view_array(line->c, columns);
    gsl_matrix_view covariance = gsl_matrix_view_array(line->covariance, columns, columns);
    bool good = x && y && w && room;
    for (size_t k = 0; good && k < n; k++) {
        for (size_t d = 0; d < columns; d++)
            gsl_matrix_set(x, k, d, pow(centre(&circle[k]) / scale, (double)d));
        gsl_vector_set(y, k, radius(&circle[k]));
        gsl_vector_set(w, k, weighted ? 1 / variance(&circle[k], m) : 1);
    }
    good = good && gsl_multifit_wlinear(x, w, y, &c.vector, &covariance.matrix, &line->chi_square, room) == 0;
    gsl_matrix_free(x);
    gsl_vector_free(y);
    gsl_vector_free(w);
    gsl_multifit_linear_free(room);
    return good;
}

/* phi = asin m, c = a/sqrt(1 - m^2), to first order: covariance [2][2] of (a, m). */
static void angle_and_cohesion(double a, double m, const double *covariance, double factor, struct estimate *angle,
                               struct estimate *cohesion)
{
    const double cosine = sqrt(1 - m * m), by_m = a * m / (cosine * cosine * cosine);
    const double square =
        covariance[0] / (cosine * cosine) + by_m * by_m * covariance[3] + 2 * by_m / cosine * covariance[1];
    *angle = (struct estimate){asin(m) * degrees, factor * sqrt(covariance[3]) / cosine * degrees};
    *cohesion = (struct estimate){a / cosine, factor * sqrt(fmax(0, square))};
}

static void curvature(struct mohr *mohr, const struct mohr_circle *circle, size_t n, double scale, double m,
                      bool weighted)
{
    struct line line;
    mohr->curvature_known = n >= 4 && line_fit(&line, circle, n, 3, scale, m, weighted);
    if (!mohr->curvature_known)
        return;
    const double dof = (double)n - 3, scatter = sqrt(line.chi_square / dof);
    const double factor = weighted ? fmax(1, scatter) : scatter; /* the circles' own errors count as well */
    mohr->curved = fabs(line.c[2]) > 2 * factor * statistics_widening(dof) * sqrt(line.covariance[8]);
    mohr->curvature_pa = scale * scale / (2 * line.c[2]);
}

bool mohr_fit(struct mohr *mohr, const struct mohr_circle *circle, size_t n)
{
    double low = INFINITY, high = -INFINITY;
    *mohr = (struct mohr){.n = n, .friction_angle_own = NAN, .cohesion_own = NAN, .curvature_pa = INFINITY};
    (void)gsl_set_error_handler_off(); /* failures are returned */
    for (size_t k = 0; k < n; k++) {
        low = fmin(low, centre(&circle[k]));
        high = fmax(high, centre(&circle[k]));
    }
    if (n < 2 || !(high > 0) || !(high - low > spread_min * high))
        return false;
    const bool weighted = has_errors(circle, n);
    struct line line = {{0}, {0}, 0};
    for (int pass = 0; pass < 20; pass++) /* the weights' dependence on m contracts by its square */
        if (!line_fit(&line, circle, n, 2, high, line.c[1] / high, weighted))
            return false;
    const double m = line.c[1] / high;
    const double covariance[4] = {line.covariance[0], line.covariance[1] / high, line.covariance[2] / high,
                                  line.covariance[3] / (high * high)};
    if (!(fabs(m) < 1))
        return false;
    const double dof = (double)n - 2;
    const double factor = n > 2 ? sqrt(line.chi_square / dof) * statistics_widening(dof) : NAN;
    angle_and_cohesion(line.c[0], m, covariance, factor, &mohr->friction_angle_deg, &mohr->cohesion_pa);
    if (weighted) {
        struct estimate angle, cohesion;
        angle_and_cohesion(line.c[0], m, covariance, 1, &angle, &cohesion);
        mohr->friction_angle_own = angle.error;
        mohr->cohesion_own = cohesion.error;
    }
    curvature(mohr, circle, n, high, m, weighted);
    return true;
}

enum status mohr_circles(const struct ensemble *ensemble, struct mohr_circle **circle, size_t *n)
{
    *n = 0;
    *circle = calloc(ensemble->n + 1, sizeof **circle);
    if (!*circle)
        return status_fail(STATUS_NO_MEMORY, "out of memory for %zu circles", ensemble->n);
    for (size_t k = 0; k < ensemble->n; k++) {
        const struct quantity *zz = &ensemble->member[k].quantity[QUANTITY_PEAK_SIGMA_ZZ];
        const struct quantity *xx = &ensemble->member[k].quantity[QUANTITY_PEAK_SIGMA_XX];
        if (!isfinite(zz->value) || !isfinite(xx->value))
            continue;
        const bool extension = xx->value > zz->value;
        const struct quantity *major = extension ? xx : zz, *minor = extension ? zz : xx;
        (*circle)[(*n)++] =
            (struct mohr_circle){{major->value, major->uncertainty}, {minor->value, minor->uncertainty}};
    }
    return STATUS_OK;
}

static enum status file_close(FILE *out, const char *path)
{
    int failed = ferror(out); /* sticky: covers every write before */
    if (fclose(out) != 0 || failed)
        return status_fail(STATUS_IO, "%s: cannot be written: %s", path, strerror(errno));
    return STATUS_OK;
}

static enum status csv_write(const struct mohr_circle *circle, size_t n, const char *path)
{
    FILE *out = fopen(path, "w");
    if (!out)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    fprintf(out, "major_pa,u_major_pa,minor_pa,u_minor_pa\n");
    for (size_t k = 0; k < n; k++)
        fprintf(out, "%.12g,%.12g,%.12g,%.12g\n", circle[k].major_pa.value, circle[k].major_pa.error,
                circle[k].minor_pa.value, circle[k].minor_pa.error);
    return file_close(out, path);
}

/* Circles and tangent, one scale on both axes. */
static enum status script_write(const struct mohr *mohr, const struct mohr_circle *circle, size_t n, const char *path)
{
    double largest = 0;
    FILE *out = fopen(path, "w");
    if (!out)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    for (size_t k = 0; k < n; k++)
        largest = fmax(largest, circle[k].major_pa.value);
    const double unit = largest >= 1e6 ? 1e6 : largest >= 1e4 ? 1e3 : 1;
    const double slope = tan(mohr->friction_angle_deg.value / degrees), cohesion = mohr->cohesion_pa.value / unit;
    const double left = fmin(0, -cohesion / slope);
    fprintf(out,
            "# Made by analyzer; run `gnuplot mohr.gp` here to make the plot again.\n"
            "set encoding utf8\nset terminal svg size 800,480 enhanced font 'DejaVu Sans,15' background 'white'\n"
            "set output 'mohr.svg'\nset size ratio -1\nset border 31 linewidth 1.2\nset tics nomirror in scale 0.8\n"
            "set format '%%.4g'\nset grid linewidth 0.6 linecolor '#cccccc'\nset samples 400\nset parametric\n"
            "set trange [0:pi]\nset xrange [%.6g:%.6g]\nset yrange [0:%.6g]\n"
            "set key outside above horizontal Left reverse samplen 2 font ',12'\n"
            "set xlabel 'normal stress [%s]'\nset ylabel 'shear stress [%s]'\n",
            1.05 * fmax(left, -0.3 * largest / unit), 1.05 * largest / unit, 0.6 * largest / unit,
            unit > 1e3 ? "MPa"
            : unit > 1 ? "kPa"
                       : "Pa",
            unit > 1e3 ? "MPa"
            : unit > 1 ? "kPa"
                       : "Pa");
    fprintf(out, "plot ");
    for (size_t k = 0; k < n; k++)
        fprintf(out, "%.10g + %.10g*cos(t), %.10g*sin(t) with lines linewidth 1.5 linecolor '#0072B2' %s, \\\n     ",
                centre(&circle[k]) / unit, radius(&circle[k]) / unit, radius(&circle[k]) / unit,
                k ? "notitle" : "title 'peaks'");
    fprintf(out,
            "t/pi*%.10g + (1 - t/pi)*%.10g, %.10g + %.10g*(t/pi*%.10g + (1 - t/pi)*%.10g) with lines linewidth 2 "
            "dashtype (14,7) linecolor '#D55E00' title '{/Symbol f} = %.3g°, c = %.3g %s'\nunset output\n",
            1.05 * largest / unit, left, cohesion, slope, 1.05 * largest / unit, left, mohr->friction_angle_deg.value,
            cohesion,
            unit > 1e3 ? "MPa"
            : unit > 1 ? "kPa"
                       : "Pa");
    return file_close(out, path);
}

static enum status json_write(const struct mohr *mohr, const char *path)
{
    return report_json_dump(
        json_pack("{s:I, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "circles", (json_int_t)mohr->n, "friction_angle_deg",
                  report_json_number(mohr->friction_angle_deg.value), "friction_angle_uncertainty_scatter",
                  report_json_number(mohr->friction_angle_deg.error), "friction_angle_uncertainty_own",
                  report_json_number(mohr->friction_angle_own), "cohesion_pa",
                  report_json_number(mohr->cohesion_pa.value), "cohesion_uncertainty_scatter",
                  report_json_number(mohr->cohesion_pa.error), "cohesion_uncertainty_own",
                  report_json_number(mohr->cohesion_own), "curved_envelope",
                  mohr->curvature_known ? json_boolean(mohr->curved) : json_null()),
        path);
}

static void print(FILE *out, const struct mohr *mohr)
{
    fprintf(out, "Mohr-Coulomb, common tangent of %zu circles (peaks)\n", mohr->n);
    fprintf(out, "  friction angle %.4g deg +- %.2g from scatter, +- %.2g from the runs' own uncertainties\n",
            mohr->friction_angle_deg.value, mohr->friction_angle_deg.error, mohr->friction_angle_own);
    fprintf(out, "  cohesion       %.4g Pa +- %.2g from scatter, +- %.2g from the runs' own uncertainties\n",
            mohr->cohesion_pa.value, mohr->cohesion_pa.error, mohr->cohesion_own);
    if (!mohr->curvature_known)
        fprintf(out, "  whether the envelope is straight takes 4 circles\n");
    else
        fprintf(out, "  the envelope is %s\n",
                mohr->curved ? "curved: one angle does not describe it, take a narrower range of stress"
                             : "straight within its uncertainty");
}

static enum status files_write(const struct mohr *mohr, const struct mohr_circle *circle, size_t n,
                               const char *directory)
{
    char path[2048];
    if (snprintf(path, sizeof path, "%s/mohr.json", directory) >= (int)sizeof path)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", directory);
    TRY(json_write(mohr, path));
    snprintf(path, sizeof path, "%s/mohr.csv", directory);
    TRY(csv_write(circle, n, path));
    snprintf(path, sizeof path, "%s/mohr.gp", directory);
    return script_write(mohr, circle, n, path);
}

enum status mohr_report(FILE *out, const struct ensemble *ensemble, const char *directory, bool *found)
{
    struct mohr_circle *circle;
    struct mohr mohr;
    size_t n;
    TRY(mohr_circles(ensemble, &circle, &n));
    enum status status = STATUS_OK;
    *found = mohr_fit(&mohr, circle, n);
    if (*found) {
        print(out, &mohr);
        status = directory ? files_write(&mohr, circle, n, directory) : STATUS_OK;
    }
    free(circle);
    return status;
}
