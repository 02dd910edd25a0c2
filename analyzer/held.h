/* Creep (stresses held) and relaxation (walls at rest). Definitions: docs/analysis.md. */
#ifndef SHAKEDOWN_ANALYZER_HELD_H
#define SHAKEDOWN_ANALYZER_HELD_H

#include "analyzer/curves.h"
#include "analyzer/quantity.h"

/* Fills creep.* of a stage of kind TEST_CREEP, relaxation.* of one of kind TEST_RELAXATION. */
void held_evaluate(const struct curves *curves, struct quantity *quantities);

#endif
