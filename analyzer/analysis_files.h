/* The files of an analysis. */
#ifndef SHAKEDOWN_ANALYZER_ANALYSIS_FILES_H
#define SHAKEDOWN_ANALYZER_ANALYSIS_FILES_H

#include "analyzer/analysis.h"

/* Writes analysis.json, curves.csv and, where the test has them, cycles.csv or stiffness.csv into the run's directory.
 * STATUS_IO, STATUS_NO_MEMORY. */
enum status analysis_write(const struct analysis *analysis) MUST_USE;

/* Writes curves.csv again, with all stages. STATUS_IO, STATUS_NO_MEMORY. */
enum status analysis_write_all_curves(const struct analysis *analysis) MUST_USE;

/* Writes analysis-NAME.json, NAME that of the stage, signs that no file name should have replaced by "_". */
enum status analysis_write_stage(const struct analysis *analysis) MUST_USE;

#endif
