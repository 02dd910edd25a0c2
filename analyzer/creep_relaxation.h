/* Creep (stresses held) and relaxation (walls at rest). Definitions: docs/analysis.md. */
#ifndef SHAKEDOWN_ANALYZER_CREEP_RELAXATION_H
#define SHAKEDOWN_ANALYZER_CREEP_RELAXATION_H

#include "analyzer/curves.h"
#include "analyzer/quantity.h"

/* Fills creep.* of a stage of kind TEST_CREEP, relaxation.* of one of kind TEST_RELAXATION. */
void creep_relaxation_evaluate(const struct curves *curves, struct quantity *quantities);

#endif
