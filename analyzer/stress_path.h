/* Straight paths in (p, q): stiffness along the path, and the yield point. Definitions: docs/analysis.md. */
#ifndef SHAKEDOWN_ANALYZER_STRESS_PATH_H
#define SHAKEDOWN_ANALYZER_STRESS_PATH_H

#include "analyzer/loading_branch.h"
#include "analyzer/quantity.h"

/* Sets path.* and yield.*. `window`: analysis.modulus_strain, in which initial slopes are looked for. Undefined, with
 * the reason, where the path is not straight, or bends nowhere. STATUS_NO_MEMORY. */
enum status stress_path_evaluate(const struct curves *curves, const struct loading *loading, double window,
                                 struct quantity *quantities) MUST_USE;

/* Two lines that meet: where, and their slopes. */
struct bilinear {
    double place, value, before, after;
};

/* Least squares of y[n] over points->x with weights, without points [skip_begin, skip_end). The place lies between the
 * 5th and the 95th part of a hundred of the range. False with fewer than 6 points, or if no place can be found. */
bool stress_path_bilinear(const struct points *points, const double *y, size_t skip_begin, size_t skip_end,
                          struct bilinear *fit);

#endif
