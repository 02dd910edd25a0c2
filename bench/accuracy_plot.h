/* Error against cost as a picture, made by gnuplot. */
#ifndef SHAKEDOWN_BENCH_ACCURACY_PLOT_H
#define SHAKEDOWN_BENCH_ACCURACY_PLOT_H

#include <jansson.h>

#include "common/status.h"

/* From what bench_accuracy reports as JSON: left the error of the curve, right that of the ledger, against CPU time.
 * Data and script stay in `folder`. STATUS_IO if gnuplot is not there or fails. */
enum status accuracy_plot(const json_t *report, const char *folder, const char *path) MUST_USE;

#endif
