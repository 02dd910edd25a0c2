#include "analyzer/shear_strength.h"

#include <math.h>

#include "analyzer/loading_branch.h"
#include "analyzer/loading_peak.h"
#include "analyzer/stress_path.h"

static const double degrees = 180 / M_PI;

static struct estimate scaled(struct estimate estimate, double factor)
{
    return (struct estimate){estimate.value * factor, estimate.error * fabs(factor)};
}

struct estimate shear_dilatancy_angle_rad(struct estimate slope, bool extension)
{
    const double s = slope.value, base = extension ? 2 - s : 2 + s, sine = s / base;
    if (!(base > 0) || !(fabs(sine) < 1))
        return (struct estimate){NAN, NAN};
    return (struct estimate){asin(sine), slope.error * 2 / (base * base) / sqrt(1 - sine * sine)};
}

struct estimate shear_sin_phi(struct estimate ratio)
{
    double r = ratio.value;
    return (struct estimate){(r - 1) / (r + 1), ratio.error * 2 / ((r + 1) * (r + 1))};
}

/* phi = asin(s), tan phi = s/sqrt(1 - s^2), with d phi = ds/cos phi, d tan phi = ds/cos^3 phi. */
static struct estimate angle_deg(struct estimate sine)
{
    return (struct estimate){asin(sine.value) * degrees, sine.error / sqrt(1 - sine.value * sine.value) * degrees};
}

static struct estimate tangent(struct estimate sine)
{
    double cosine = sqrt(1 - sine.value * sine.value);
    return (struct estimate){sine.value / cosine, sine.error / (cosine * cosine * cosine)};
}

static struct estimate scaled_place(struct estimate place, double sign)
{
    return (struct estimate){sign * place.value, place.error};
}

static void set_in_window(struct quantity *quantity, struct estimate estimate, const double *window)
{
    quantity_set(quantity, estimate);
    quantity_window(quantity, window[0], window[1]);
}

/* Slope of a curve against logarithmic axial strain in the window [a, b], or the reason why there is none. */
static bool slope_set(const struct loading *loading, enum loading_curve curve, double a, double b,
                      struct quantity *quantity, struct estimate *slope)
{
    size_t first;
    double window[2] = {a, b};
    struct points points = loading_window(loading, a, b, &first);
    points.x = loading->y[LOADING_EPS_ZZ_LOG] + first;
    if (!statistics_slope(&points, loading->y[curve] + first, slope)) {
        quantity_undefined(quantity, "%zu samples with axial strain in [%g, %g]: too few", points.n, a, b);
        return false;
    }
    set_in_window(quantity, *slope, window);
    return true;
}

/* Slope of a curve at the first strain, from windows within [0, `window`]. */
static bool initial_slope_set(const struct loading *loading, enum loading_curve curve, double window,
                              struct quantity *quantity, struct estimate *slope)
{
    struct estimate value;
    double bounds[2] = {0, window}, first = loading->y[LOADING_EPS_ZZ_LOG][0];
    if (!loading_at(loading, curve, first, loading_to_log(loading, window) - first, &value, slope)) {
        quantity_undefined(quantity, "too few samples with axial strain up to %g", window);
        return false;
    }
    set_in_window(quantity, *slope, bounds);
    return true;
}

static void moduli(const struct curves *curves, const struct loading *loading, double window, struct quantity *q)
{
    static const char not_held[] = "lateral stress is not held constant";
    const double bounds[2] = {0, window}, sign = loading->sign;
    struct estimate slope, strain;
    if (initial_slope_set(loading, LOADING_SIGMA_ZZ, window, &q[QUANTITY_E_INITIAL], &slope)) {
        set_in_window(&q[QUANTITY_E_INITIAL], scaled(slope, sign), bounds);
        if (isnan(curves->controls.lateral_pressure_pa))
            quantity_note(&q[QUANTITY_E_INITIAL], "%s: not Young's modulus", not_held);
    }
    if (initial_slope_set(loading, LOADING_EPS_V_LOG, window, &q[QUANTITY_EPS_V_SLOPE_INITIAL], &slope))
        set_in_window(&q[QUANTITY_EPS_V_SLOPE_INITIAL], scaled(slope, sign), bounds);
    if (initial_slope_set(loading, LOADING_EPS_XX_LOG, window, &q[QUANTITY_NU], &slope))
        set_in_window(&q[QUANTITY_NU], scaled(slope, -sign), bounds);
    if (isnan(curves->controls.lateral_pressure_pa))
        quantity_undefined(&q[QUANTITY_NU], not_held);
    /* 2 G = dq/d(eps_zz - eps_xx) = (dq/deps_zz)/(d(eps_zz - eps_xx)/deps_zz) */
    if (initial_slope_set(loading, LOADING_Q, window, &q[QUANTITY_G_INITIAL], &slope) &&
        initial_slope_set(loading, LOADING_EPS_D_LOG, window, &q[QUANTITY_G_INITIAL], &strain)) {
        const double modulus = slope.value / (2 * sign * strain.value);
        const double error = fabs(modulus) * hypot(slope.error / slope.value, strain.error / strain.value);
        set_in_window(&q[QUANTITY_G_INITIAL], (struct estimate){modulus, error}, bounds);
    }
}

