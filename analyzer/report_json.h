/* analysis.json. Keys and meaning: docs/analysis.md. */
#ifndef SHAKEDOWN_ANALYZER_REPORT_JSON_H
#define SHAKEDOWN_ANALYZER_REPORT_JSON_H

#include <jansson.h>

#include "analyzer/analysis.h"
#include "common/status.h"

/* Writes the analysis to `path`, through a temporary file, so that a reader never sees half of it. STATUS_IO,
 * STATUS_NO_MEMORY. */
enum status report_json_write(const struct analysis *analysis, const char *path) MUST_USE;

/* {"value", "unit", "uncertainty", "window", "reason" or "note"}; what is undefined is null. New reference, NULL if out
 * of memory. */
json_t *report_json_quantity(enum quantity_id id, const struct quantity *quantity) MUST_USE;

/* A number, or null if it is not finite. New reference. */
json_t *report_json_number(double value) MUST_USE;

/* Sets `key` in `root`, with one object per dot in it; steals `value`, which may be NULL (that fails). -1 on failure.
 */
int report_json_set(json_t *root, const char *key, json_t *value) MUST_USE;

/* Writes any document as report_json_write does, and releases it; NULL counts as out of memory. */
enum status report_json_dump(json_t *document, const char *path) MUST_USE;

#endif
