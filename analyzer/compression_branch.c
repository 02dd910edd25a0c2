#include "analyzer/compression_branch.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analyzer/local_fit.h"

static enum status allocate(struct compression_branch *branch, size_t n)
{
    memset(branch, 0, sizeof *branch);
    branch->y[0] = malloc((n + 1) * BRANCH_CURVES * sizeof **branch->y);
    if (!branch->y[0])
        return status_fail(STATUS_NO_MEMORY, "out of memory for %zu samples", n);
    for (int k = 1; k < BRANCH_CURVES; k++)
        branch->y[k] = branch->y[0] + (size_t)k * (n + 1);
    return STATUS_OK;
}

void compression_branch_free(struct compression_branch *branch)
{
    free(branch->y[0]);
    memset(branch, 0, sizeof *branch);
}

/* Samples [begin, end) with new extremes, largest ones or (sign -1) least ones. */
static void take(struct compression_branch *branch, const struct curves *curves, enum curve stress, enum curve strain,
                 size_t begin, size_t end, double sign)
{
    const enum curve from[BRANCH_CURVES] = {stress, strain, CURVE_SIGMA_XX, CURVE_VOID_RATIO, CURVE_SOLID_FRACTION};
    double s = -INFINITY, e = -INFINITY;
    for (size_t i = begin; i < end; i++) {
        const double here = sign * curves->column[stress][i], bent = sign * curves->column[strain][i];
        if (!(here > s) || !(bent > e + 1e-14)) /* rounding of lengths is no progress */
            continue;
        s = here;
        e = bent;
        for (int k = 0; k < BRANCH_CURVES; k++)
            branch->y[k][branch->n] = curves->column[from[k]][i];
        branch->n++;
    }
}

static void reverse(struct compression_branch *branch)
{
    for (int k = 0; k < BRANCH_CURVES; k++)
        for (size_t a = 0; a < branch->n / 2; a++) {
            const double keep = branch->y[k][a];
            branch->y[k][a] = branch->y[k][branch->n - 1 - a];
            branch->y[k][branch->n - 1 - a] = keep;
        }
}

enum status compression_branch_loading(struct compression_branch *branch, const struct curves *curves,
                                       enum curve stress, enum curve strain)
{
    TRY(allocate(branch, curves->n));
    take(branch, curves, stress, strain, 0, curves->n, 1);
    return STATUS_OK;
}

enum status compression_branch_unloading(struct compression_branch *branch, const struct curves *curves,
                                         enum curve stress, enum curve strain)
{
    const double *y = curves->column[stress];
    size_t top = 0, begin = 0, end = 0;
    double fall = 0;
    TRY(allocate(branch, curves->n));
    for (size_t i = 0; i < curves->n; i++) {
        if (y[i] > y[top])
            top = i;
        if (y[top] - y[i] > fall) {
            fall = y[top] - y[i];
            begin = top;
            end = i;
        }
    }
    if (end > begin && fall > 0.1 * y[begin])
        take(branch, curves, stress, strain, begin, end + 1, -1);
    reverse(branch);
    return STATUS_OK;
}

static bool end_at(const struct compression_branch *branch, bool upper, struct estimate *value, struct estimate *slope)
{
    const double *x = branch->y[BRANCH_STRAIN];
    const struct local_curves curves = {x, branch->n, 1, {branch->y[BRANCH_STRESS]}};
    return branch->n >= LOCAL_POINTS_MIN &&
           local_at(&curves, x[upper ? branch->n - 1 : 0], (x[branch->n - 1] - x[0]) / 2, value, slope);
}

bool compression_branch_secant(const struct compression_branch *branch, struct estimate *modulus)
{
    struct estimate low, high, slope;
    if (!end_at(branch, false, &low, &slope) || !end_at(branch, true, &high, &slope))
        return false;
    const double run = branch->y[BRANCH_STRAIN][branch->n - 1] - branch->y[BRANCH_STRAIN][0];
    *modulus = (struct estimate){(high.value - low.value) / run, hypot(low.error, high.error) / run};
    return true;
}

bool compression_branch_tangent(const struct compression_branch *branch, struct estimate *modulus)
{
    struct estimate value;
    return end_at(branch, true, &value, modulus);
}

bool compression_branch_log_slope(const struct compression_branch *branch, enum branch_curve y, double share,
                                  struct estimate *slope)
{
    const double *stress = branch->y[BRANCH_STRESS];
    size_t first = 0;
    while (first < branch->n && !(stress[first] > 0))
        first++;
    if (branch->n < first + 3)
        return false;
    const double bound = stress[first] * pow(stress[branch->n - 1] / stress[first], share);
    first = statistics_lower_bound(stress, branch->n, bound * (1 - 1e-12));
    const size_t n = branch->n - first;
    double *x = malloc(2 * (n + 1) * sizeof *x), *w = x + n + 1;
    if (!x)
        return false;
    for (size_t k = 0; k < n; k++)
        x[k] = log10(stress[first + k]);
    statistics_weights(x, w, n);
    const struct points points = {x, w, n};
    const bool good = statistics_slope(&points, branch->y[y] + first, slope);
    free(x);
    return good;
}
