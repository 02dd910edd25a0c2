#include "analyzer/true_triaxial.h"

#include <math.h>
#include <stdlib.h>

#include "analyzer/local_fit.h"

static const double ALIKE = 0.05, SHEARED = 0.1, DEGREES = 180 / M_PI;

/* Curves over the logarithmic axial strain, the one whose maximum is the peak first. */
enum principal { RATIO, SIN_PHI, B, Q_OVER_P, LODE, LADE, MATSUOKA_NAKAI, EPS, PRINCIPALS };
_Static_assert((int)PRINCIPALS <= (int)LOCAL_CURVES_MAX, "a peak has more curves than local_fit takes");

static const struct {
    enum quantity_id id;
    enum principal from;
} AT_PEAK[] = {{QUANTITY_TRUE_EPS, EPS},
               {QUANTITY_TRUE_B, B},
               {QUANTITY_TRUE_SIN_PHI, SIN_PHI},
               {QUANTITY_TRUE_Q_OVER_P, Q_OVER_P},
               {QUANTITY_TRUE_LODE, LODE},
               {QUANTITY_TRUE_LADE, LADE},
               {QUANTITY_TRUE_MATSUOKA, MATSUOKA_NAKAI}};
enum { AT_PEAK_N = sizeof AT_PEAK / sizeof AT_PEAK[0] };

static void all_absent(struct quantity *q, const char *reason)
{
    for (int id = QUANTITY_TRUE_EPS; id <= QUANTITY_TRUE_MATSUOKA; id++)
        quantity_absent(&q[id], reason);
}

/* s1 >= s2 >= s3. */
static void sort3(const double *stress, double *s)
{
    s[0] = fmax(stress[0], fmax(stress[1], stress[2]));
    s[2] = fmin(stress[0], fmin(stress[1], stress[2]));
    s[1] = stress[0] + stress[1] + stress[2] - s[0] - s[2];
}

/* q here is sqrt(3 J2); the Lode angle 0 in triaxial compression (b = 0), 60 deg in extension (b = 1). Invariants of
 * Lade & Duncan (1975), I1^3/I3, and of Matsuoka & Nakai (1974), I1 I2/I3: 27 and 9 under isotropic stress. */
static void values_at(const double *stress, double *const y[PRINCIPALS], size_t k)
{
    double s[3];
    sort3(stress, s);
    const double i1 = s[0] + s[1] + s[2], i2 = s[0] * s[1] + s[1] * s[2] + s[2] * s[0], i3 = s[0] * s[1] * s[2];
    const double j2 = (pow(s[0] - s[1], 2) + pow(s[1] - s[2], 2) + pow(s[2] - s[0], 2)) / 6;
    y[RATIO][k] = s[0] / s[2];
    y[SIN_PHI][k] = (s[0] - s[2]) / (s[0] + s[2]);
    y[B][k] = s[0] > s[2] ? (s[1] - s[2]) / (s[0] - s[2]) : 0;
    y[Q_OVER_P][k] = sqrt(3 * j2) / (i1 / 3);
    y[LODE][k] = atan2(sqrt(3) * y[B][k], 2 - y[B][k]) * DEGREES;
    y[LADE][k] = i1 * i1 * i1 / i3;
    y[MATSUOKA_NAKAI][k] = i1 * i2 / i3;
}

/* Whether sigma_yy and sigma_xx differ while the sample is sheared. */
static bool laterals_differ(const struct run *run, size_t begin, size_t end)
{
    double apart = 0, span = 0, largest = 0;
    for (size_t k = begin; k < end; k++) {
        const double *s = run_record(run, OBSERVABLE_STRESS_WALL, k);
        largest = fmax(largest, fabs(s[2] - s[0]));
    }
    for (size_t k = begin; k < end; k++) {
        const double *s = run_record(run, OBSERVABLE_STRESS_WALL, k);
        if (fabs(s[2] - s[0]) < SHEARED * largest)
            continue;
        apart += fabs(s[1] - s[0]);
        span += fabs(s[2] - s[0]);
    }
    return span > 0 && apart > ALIKE * span;
}

/* Samples that reach a new largest |axial strain|; returns their number. */
static size_t samples_take(const struct run *run, const struct curves *curves, size_t begin, double *x,
                           double *const y[PRINCIPALS])
{
    const double *eps = curves->column[CURVE_EPS_ZZ_LOG], sign = curves->controls.extension ? -1 : 1;
    double largest = -INFINITY;
    size_t n = 0;
    for (size_t k = 0; k < curves->n; k++) {
        const double *stress = run_record(run, OBSERVABLE_STRESS_WALL, begin + k);
        if (!(sign * eps[k] > largest + 1e-14) || !(stress[0] > 0 && stress[1] > 0 && stress[2] > 0))
            continue;
        largest = x[n] = sign * eps[k];
        y[EPS][n] = curves->column[CURVE_EPS_ZZ][k];
        values_at(stress, y, n++);
    }
    return n;
}

static void peak_set(const double *x, size_t n, double *const y[PRINCIPALS], struct quantity *q)
{
    struct local_curves curves = {.x = x, .n = n, .count = PRINCIPALS};
    struct local_peak peak;
    for (int k = 0; k < PRINCIPALS; k++)
        curves.y[k] = y[k];
    if (n < LOCAL_POINTS_MIN ||
        !local_peak_find(&curves, fmax((x[n - 1] - x[0]) / 40, 5 * x[n - 1] / (double)n), &peak)) {
        for (int id = QUANTITY_TRUE_EPS; id <= QUANTITY_TRUE_MATSUOKA; id++)
            quantity_undefined(&q[id], "too few samples to look for a peak");
        return;
    }
    for (int k = 0; k < AT_PEAK_N; k++)
        quantity_set(&q[AT_PEAK[k].id], peak.value[AT_PEAK[k].from]);
    const struct estimate sine = peak.value[SIN_PHI];
    quantity_set(&q[QUANTITY_TRUE_ANGLE], (struct estimate){asin(sine.value) * DEGREES,
                                                            sine.error / sqrt(1 - sine.value * sine.value) * DEGREES});
    for (int id = QUANTITY_TRUE_EPS; id <= QUANTITY_TRUE_MATSUOKA; id++) {
        quantity_window(&q[id], peak.window[0], peak.window[1]);
        if (peak.at_end)
            quantity_note(&q[id], "no peak: sigma_1/sigma_3 %s",
                          peak.at_end > 0 ? "still rises at the last sample" : "falls from the first sample");
    }
}

enum status true_triaxial_evaluate(const struct run *run, const struct curves *curves, struct quantity *q)
{
    size_t begin, end;
    run_stage_range(run, curves->stage, &begin, &end);
    if (run->dimension != 3 || curves->controls.axial != AXIS_Z || !laterals_differ(run, begin, end)) {
        all_absent(q, "the lateral stresses are alike");
        return STATUS_OK;
    }
    const size_t room = curves->n + 1;
    double *values = malloc((PRINCIPALS + 1) * room * sizeof *values), *y[PRINCIPALS];
    if (!values)
        return status_fail(STATUS_NO_MEMORY, "out of memory for %zu samples", curves->n);
    for (int k = 0; k < PRINCIPALS; k++)
        y[k] = values + (size_t)(k + 1) * room;
    peak_set(values, samples_take(run, curves, begin, values, y), y, q);
    free(values);
    return STATUS_OK;
}
