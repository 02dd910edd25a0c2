/* The numbers of a study: of each run, of each cell (runs that differ by their seed alone), of tangents over cells, and
 * beside the paper. */
#ifndef SHAKEDOWN_STUDIES_RESULTS_H
#define SHAKEDOWN_STUDIES_RESULTS_H

#include <jansson.h>

#include "common/status.h"
#include "studies/execute.h"
#include "studies/plan.h"
#include "studies/study.h"

struct number {
    double value, uncertainty; /* NaN: none */
};

/* Mean, standard deviation (n - 1) and number of those that are defined. */
struct spread {
    double mean, sd;
    int n;
};

/* A cell of the grid. */
struct cell {
    int series;
    int level[STUDY_FACTORS_MAX];
    int *run; /* [n_runs] those that are done, by seed */
    int n_runs;
    struct spread *spread; /* [n_keys] */
};

enum tangent_key { TANGENT_TAN_PHI, TANGENT_FRICTION_ANGLE, TANGENT_COHESION, TANGENT_KEYS };

/* A common tangent: the cells that differ in the factor `along` alone. */
struct tangent {
    int evaluation;
    int cell;    /* the first of them */
    int *circle; /* [n_circles] cells */
    int n_circles;
    struct spread spread[TANGENT_KEYS]; /* over seeds, each fitted alone */
};

/* A published number beside ours. */
struct comparison {
    int paper;
    struct spread ours;
    bool found; /* the study has runs for it */
};

struct results {
    const struct study *study;
    const struct plan *plan;
    struct text_list key;  /* quantities and evaluations of single runs */
    struct text_list unit; /* of each key, "" if there is none */
    json_t **analysis;     /* [n_runs]; NULL: not done */
    struct number *number; /* [n_runs][n keys] */
    struct cell *cell;     /* in the order of the study file */
    int n_cells;
    struct tangent *tangent;
    int n_tangents;
    struct comparison *comparison; /* [n_paper] */
    double *score; /* [levels of study->score] root mean square of (ours - paper)/tolerance; NaN: nothing to compare */
    struct spread *scored; /* [n_scores][n_paper] ours, of each level */
    int n_scores;
};

/* Reads what is there of the runs that are done. On success release it with results_free. STATUS_NO_MEMORY, STATUS_IO,
 * STATUS_FORMAT. */
enum status results_make(struct results *results, const struct study *study, const struct plan *plan,
                         const struct outcome *outcome, const char *out) MUST_USE;

void results_free(struct results *results);

/* Text of a cell's levels: "p = 500 N/m², kc/k2 = 1"; leaves out the factors `without` and `nor` (NULL: none). */
void cell_text(const struct study *study, const struct cell *cell, const char *without, const char *nor, char *text,
               size_t size);

/* "NAME.KEY" and unit of a tangent's number. */
void tangent_key_text(const struct study *study, const struct tangent *tangent, enum tangent_key key, char *text,
                      size_t size);
const char *tangent_unit(enum tangent_key key);

/* The factor that study->score names; NULL if there is none. */
const struct study_factor *results_ranked(const struct study *study);

/* Index of a key, -1 if there is none. */
int results_key_find(const struct results *results, const char *key);

/* Mean, standard deviation and number of the finite ones. */
struct spread spread_of(const double *value, int n);

/* Standard error of the mean; NaN for n < 2. */
double spread_error(const struct spread *spread);

/* The line sigma_1 = a + b sigma_3 through n circles gives tan phi, phi [deg] and c [unit of the stresses]:
 * sin phi = (b - 1)/(b + 1), c = a (1 - sin phi)/(2 cos phi). Least squares for n > 2. NaN where there is none. */
void tangent_fit(const double *sigma_3, const double *sigma_1, int n, double number[TANGENT_KEYS]);

/* Slope of a straight line by least squares, with its standard error; NaN with fewer than 3 points. */
struct number slope_fit(const double *x, const double *y, int n);

/* Time in which a value comes to `target` (NaN: its last value): a straight line by least squares through the
 * logarithms of its largest distances between crossings; with fewer than 4 such swings, of all distances from the
 * largest to a fiftieth of it. tau and its standard error; NaN where there is no approach. */
struct number decay_fit(const double *time_s, const double *value, int n, double target);

#endif
