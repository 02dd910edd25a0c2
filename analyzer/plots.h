/* Plots of one analysis: gnuplot scripts beside the CSV files, and the SVG and PNG that they make. */
#ifndef SHAKEDOWN_ANALYZER_PLOTS_H
#define SHAKEDOWN_ANALYZER_PLOTS_H

#include <stdio.h>

#include "analyzer/analysis.h"
#include "common/status.h"

/* Writes <stem>.gp into the run's directory and runs gnuplot on it, for the stems stress_strain, volumetric_strain,
 * fabric, and for cyclic loading loops, accumulation, accumulation_log. analysis_write must have been called. A stage
 * with fewer than 2 samples gets no plots. *n_made counts the plots. STATUS_IO: a script cannot be written, gnuplot is
 * not installed or fails. */
enum status plots_write(const struct analysis *analysis, int *n_made) MUST_USE;

/* Plots of all stages from a curves.csv that holds them: path (q against p) and whole_path (over time). STATUS_IO. */
enum status plots_write_path(const struct analysis *analysis) MUST_USE;

/* Runs `gnuplot <stem>.gp` in the directory and waits for it. STATUS_IO if it is not installed or fails. */
enum status plots_run(const char *directory, const char *stem) MUST_USE;

/* Writes a text in quotes `mark`: ' as gnuplot's scripts take it, in which nothing is carried out then, " as CSV does.
 * A line end becomes a space. */
void plots_quoted(FILE *out, const char *text, char mark);

#endif
