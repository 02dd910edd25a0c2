/* Whether a sample under cycles shakes down, ratchets or collapses: by the statistics of its rates, and by the ranges
 * of Werkmeister (2003). */
#ifndef SHAKEDOWN_ANALYZER_SHAKEDOWN_H
#define SHAKEDOWN_ANALYZER_SHAKEDOWN_H

#include "analyzer/cycles.h"

enum { CYCLES_MIN = 8, CYCLES_BINS = 8 };

/* Fills the trends and both verdicts of `cycles`. `negligible` is the rate per cycle, over the strain amplitude of a
 * cycle (peak to peak), below which accumulation has no practical meaning.
 *
 * By the statistics, first that holds; 2u is taken for each bound:
 *   collapse:     |eps_D| reached 0.1; or the exponent m of rate ~ N^m is above 0 and the rate more than doubles within
 * the second half of the cycles; shakedown:    the rate is below `negligible`; or m is below -1, so that the strain
 * stays bounded; ratcheting:   the rate is above `negligible` and m above -1; undetermined: any other, and fewer than
 * CYCLES_MIN cycles.
 *
 * Werkmeister: the axial strain gained from cycle 3000 to 5000, below 4.5e-5 range A (plastic shakedown), up to 4e-4
 * range B (plastic creep), above it range C (incremental collapse); from the fit a N^b where there are fewer cycles;
 * undetermined if twice the fit's uncertainty leaves the range. */
void shakedown_classify(struct cycles *cycles, const struct curves *curves, double negligible);

/* "shakedown", "ratcheting", "collapse", "undetermined". */
const char *shakedown_verdict_name(enum cycles_verdict verdict);

#endif
