#include "analyzer/analysis_files.h"

#include <stdio.h>

#include "analyzer/report_json.h"

enum status analysis_write(const struct analysis *analysis)
{
    char path[sizeof analysis->directory + 16];
    snprintf(path, sizeof path, "%s/curves.csv", analysis->directory);
    TRY(curves_write_csv(&analysis->curves, path));
    if (analysis->stiffness.n > 0) {
        snprintf(path, sizeof path, "%s/stiffness.csv", analysis->directory);
        TRY(stiffness_write_csv(&analysis->stiffness, path));
    }
    if (analysis->curves.controls.kind == TEST_CYCLIC) {
        snprintf(path, sizeof path, "%s/cycles.csv", analysis->directory);
        TRY(cycles_write_csv(&analysis->cycles, path));
    }
    snprintf(path, sizeof path, "%s/analysis.json", analysis->directory);
    return report_json_write(analysis, path);
}
