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
    double secant_e_pa, secant_g_pa; /* peak to peak: q over eps_zz, q over 2 (eps_zz - eps_xx), without their drift */
    double amplitude;                /* of eps_D, peak to peak, without its drift */
    double r_u;                      /* largest (p0 - p)/p0 in it, p0 of the stage's start */
    double damping_ratio;            /* area/(4 pi W), W = (peak to peak sigma_D)(peak to peak eps_D without drift)/8 */
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
    struct estimate exponent;      /* m of |rate| ~ N^m over the last three quarters, regression in double logarithm */
    double negligible;             /* rate below which there is no practical meaning */
    char range;                    /* of Werkmeister: 'A', 'B', 'C', or '?' */
    char range_criterion[200];     /* what decided that */
    size_t to_liquefaction;        /* first cycle with r_u of 0.95; 0: none */
    struct estimate factor, power; /* a, b of |eps_D(N)| = a N^b over all cycles, in double logarithm */
};

enum { CYCLES_LOOP_MIN = 8 };

/* Measures the finished cycles of a stage of kind TEST_CYCLIC; of another kind, or with no finished cycle, gives n = 0.
 * Trends and verdict are for shakedown.h. Release with cycles_free. STATUS_NO_MEMORY. */
enum status cycles_evaluate(struct cycles *cycles, const struct curves *curves) MUST_USE;

void cycles_free(struct cycles *cycles);

/* Fills the cycles.* of quantities[QUANTITIES]; with n = 0 they are undefined. */
void cycles_quantities(const struct cycles *cycles, const struct curves *curves, struct quantity *quantities);

/* One line per cycle. STATUS_IO. */
enum status cycles_write_csv(const struct cycles *cycles, const char *path) MUST_USE;

#endif
