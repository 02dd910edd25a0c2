/* The curve of a run, as the benchmark of accuracy compares it: read from the event log of sim. */
#ifndef SHAKEDOWN_BENCH_ACCURACY_CURVE_H
#define SHAKEDOWN_BENCH_ACCURACY_CURVE_H

#include <stdint.h>

#include "common/status.h"

enum curve_quantity { CURVE_STRESS_WALL, CURVE_STRAIN };

struct curve {
    int count;
    double *time_s, *strain, *value; /* [count] at the samples; strain is of the same component */
    double residual_ratio;           /* ledger at the last sample: |residual| over |work of walls and gravity| */
    int64_t hash;                    /* of the state at the end: equal bits, equal hash */
};

/* Component c of the quantity at every sample of the log at `path`. STATUS_IO; STATUS_FORMAT if it holds no samples or
 * no END that says ok. */
enum status curve_read(struct curve *curve, const char *path, enum curve_quantity quantity, int c) MUST_USE;
void curve_free(struct curve *curve);

/* Relative L2 difference sqrt(sum (a - b)^2 / sum b^2) over the samples with |b's strain| <= strain_max. STATUS_FORMAT
 * if the two were not sampled at the same times, or b is zero there. */
enum status curve_error(const struct curve *a, const struct curve *b, double strain_max, double *error) MUST_USE;

/* p in error ~ step^p through two points. */
double convergence_order(double step_a, double error_a, double step_b, double error_b);

#endif
