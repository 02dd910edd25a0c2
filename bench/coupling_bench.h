/* What the parts of bench_coupling share: cases, points and their results. */
#ifndef SHAKEDOWN_BENCH_COUPLING_BENCH_H
#define SHAKEDOWN_BENCH_COUPLING_BENCH_H

#include <jansson.h>
#include <stdbool.h>

#include "bench/curve_errors.h"
#include "bench/trial_run.h"
#include "common/config_table.h"
#include "common/scene.h"
#include "common/status.h"

enum {
    COUPLING_POINTS_MAX = 64,
    COUPLING_ROUNDS_MAX = 9,
    COUPLING_TARGETS_MAX = 2,
    COUPLING_PATH_MAX = 1100,
    COUPLING_TEXT_MAX = 160
};

/* The error that counts for a case. */
enum coupling_measure { MEASURE_STRESS, MEASURE_EARLY, MEASURE_STRAIN };

/* At most `ratio` times the in-process time at an error of at most `error`. */
struct coupling_target {
    double error, ratio;
};

struct coupling_case {
    const char *name, *title, *file; /* file: below the folder of scenes */
    const char *override[2];         /* of preparation and test */
    int measure;
    double duration_s; /* of the last stage; 0: as in the scene */
    int steps_max;     /* of it; 0: any number */
    bool shipped;      /* only as the scene couples, and impedance at the same interval */
    int rounds;        /* timings of the points that come into question; the others are timed once */
    bool few;          /* intervals */
    struct coupling_target target[COUPLING_TARGETS_MAX];
};

/* One setting of the coupling. */
struct coupling_point {
    int scheme; /* enum coupling_scheme */
    int n;
    double tolerance; /* adaptive */
    bool ran, failed; /* failed: it ended otherwise than well or unstable; neither: not tried */
    int exit_code;
    char message[600];
    struct curve_errors errors;
    double ratio[COUPLING_ROUNDS_MAX]; /* time over that of the in-process run beside it */
    int n_ratios;
};

struct coupling_options {
    const char *bin, *scenes, *out, *only, *scheme, *json_path, *plot, *lock;
    const char *const *override; /* of all scenes, preparation and test */
    int n_overrides;
    bool quick, shipped;
};

/* A case at work. */
struct coupling_work {
    const struct coupling_case *at;
    const struct coupling_options *options;
    char folder[COUPLING_PATH_MAX], scene_path[COUPLING_PATH_MAX + 32], reference[COUPLING_PATH_MAX + 32];
    char checkpoint[CONFIG_STRING_MAX], shifted[CONFIG_STRING_MAX];
    struct scene *scene;
    struct scene_coupling own; /* the scene's */
    struct curve_errors floor;
    double reference_s; /* least time of the in-process run */
    int64_t steps;
    struct coupling_point point[COUPLING_POINTS_MAX];
    int n;
};

/* Sets `count` overrides of the trial for the point; text [4][COUPLING_TEXT_MAX] holds them. */
void coupling_point_override(const struct coupling_point *point, struct trial *trial, char text[][COUPLING_TEXT_MAX]);
void coupling_point_name(const struct coupling_point *point, char *text, size_t size);

/* The error that counts. */
double coupling_error(const struct coupling_case *at, const struct curve_errors *errors);
double coupling_median_ratio(const struct coupling_point *point);

/* Prepares the sample, or takes the one that is there; writes the scene of the last stage and the sample with one
 * particle shifted; runs the reference and the floor. */
enum status coupling_prepare(struct coupling_work *work) MUST_USE;
void coupling_free(struct coupling_work *work);

/* Runs the exact loop in process; the errors against the first such run, which stays as the reference. */
enum status coupling_run_reference(struct coupling_work *work, const char *folder,
                                   struct curve_errors *errors) MUST_USE;

/* Table on stdout, and the case as JSON. */
json_t *coupling_report(const struct coupling_work *work);

/* One line for each shipped scene on stdout: as it is coupled, and impedance beside. */
void coupling_shipped_report(const struct coupling_work *work, int n);

/* The table of hard cases on stdout and as JSON; from the sample of `work`. */
json_t *coupling_hard(const struct coupling_work *work);

/* Error against time of the cases in `cases`, by gnuplot; data and script stay in `folder`. */
enum status coupling_plot(const json_t *cases, const char *folder, const char *path) MUST_USE;

json_t *coupling_number(double value);

#endif
