/* Loading and unloading branches of a compression, over its stress. */
#ifndef SHAKEDOWN_ANALYZER_COMPRESSION_BRANCH_H
#define SHAKEDOWN_ANALYZER_COMPRESSION_BRANCH_H

#include <stdbool.h>
#include <stddef.h>

#include "analyzer/curves.h"
#include "analyzer/statistics.h"
#include "common/status.h"

enum branch_curve { BRANCH_STRESS, BRANCH_STRAIN, BRANCH_LATERAL, BRANCH_VOID_RATIO, BRANCH_SOLID, BRANCH_CURVES };

/* Samples in the order of rising stress and strain, both strictly. */
struct compression_branch {
    size_t n;
    double *y[BRANCH_CURVES]; /* [n] each; one block, owned by y[0] */
};

/* The first loading: the samples at which `stress` and `strain` (curves) are larger than ever before, so that what is
 * unloaded and reloaded between them is left out. Release with compression_branch_free. STATUS_NO_MEMORY. */
enum status compression_branch_loading(struct compression_branch *branch, const struct curves *curves,
                                       enum curve stress, enum curve strain) MUST_USE;

/* The longest unloading: from a largest stress to the least one after it, the pair with the largest difference; samples
 * at which both are smaller than ever in it. Empty if the stress falls by less than a tenth of its largest value. */
enum status compression_branch_unloading(struct compression_branch *branch, const struct curves *curves,
                                         enum curve stress, enum curve strain) MUST_USE;

void compression_branch_free(struct compression_branch *branch);

/* Stress over strain between the ends of the branch, each from the samples around it; the slope at the end of highest
 * stress; dy/dlog10(stress) for stresses of at least `share` of the way from the lowest to the highest one, in the
 * logarithm. False with too few samples. */
bool compression_branch_secant(const struct compression_branch *branch, struct estimate *modulus);
bool compression_branch_tangent(const struct compression_branch *branch, struct estimate *modulus);
bool compression_branch_log_slope(const struct compression_branch *branch, enum branch_curve y, double share,
                                  struct estimate *slope);

#endif