/* Straight lines over the whole window. */
static void window_moduli(const struct curves *curves, const struct loading *loading, double window, struct quantity *q)
{
    const double bounds[2] = {0, window};
    struct estimate slope;
    if (slope_set(loading, LOADING_SIGMA_ZZ, 0, window, &q[QUANTITY_WINDOW_E], &slope))
        set_in_window(&q[QUANTITY_WINDOW_E], scaled(slope, loading->sign), bounds);
    if (slope_set(loading, LOADING_EPS_XX_LOG, 0, window, &q[QUANTITY_WINDOW_NU], &slope))
        set_in_window(&q[QUANTITY_WINDOW_NU], scaled(slope, -loading->sign), bounds);
    if (isnan(curves->controls.lateral_pressure_pa))
        quantity_undefined(&q[QUANTITY_WINDOW_NU], "lateral stress is not held constant");
}

/* What a stress loses when the leading wall comes to rest at the end: its value where the motion ends, from the samples
 * before, less that of the last half of the rest, which is the stress at zero rate. */
static void viscous_part(const struct curves *curves, const struct loading *loading, enum loading_curve moving,
                         enum curve resting, struct quantity *quantity, struct quantity *at_rest)
{
    enum { REST_MIN = 6 };
    const size_t after = curves->n - 1 - loading->last, end = curves->n, half = after / 2;
    const double last = loading->y[LOADING_EPS_ZZ_LOG][loading->n - 1];
    struct estimate value, slope;
    if (after < REST_MIN || curves->controls.stress_led) {
        quantity_undefined(quantity, "the leading wall does not rest at the end of the stage");
        *at_rest = *quantity;
        return;
    }
    if (!loading_at(loading, moving, last, (last - loading->y[LOADING_EPS_ZZ_LOG][0]) / 10, &value, &slope)) {
        quantity_undefined(quantity, "too few samples before the rest");
        *at_rest = *quantity;
        return;
    }
    double deviation;
    struct estimate rest = statistics_plain_mean(curves->column[resting] + end - half, half, &deviation);
    quantity_set(at_rest, rest);
    quantity_set(quantity, (struct estimate){value.value - rest.value, hypot(value.error, rest.error)});
    quantity_window(quantity, loading->eps[loading->n - 1], loading->eps[loading->n - 1]);
    quantity_note(quantity, "stress at the end of the motion less that at rest");
}

static void dilatancy(const struct loading *loading, const struct scene_analysis *analysis, struct quantity *q)
{
    struct estimate slope;
    double last = loading->eps[loading->n - 1];
    double window[2] = {analysis->dilatancy_min_strain,
                        analysis->dilatancy_max_strain > 0 ? fmin(last, analysis->dilatancy_max_strain) : last};
    if (!slope_set(loading, LOADING_EPS_V_LOG, window[0], window[1], &q[QUANTITY_DILATANCY_SLOPE], &slope)) {
        q[QUANTITY_DILATANCY_ANGLE] = q[QUANTITY_DILATANCY_SLOPE];
        return;
    }
    slope = scaled(slope, -1);
    set_in_window(&q[QUANTITY_DILATANCY_SLOPE], slope, window);
    struct estimate angle = shear_dilatancy_angle_rad(slope, loading->sign < 0);
    if (isnan(angle.value))
        quantity_undefined(&q[QUANTITY_DILATANCY_ANGLE], "slope %g belongs to no angle", slope.value);
    else
        set_in_window(&q[QUANTITY_DILATANCY_ANGLE], scaled(angle, degrees), window);
}

