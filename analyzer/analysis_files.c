#include "analyzer/analysis_files.h"

#include <ctype.h>
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

enum status analysis_write_all_curves(const struct analysis *analysis)
{
    char path[sizeof analysis->directory + 16];
    snprintf(path, sizeof path, "%s/curves.csv", analysis->directory);
    return curves_write_all_csv(&analysis->run, path);
}

enum status analysis_write_stage(const struct analysis *analysis)
{
    char name[128], path[sizeof analysis->directory + sizeof name + 32];
    snprintf(name, sizeof name, "%.120s", analysis->curves.protocol->name);
    for (char *c = name; *c; c++)
        if (!isalnum((unsigned char)*c) && *c != '-')
            *c = '_';
    snprintf(path, sizeof path, "%s/analysis-%s.json", analysis->directory, name);
    return report_json_write(analysis, path);
}
