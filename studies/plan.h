/* What a study consists of: its runs, their scenes, and the preparations that runs share. */
#ifndef SHAKEDOWN_STUDIES_PLAN_H
#define SHAKEDOWN_STUDIES_PLAN_H

#include <stdbool.h>

#include "common/scene.h"
#include "common/status.h"
#include "studies/study.h"

enum { PLAN_NAME_MAX = 200, PLAN_HASH_MAX = 17 };

struct plan_run {
    int series;
    int level[STUDY_FACTORS_MAX]; /* of each factor of the series */
    int64_t seed;
    char name[PLAN_NAME_MAX];        /* of its folder in runs/ */
    char hash[PLAN_HASH_MAX];        /* of all settings in force, in hexadecimal digits */
    char preparation[PLAN_HASH_MAX]; /* the one that it starts from; "": none */
    double cost;                     /* steps times particles, at most */
    char *scene;                     /* text of its scene file */
};

struct plan_preparation {
    char hash[PLAN_HASH_MAX]; /* names its folder in prepared/ */
    double cost;
    char *scene;
};

struct plan {
    struct plan_run *run; /* [n_runs], in the order in which they are started */
    int n_runs;
    struct plan_preparation *preparation; /* [n_preparations] */
    int n_preparations;
};

/* Makes the list of runs. Runs come in an order in which as many as possible have preparations of their own, so that
 * few wait for each other. Reads the scenes. Errors: those of scene_load with the run's name; STATUS_CONFIG if two runs
 * would share a folder, or there is no such stage as `prepare`. On success release it with plan_free. */
enum status plan_make(struct plan *plan, const struct study *study) MUST_USE;

void plan_free(struct plan *plan);

/* Puts scene files and settings below `out`. What is there of runs whose settings have changed is removed first, so
 * that no number outlives its settings. STATUS_IO. */
enum status plan_write(const struct plan *plan, const char *out) MUST_USE;

/* Whether the run meets the condition: each of its factors that is named is at that level. A factor that the run's
 * series does not vary is not met. */
bool plan_run_meets(const struct study *study, const struct plan_run *run, const struct study_where *where);

#endif
