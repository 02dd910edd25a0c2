/* The report of a study: OUT/report.html with everything in it, and the same numbers and figures as files. It holds no
 * times of day and no durations: the same runs give the same report. */
#ifndef SHAKEDOWN_STUDIES_REPORT_H
#define SHAKEDOWN_STUDIES_REPORT_H

#include <stdbool.h>
#include <stdio.h>

#include "common/status.h"
#include "studies/execute.h"
#include "studies/plan.h"
#include "studies/results.h"
#include "studies/study.h"

struct report {
    const struct study *study;
    const struct plan *plan;
    const struct outcome *outcome;
    const char *out;     /* folder of the study */
    const char *command; /* that makes the study */
    bool pictures;       /* also draw frames of the first run of each cell */
};

/* Evaluates what is done and writes report.html, results.json, runs.csv, cells.csv, comparison.csv and figures/. Prints
 * the comparison, or the cells, for people. STATUS_IO, STATUS_NO_MEMORY, STATUS_FORMAT, STATUS_CONFIG. */
enum status report_write(const struct report *report) MUST_USE;

/* Parts of it. */
enum status report_json_write(const struct report *report, const struct results *results) MUST_USE;
enum status report_csv_write(const struct report *report, const struct results *results) MUST_USE;
enum status report_html_write(const struct report *report, const struct results *results) MUST_USE;

/* Draws the pictures and prints them as a part of the page. */
enum status report_pictures_print(FILE *out, const struct report *report, const struct results *results) MUST_USE;

/* A text with what HTML needs escaped. */
void report_text_print(FILE *out, const char *text);

/* "723 ± 9": the spread with two digits, the mean to the same place. "–" if there is none. */
const char *report_spread_text(const struct spread *spread, char *text, size_t size);

/* What the analysis of a run says about it: verdict and reasons, notes of quantities; into `text`. */
void report_notes_text(const json_t *analysis, char *text, size_t size);

/* The verdict alone; "" if the analysis has none. */
const char *report_verdict(const json_t *analysis);

#endif
