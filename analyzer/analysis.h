/* The analysis of one run: everything that is written about it. */
#ifndef SHAKEDOWN_ANALYZER_ANALYSIS_H
#define SHAKEDOWN_ANALYZER_ANALYSIS_H

#include "analyzer/curves.h"
#include "analyzer/cycles.h"
#include "analyzer/judgement.h"
#include "analyzer/quantity.h"
#include "analyzer/run_file.h"
#include "analyzer/stiffness.h"
#include "common/status.h"

struct analysis {
    char directory[1024];
    struct run run;
    struct curves curves; /* points into run.scene */
    struct cycles cycles;
    struct stiffness stiffness; /* empty unless the stage is a shear test */
    struct judgement judgement;
    struct quantity quantity[QUANTITIES];
};

/* Reads `directory`/run.h5 and evaluates it. Writes nothing. `analysis` need not be initialised; on success release it
 * with analysis_free. Errors: those of run_read, STATUS_NO_MEMORY, STATUS_USAGE (path too long). */
enum status analysis_make(struct analysis *analysis, const char *directory) MUST_USE;

void analysis_free(struct analysis *analysis);

#endif
