#include "analyzer/creep_relaxation.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <gsl/gsl_statistics_double.h>
#include <math.h>
#include <stdlib.h>

enum { SAMPLES_MIN = 12, PARAMETERS = 3 };

/* y = a + b exp(-t/c), of which c is kept positive as its logarithm. */
struct decay {
    const double *t, *y;
    size_t n;
};

static int residuals(const gsl_vector *x, void *context, gsl_vector *f)
{
    const struct decay *decay = context;
    const double time = exp(gsl_vector_get(x, 2));
    for (size_t k = 0; k < decay->n; k++)
        gsl_vector_set(f, k, gsl_vector_get(x, 0) + gsl_vector_get(x, 1) * exp(-decay->t[k] / time) - decay->y[k]);
    return GSL_SUCCESS;
}

/* The fit, if it converges to a time that the record can tell: between two samples and three times its length. */
static bool decay_solve(const struct decay *decay, gsl_multifit_nlinear_workspace *room,
                        struct estimate out[PARAMETERS])
{
    gsl_multifit_nlinear_fdf problem = {.f = residuals, .n = decay->n, .p = PARAMETERS, .params = (void *)decay};
    const double length = decay->t[decay->n - 1] - decay->t[0];
    double start[PARAMETERS] = {decay->y[decay->n - 1], decay->y[0] - decay->y[decay->n - 1], log(length / 4)};
    double room_for[PARAMETERS * PARAMETERS], chi = 0;
    gsl_vector_const_view x = gsl_vector_const_view_array(start, PARAMETERS);
    gsl_matrix_view covariance = gsl_matrix_view_array(room_for, PARAMETERS, PARAMETERS);
    int info;
    if (gsl_multifit_nlinear_init(&x.vector, &problem, room) != 0 ||
        gsl_multifit_nlinear_driver(200, 1e-10, 1e-10, 0, NULL, NULL, &info, room) != 0 ||
        gsl_multifit_nlinear_covar(gsl_multifit_nlinear_jac(room), 0, &covariance.matrix) != 0)
        return false;
    gsl_vector *f = gsl_multifit_nlinear_residual(room);
    for (size_t k = 0; k < decay->n; k++)
        chi += gsl_vector_get(f, k) * gsl_vector_get(f, k);
    /* residuals of a smooth decay are correlated: as many as there are runs of one sign count */
    const double c = gsl_stats_lag1_autocorrelation(f->data, f->stride, decay->n);
    const double inflation = c > 0 ? (1 + fmin(c, 0.95)) / (1 - fmin(c, 0.95)) : 1;
    const double variance = chi / (double)(decay->n - PARAMETERS) * inflation;
    for (size_t k = 0; k < PARAMETERS; k++)
        out[k] = (struct estimate){gsl_vector_get(gsl_multifit_nlinear_position(room), k),
                                   sqrt(variance * gsl_matrix_get(&covariance.matrix, k, k))};
    out[2] = (struct estimate){exp(out[2].value), exp(out[2].value) * out[2].error};
    return out[2].value > length / (double)decay->n && out[2].value < 3 * length;
}

static bool decay_fit(const struct decay *decay, struct estimate out[PARAMETERS])
{
    const gsl_multifit_nlinear_parameters parameters = gsl_multifit_nlinear_default_parameters();
    if (decay->n < SAMPLES_MIN)
        return false;
    (void)gsl_set_error_handler_off(); /* failures are returned */
    gsl_multifit_nlinear_workspace *room =
        gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &parameters, decay->n, PARAMETERS);
    if (!room)
        return false;
    const bool good = decay_solve(decay, room, out);
    gsl_multifit_nlinear_free(room);
    return good;
}

static void time_set(const struct decay *decay, struct quantity *quantity)
{
    struct estimate out[PARAMETERS];
    if (!decay_fit(decay, out)) {
        quantity_undefined(quantity, "no exponential decay with a time that the record can tell");
        return;
    }
    quantity_set(quantity, out[2]);
    quantity_note(quantity, "a + b exp(-t/T): a = %.6g, b = %.4g", out[0].value, out[1].value);
}

static void creep(const struct curves *curves, struct quantity *q)
{
    const double *t = curves->column[CURVE_STAGE_TIME], *eps = curves->column[CURVE_EPS_ZZ_LOG];
    const size_t n = curves->n, begin = n - n / 4;
    const struct decay decay = {t, eps, n};
    quantity_set(&q[QUANTITY_HELD_STRAIN], (struct estimate){eps[n - 1], NAN});
    time_set(&decay, &q[QUANTITY_HELD_TIME]);
    double *w = malloc((n - begin + 1) * sizeof *w);
    struct estimate rate;
    struct points points = {t + begin, w, n - begin};
    if (w)
        statistics_weights(points.x, w, points.n);
    if (w && statistics_slope(&points, eps + begin, &rate)) {
        quantity_set(&q[QUANTITY_HELD_RATE], rate);
        quantity_window(&q[QUANTITY_HELD_RATE], t[begin], t[n - 1]);
        quantity_note(&q[QUANTITY_HELD_RATE], "window in s");
    } else {
        quantity_undefined(&q[QUANTITY_HELD_RATE], "too few samples");
    }
    free(w);
}

static void relaxation(const struct curves *curves, struct quantity *q)
{
    const double *sigma = curves->column[CURVE_SIGMA_ZZ];
    const struct decay decay = {curves->column[CURVE_STAGE_TIME], sigma, curves->n};
    if (sigma[0] != 0)
        quantity_set(&q[QUANTITY_RELAXATION_DROP], (struct estimate){1 - sigma[curves->n - 1] / sigma[0], NAN});
    else
        quantity_undefined(&q[QUANTITY_RELAXATION_DROP], "no stress at the start of the stage");
    time_set(&decay, &q[QUANTITY_RELAXATION_TIME]);
}

void creep_relaxation_evaluate(const struct curves *curves, struct quantity *quantities)
{
    const bool creeps = curves->controls.kind == TEST_CREEP;
    if (curves->n < SAMPLES_MIN) {
        for (int id = QUANTITY_HELD_STRAIN; id <= QUANTITY_RELAXATION_TIME; id++)
            quantity_undefined(&quantities[id], "the stage has %zu samples: too few", curves->n);
        return;
    }
    if (creeps)
        creep(curves, quantities);
    else
        relaxation(curves, quantities);
}
