/* Stiffness and dilatancy along a loading branch: the degradation curve, and Rowe's stress-dilatancy. */
#ifndef SHAKEDOWN_ANALYZER_STIFFNESS_H
#define SHAKEDOWN_ANALYZER_STIFFNESS_H

#include "analyzer/loading_branch.h"
#include "analyzer/quantity.h"

enum { STIFFNESS_ROWS = 60 };

struct stiffness_row {
    double eps;        /* |axial strain|, in the measure of the report */
    double q_pa;       /* deviator since the start */
    double secant_pa;  /* of q over logarithmic axial strain */
    double tangent_pa; /* NaN where there are too few samples around */
    double ratio;      /* of the larger to the smaller stress */
    double dilatancy;  /* D = 1 - d eps_v/d eps_zz, in compression (Rowe 1962); NaN */
};

struct stiffness {
    size_t n;
    struct stiffness_row row[STIFFNESS_ROWS]; /* strains in a geometric series, up to the end of the loading */
};

/* Fills the rows, and rowe.K, rowe.friction_angle_deg and eps_zz_at_half_E of quantities[QUANTITIES]; uses the peak's
 * strain of them. */
void stiffness_evaluate(struct stiffness *stiffness, const struct curves *curves, const struct loading *loading,
                        struct quantity *quantities);

/* Writes `path` (stiffness.csv). STATUS_IO. */
enum status stiffness_write_csv(const struct stiffness *stiffness, const char *path) MUST_USE;

#endif
