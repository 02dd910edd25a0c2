/* What the analyzer takes from one run.h5 (docs/file-format.md): the parameters, the scene in force and the
 * samples. Frames of particles and contacts are not read. */
#ifndef SHAKEDOWN_ANALYZER_RUN_FILE_H
#define SHAKEDOWN_ANALYZER_RUN_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/scene.h"
#include "common/status.h"

/* Width of one record of an observable in a run of dimension D. */
enum observable_shape { SHAPE_SCALAR, SHAPE_VECTOR, SHAPE_TENSOR }; /* 1, D, D x D */

/* id, name under /samples (the field of sample_t), shape */
#define OBSERVABLE_LIST(X)                                                                                             \
    X(STAGE, "stage", SHAPE_SCALAR)                                                                                    \
    X(STAGE_TIME, "stage_time_s", SHAPE_SCALAR)                                                                        \
    X(BOX_LENGTH, "box_length_m", SHAPE_VECTOR)                                                                        \
    X(STRESS_WALL, "stress_wall_pa", SHAPE_VECTOR)                                                                     \
    X(STRESS_CONTACT, "stress_contact_pa", SHAPE_TENSOR)                                                               \
    X(FABRIC, "fabric", SHAPE_TENSOR)                                                                                  \
    X(SOLID_FRACTION, "solid_fraction", SHAPE_SCALAR)                                                                  \
    X(COORDINATION, "coordination", SHAPE_SCALAR)                                                                      \
    X(COORDINATION_NO_RATTLERS, "coordination_no_rattlers", SHAPE_SCALAR)                                              \
    X(RATTLER_FRACTION, "rattler_fraction", SHAPE_SCALAR)                                                              \
    X(SLIDING_FRACTION, "sliding_fraction", SHAPE_SCALAR)                                                              \
    X(MAX_OVERLAP_RATIO, "max_overlap_ratio", SHAPE_SCALAR)                                                            \
    X(INERTIAL_NUMBER, "inertial_number", SHAPE_SCALAR)                                                                \
    X(ELASTIC_NORMAL, "elastic_energy_normal_j", SHAPE_SCALAR)                                                         \
    X(ELASTIC_TANGENTIAL, "elastic_energy_tangential_j", SHAPE_SCALAR)                                                 \
    X(KINETIC_ENERGY, "kinetic_energy_j", SHAPE_SCALAR)                                                                \
    X(WORK_WALLS, "work_walls_j", SHAPE_SCALAR)                                                                        \
    X(WORK_GRAVITY, "work_gravity_j", SHAPE_SCALAR)                                                                    \
    X(ENERGY_RESIDUAL, "energy_residual_j", SHAPE_SCALAR)                                                              \
    X(INTERFACE_RESIDUAL, "interface_residual_j", SHAPE_SCALAR)                                                        \
    X(CONTROLLER_RESIDUAL, "controller_residual_j", SHAPE_SCALAR)

enum observable {
#define OBSERVABLE_ENUM(id, name, shape) OBSERVABLE_##id,
    OBSERVABLE_LIST(OBSERVABLE_ENUM)
#undef OBSERVABLE_ENUM
        OBSERVABLES
};

/* What the simulator noted about its own run: dataset /notes, texts "stage;severity;text". */
struct run_note {
    char stage[128]; /* "": of the run */
    int severity;    /* 0 a note, 1 doubtful, 2 failed */
    char text[384];
};

enum { RUN_NOTES_MAX = 64 };

struct run {
    char name[256];
    char version[64];
    char kernel_set[128];
    char controller[512]; /* command of the program that set the targets in place of wallctl; "": wallctl */
    char reason[256];     /* why the simulator stopped; "" if it ended well, or if the run has no END */
    int64_t seed;
    int dimension;    /* D: 2 or 3 */
    int status;       /* of the simulator, a code of common/status.h; 0: it ended well, or there is no END */
    bool complete;    /* the recorder proved the run complete */
    double elapsed_s; /* wall-clock; NaN without END */
    int64_t steps;    /* step of the last sample; 0 without samples */
    struct scene *scene;
    size_t n_notes;
    struct run_note *note; /* [n_notes] */
    size_t n_samples;
    double *step;               /* [n_samples] */
    double *time_s;             /* [n_samples] */
    double *value[OBSERVABLES]; /* [n_samples][width] */
    size_t width[OBSERVABLES];
};

/* Reads `path`. `run` need not be initialised; on success release it with run_free.
 * An incomplete run (attribute complete other than 1) is read as far as all observables go. Of a run of an earlier
 * version, which has no controller_residual_j, that is NaN.
 * Errors, each naming file and object: STATUS_IO (cannot be opened), STATUS_FORMAT (not HDF5, truncated; a dataset or
 * an attribute is missing, of another shape, of an extent that the file cannot hold, or not finite where a number is
 * needed), STATUS_CONFIG (effective_config),
 * STATUS_NO_MEMORY. */
enum status run_read(struct run *run, const char *path) MUST_USE;

/* The same with assignments "analysis.KEY=VALUE" [n] on top of the configuration in force; STATUS_CONFIG for one that
 * is wrong. */
enum status run_read_set(struct run *run, const char *path, const char *const *settings, int n) MUST_USE;

/* Releases what `run` owns; harmless on a run that is all zero. */
void run_free(struct run *run);

/* Record `sample` of an observable: [width], in the units of sample_t. */
const double *run_record(const struct run *run, enum observable observable, size_t sample);

/* The index range [*begin, *end) of the samples of a stage (the longest contiguous one is all there is: stages run in
 * order). Empty if the stage has none. */
void run_stage_range(const struct run *run, int stage, size_t *begin, size_t *end);

#endif
