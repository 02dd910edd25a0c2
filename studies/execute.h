/* Executors: they get runs done, each tried twice at most. */
#ifndef SHAKEDOWN_STUDIES_EXECUTE_H
#define SHAKEDOWN_STUDIES_EXECUTE_H

#include <stdbool.h>

#include "common/status.h"
#include "studies/plan.h"

enum { EXECUTE_TRIES = 2 };

struct execution {
    const struct plan *plan;
    const char *out;    /* folder of the study; absolute */
    const char *bin;    /* folder of the programs; absolute */
    int jobs;           /* at a time; slurm: 0: as Slurm likes */
    const char *sbatch; /* slurm: more options of sbatch, separated by blanks; "": none */
};

/* What became of a run. */
struct outcome {
    bool done;
    int tries;    /* of this call; 0: it was there already */
    char *reason; /* of a run that failed; owned */
};

/* Runs what is not done yet in processes on this machine. `outcome` [n_runs] is zero before; release it with
 * outcomes_free. A run that fails twice does not stop the others and is no error. STATUS_INTERRUPTED on SIGINT or
 * SIGTERM, once all have stopped; STATUS_IO, STATUS_NO_MEMORY. */
enum status execute_local(const struct execution *execution, struct outcome *outcome) MUST_USE;

/* The same as a job array of Slurm, and a second one of what failed. The array that a killed study has left in the
 * queue is waited for first. STATUS_INTERRUPTED on SIGINT or SIGTERM, with the array cancelled; STATUS_IO if a command
 * of Slurm fails. */
enum status execute_slurm(const struct execution *execution, struct outcome *outcome) MUST_USE;

void outcomes_free(struct outcome *outcome, int n);

/* Notes whether run k is done, else why it failed. */
enum status outcome_judge(const struct execution *execution, int k, struct outcome *outcome) MUST_USE;

#endif
