/* Isotropic and oedometric compression. Definitions: docs/analysis.md. */
#ifndef SHAKEDOWN_ANALYZER_COMPRESSION_H
#define SHAKEDOWN_ANALYZER_COMPRESSION_H

#include "analyzer/curves.h"
#include "analyzer/quantity.h"

/* Fills bulk.*, jamming_fraction, coordination_end of an isotropic stage, oedometer.* of an oedometric one, and
 * compression.* of both. STATUS_NO_MEMORY. */
enum status compression_evaluate(const struct curves *curves, struct quantity *quantities) MUST_USE;

#endif
