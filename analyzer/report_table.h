/* The table of an analysis, for people. */
#ifndef SHAKEDOWN_ANALYZER_REPORT_TABLE_H
#define SHAKEDOWN_ANALYZER_REPORT_TABLE_H

#include <stdio.h>

#include "analyzer/analysis.h"

/* Prints the quantities that the test has, with a legend of the symbols. */
void report_table_print(FILE *out, const struct analysis *analysis);

#endif