static const enum quantity_id peak_ids[] = {
    QUANTITY_PEAK_SIGMA_CORR, QUANTITY_PEAK_SIGMA_ZZ,       QUANTITY_PEAK_SIGMA_XX,
    QUANTITY_PEAK_EPS_ZZ,     QUANTITY_PEAK_STRESS_RATIO,   QUANTITY_PEAK_SIN_PHI,
    QUANTITY_PEAK_TAN_PHI,    QUANTITY_PEAK_FRICTION_ANGLE, QUANTITY_PEAK_Q_OVER_P,
};
enum { PEAK_IDS = sizeof peak_ids / sizeof peak_ids[0] };

/* sigma_corr = p_x sigma_zz/sigma_xx [LH eq. 1.10] and the stress ratio have their maximum at the same strain. */
static void peak(const struct curves *curves, const struct loading *loading, struct quantity *q)
{
    struct loading_peak found;
    if (!loading_peak_find(loading, LOADING_RATIO, &found)) {
        for (int k = 0; k < PEAK_IDS; k++)
            quantity_undefined(&q[peak_ids[k]], "too few samples to look for a peak");
        return;
    }
    struct estimate sine = shear_sin_phi(found.value);
    const struct estimate values[PEAK_IDS] = {scaled(found.value, curves->controls.lateral_pressure_pa),
                                              found.along[LOADING_SIGMA_ZZ],
                                              found.along[LOADING_SIGMA_XX],
                                              scaled_place(found.eps, loading->sign),
                                              found.value,
                                              sine,
                                              tangent(sine),
                                              angle_deg(sine),
                                              found.along[LOADING_Q_OVER_P]};
    for (int k = 0; k < PEAK_IDS; k++) {
        set_in_window(&q[peak_ids[k]], values[k], found.window);
        if (found.at_end)
            quantity_note(&q[peak_ids[k]], "no peak: the stress ratio %s",
                          found.at_end > 0 ? "still rises at the last sample" : "falls from the first sample");
    }
    if (isnan(curves->controls.lateral_pressure_pa))
        quantity_undefined(&q[QUANTITY_PEAK_SIGMA_CORR], "lateral stress is not held constant");
}

/* Logarithmic strain at which the deviator, smoothed over +- half, first reaches `level` before `upper`; NaN if it
 * never does. */
static double crossing(const struct loading *loading, double level, double upper, double half)
{
    enum { GRID = 400 };
    double first = loading->y[LOADING_EPS_ZZ_LOG][0], before = NAN;
    for (int k = 0; k <= GRID; k++) {
        double step = (upper - first) / GRID, eps = first + step * k;
        double value = loading_smooth(loading, loading->y[LOADING_Q], loading_from_log(loading, eps), half);
        if (value >= level)
            return k == 0 ? NAN : eps - step * (value - level) / (value - before);
        before = value;
    }
    return NAN;
}

/* E50 = (q50 - q0)/(eps50 - eps0) with q50 = (q0 + q_peak)/2. First-order propagation of three errors: of q0, of
 * q_peak, and of q at the crossing, which moves eps50 by u/slope. */
static struct estimate secant(struct estimate start, struct estimate top, struct estimate here, double slope,
                              double run)
{
    double modulus = (top.value - start.value) / 2 / run, by_place = modulus / (run * slope);
    double by_start = (1 / run + by_place) / 2, by_top = (1 / run - by_place) / 2;
    double error = hypot(hypot(by_start * start.error, by_top * top.error), by_place * here.error);
    return (struct estimate){modulus, error};
}

static void secant_modulus(const struct loading *loading, double modulus_strain, struct quantity *quantity)
{
    struct loading_peak top;
    struct estimate start, here, slope;
    const double origin = loading->y[LOADING_EPS_ZZ_LOG][0];
    if (!loading_peak_find(loading, LOADING_Q, &top) ||
        !loading_at(loading, LOADING_Q, origin, loading_to_log(loading, modulus_strain) - origin, &start, &slope)) {
        quantity_undefined(quantity, "too few samples for the start or the peak of the deviator");
        return;
    }
    double peak = loading_to_log(loading, top.eps.value), half = fmax(peak / 20, 4 * peak / (double)loading->n);
    double level = (start.value + top.value.value) / 2, eps50 = crossing(loading, level, peak, half);
    if (!isfinite(eps50) || !loading_at(loading, LOADING_Q, eps50, fmax(half, (eps50 - origin) / 2), &here, &slope) ||
        !(slope.value > 0)) {
        quantity_undefined(quantity, "the deviator has no rise to half of its peak that could be followed");
        return;
    }
    eps50 += (level - here.value) / slope.value; /* one step of Newton's method */
    if (!(eps50 > origin)) {
        quantity_undefined(quantity, "half of the peak deviator is there from the start");
        return;
    }
    quantity_set(quantity, secant(start, top.value, here, slope.value, eps50 - origin));
    quantity_window(quantity, loading->eps[0], loading_from_log(loading, eps50));
    if (top.at_end > 0)
        quantity_note(quantity, "the deviator still rises at the last sample");
}

