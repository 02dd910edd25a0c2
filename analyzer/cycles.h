/* Cyclic loading: accumulated strain, hysteresis loops, and whether the sample shakes down or ratchets.
 * Strains and stresses as in [D], but logarithmic: eps_D = eps_c - eps_o, sigma_D = (D-1)/D (sigma_c - sigma_o), c the
 * cycled axis, o the mean of the others, D the dimension: in 3D the 2(sigma_xx - sigma_yy)/3 of [D], in 2D the
 * conjugate (sigma_xx - sigma_zz)/2. */
#ifndef SHAKEDOWN_ANALYZER_CYCLES_H
#define SHAKEDOWN_ANALYZER_CYCLES_H

#include <stddef.h>

#include "analyzer/curves.h"
#include "analyzer/quantity.h"
#include "common/status.h"

enum cycles_verdict { VERDICT_UNDETERMINED, VERDICT_SHAKEDOWN, VERDICT_RATCHETING, VERDICT_COLLAPSE };

/* One cycle, from (k-1) t0 to k t0. The loop's numbers are NaN with fewer than CYCLES_LOOP_MIN samples in it. */
struct cycle {
    double eps_d, eps_v;         /* accumulated at its end */
    double rate_d, rate_v;       /* gained in it */
    double loop_area_j_per_m3;   /* area of the loop, closed by a straight line: loss per cycle and volume */
    double resilient_modulus_pa; /* (max - end of sigma_c - sigma_o) over (max - end of eps_c): the strain that comes
                                    back */
    double damping_ratio;        /* area/(4 pi W), W = (peak to peak sigma_D)(peak to peak eps_D without drift)/8 */
};

struct cycles {
    size_t n;            /* finished cycles */
    struct cycle *cycle; /* [n] */
    enum cycles_verdict verdict;
    double confidence;      /* 0 ... 1; NaN if undetermined */
    char criterion[200];    /* what decided */
    size_t first, last;     /* cycles (from 1) the rate is taken over: the second half */
    struct estimate rate_d; /* mean gain of eps_D per cycle there */
    struct estimate rate_v;
    struct estimate exponent;      /* m of |rate| ~ N^m there */
    struct estimate factor, power; /* a, b of |eps_D(N)| = a N^b over all cycles, in double logarithm */
};

enum { CYCLES_MIN = 8, CYCLES_LOOP_MIN = 8 };

/* Evaluates a stage of kind TEST_CYCLIC; of another kind, or with no finished cycle, gives n = 0. The verdict needs
 * CYCLES_MIN cycles and is, in this order,
 *   collapse:   |eps_D| reached 0.1, or the rate grows: exponent > 0 at 2 sigma and last quarter twice the one before;
 *   shakedown:  the rate is not distinguishable from 0 at 2 sigma, or it falls faster than 1/N at 2 sigma (then the
 * strain stays bounded); ratcheting: any other. Release with cycles_free. STATUS_NO_MEMORY. */
enum status cycles_evaluate(struct cycles *cycles, const struct curves *curves) MUST_USE;

void cycles_free(struct cycles *cycles);

/* Fills the cycles.* of quantities[QUANTITIES]; with n = 0 they are undefined. */
void cycles_quantities(const struct cycles *cycles, const struct curves *curves, struct quantity *quantities);

/* "shakedown" ...; NULL for VERDICT_UNDETERMINED. */
const char *cycles_verdict_name(enum cycles_verdict verdict);

/* One line per cycle. STATUS_IO. */
enum status cycles_write_csv(const struct cycles *cycles, const char *path) MUST_USE;

#endif
