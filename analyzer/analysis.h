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

/* What is evaluated, and how, where that is not as the scene has it. */
struct analysis_choice {
    const char *stage;          /* its name; NULL: analysis.stage */
    const char *const *setting; /* [n_settings], "analysis.KEY=VALUE" */
    int n_settings;
};

/* Reads `directory`/run.h5 and evaluates it; `choice` NULL: as the scene has it. Writes nothing. `analysis` need not be
 * initialised; on success release it with analysis_free. Errors: those of run_read, STATUS_NO_MEMORY, STATUS_USAGE
 * (path too long, no such stage). */
enum status analysis_make(struct analysis *analysis, const char *directory,
                          const struct analysis_choice *choice) MUST_USE;

void analysis_free(struct analysis *analysis);

#endif
