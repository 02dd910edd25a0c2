/* A study from its file to its report. */
#ifndef SHAKEDOWN_STUDIES_DRIVER_H
#define SHAKEDOWN_STUDIES_DRIVER_H

#include <stdbool.h>

#include "common/status.h"

enum { DRIVER_SET_MAX = 128 };

struct driver {
    const char *out; /* NULL: runs/study-NAME */
    const char *bin;
    const char *set[DRIVER_SET_MAX];
    int n_set;
    int jobs; /* 0: as many as there are cores, or as Slurm likes */
    bool slurm;
    const char *sbatch; /* more options of sbatch; "": none */
    bool report_only, pictures, list_only;
};

/* Runs the study in `file`. Also with failed runs the report is written; then STATUS_INCOMPLETE. */
enum status driver_run(const struct driver *driver, const char *file) MUST_USE;

#endif