static const enum quantity_id final_ids[] = {QUANTITY_RESIDUAL_SIGMA_CORR, QUANTITY_RESIDUAL_STRESS_RATIO,
                                             QUANTITY_CRITICAL_SIN_PHI, QUANTITY_CRITICAL_FRICTION_ANGLE,
                                             QUANTITY_CRITICAL_Q_OVER_P};
enum { FINAL_IDS = sizeof final_ids / sizeof final_ids[0] };

/* Means over the last part of the strain. */
static void residual(const struct curves *curves, const struct loading *loading, const struct scene_analysis *analysis,
                     struct quantity *q)
{
    size_t first;
    double last = loading->eps[loading->n - 1];
    double window[2] = {fmax(loading->eps[0], last - analysis->residual_strain), last};
    struct points points = loading_window(loading, window[0], window[1], &first);
    struct estimate ratio, sine, q_over_p;
    bool good = statistics_mean(&points, loading->y[LOADING_RATIO] + first, &ratio);
    good = statistics_mean(&points, loading->y[LOADING_SIN_PHI] + first, &sine) && good;
    good = statistics_mean(&points, loading->y[LOADING_Q_OVER_P] + first, &q_over_p) && good;
    if (!good) {
        for (int k = 0; k < FINAL_IDS; k++)
            quantity_undefined(&q[final_ids[k]], "no stress in the last %g of the strain", analysis->residual_strain);
        return;
    }
    const struct estimate values[FINAL_IDS] = {scaled(ratio, curves->controls.lateral_pressure_pa), ratio, sine,
                                               angle_deg(sine), q_over_p};
    for (int k = 0; k < FINAL_IDS; k++)
        set_in_window(&q[final_ids[k]], values[k], window);
    if (isnan(curves->controls.lateral_pressure_pa))
        quantity_undefined(&q[QUANTITY_RESIDUAL_SIGMA_CORR], "lateral stress is not held constant");
}

static void all_undefined(struct quantity *q, const char *reason)
{
    for (int k = QUANTITY_E_INITIAL; k <= QUANTITY_YIELD_STIFFNESS_RATIO; k++)
        quantity_undefined(&q[k], "%s", reason);
}

static void loading_evaluate(const struct curves *curves, const struct loading *loading,
                             const struct scene_analysis *analysis, struct quantity *q, struct stiffness *stiffness)
{
    moduli(curves, loading, analysis->modulus_strain, q);
    window_moduli(curves, loading, analysis->modulus_strain, q);
    viscous_part(curves, loading, LOADING_SIGMA_ZZ, CURVE_SIGMA_ZZ, &q[QUANTITY_VISCOUS_ZZ], &q[QUANTITY_ZERO_RATE_ZZ]);
    viscous_part(curves, loading, LOADING_SIGMA_XX, CURVE_SIGMA_XX, &q[QUANTITY_VISCOUS_XX], &q[QUANTITY_ZERO_RATE_XX]);
    secant_modulus(loading, analysis->modulus_strain, &q[QUANTITY_E50]);
    if (curves->controls.kind == TEST_CONSTANT_VOLUME) {
        quantity_undefined(&q[QUANTITY_DILATANCY_SLOPE], "the volume is kept");
        quantity_undefined(&q[QUANTITY_DILATANCY_ANGLE], "the volume is kept");
    } else {
        dilatancy(loading, analysis, q);
    }
    peak(curves, loading, q);
    residual(curves, loading, analysis, q);
    stiffness_evaluate(stiffness, curves, loading, q);
}

enum status shear_strength_evaluate(const struct curves *curves, const struct scene *scene, struct quantity *quantities,
                                    struct stiffness *stiffness)
{
    struct loading loading;
    enum status status = STATUS_OK;
    *stiffness = (struct stiffness){0};
    TRY(loading_extract(&loading, curves, scene->analysis.strain));
    if (loading.n < 2) {
        all_undefined(quantities, loading.n ? "the stage has no strain yet" : "the stage has no samples");
    } else {
        loading_evaluate(curves, &loading, &scene->analysis, quantities, stiffness);
        status = stress_path_evaluate(curves, &loading, scene->analysis.modulus_strain, quantities);
    }
    loading_free(&loading);
    return status;
}
