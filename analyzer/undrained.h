/* Tests at constant volume: the effective path in (p, q). Definitions: docs/analysis.md. */
#ifndef SHAKEDOWN_ANALYZER_UNDRAINED_H
#define SHAKEDOWN_ANALYZER_UNDRAINED_H

#include "analyzer/curves.h"
#include "analyzer/quantity.h"

/* r_u = (p0 - p)/p0 at which a sample counts as liquefied. */
extern const double undrained_liquefied;

/* Fills undrained.*, phase_transformation.* and liquefaction.eps_zz. */
void undrained_evaluate(const struct curves *curves, struct quantity *quantities);

#endif
