/* Statistics over several runs. */
#ifndef SHAKEDOWN_ANALYZER_ENSEMBLE_H
#define SHAKEDOWN_ANALYZER_ENSEMBLE_H

#include <stdio.h>

#include "analyzer/analysis.h"
#include "analyzer/quantity.h"
#include "common/status.h"

/* One quantity over the runs that have it. */
struct ensemble_item {
    size_t n;
    struct estimate mean;      /* error: standard error over runs, sd/sqrt(n); NaN for n < 2 */
    double standard_deviation; /* over runs (n - 1); NaN for n < 2 */
    double within;             /* root mean square of the runs' own uncertainties; NaN if none has one */
};

struct ensemble_member {
    char directory[1024];
    char name[256];
    int64_t seed;
    bool complete;
    char verdict[16]; /* "" if there is none */
    double key_value; /* of a series' key, set by the caller; 0 */
    struct quantity quantity[QUANTITIES];
};

struct ensemble {
    size_t n;
    struct ensemble_member *member; /* [n], owned */
};

/* Adds what an ensemble needs of a run. `ensemble` starts as all zero. STATUS_NO_MEMORY. */
enum status ensemble_add(struct ensemble *ensemble, const struct analysis *analysis) MUST_USE;

void ensemble_free(struct ensemble *ensemble);

/* Statistics of one quantity; undefined values are left out, runs that are incomplete are not. STATUS_NO_MEMORY. */
enum status ensemble_item(const struct ensemble *ensemble, enum quantity_id id, struct ensemble_item *item) MUST_USE;

/* Writes `path` (ensemble.json). STATUS_IO, STATUS_NO_MEMORY. */
enum status ensemble_write(const struct ensemble *ensemble, const char *path) MUST_USE;

/* Prints the table for people. STATUS_NO_MEMORY. */
enum status ensemble_print(FILE *out, const struct ensemble *ensemble) MUST_USE;

#endif
