#include "analyzer/compression.h"

#include <math.h>

#include "analyzer/compression_branch.h"
#include "analyzer/local_fit.h"

static const double upper_half = 0.5;

static void set_over(struct quantity *quantity, bool good, struct estimate estimate,
                     const struct compression_branch *branch, double share)
{
    const double *stress = branch->y[BRANCH_STRESS];
    if (!good) {
        quantity_undefined(quantity, "the stage has no such branch of %d samples", (int)LOCAL_POINTS_MIN);
        return;
    }
    quantity_set(quantity, estimate);
    const double low = fmax(stress[0], 0), high = stress[branch->n - 1];
    quantity_window(quantity, low > 0 ? low * pow(high / low, share) : low, high);
    quantity_note(quantity, "window in Pa");
}

static struct estimate negative(struct estimate estimate)
{
    return (struct estimate){-estimate.value, estimate.error};
}

static void indices(const struct compression_branch *loading, const struct compression_branch *unloading,
                    struct quantity *q)
{
    struct estimate slope;
    bool good = compression_branch_log_slope(loading, BRANCH_VOID_RATIO, upper_half, &slope);
    set_over(&q[QUANTITY_CC], good, negative(slope), loading, upper_half);
    good = compression_branch_log_slope(unloading, BRANCH_VOID_RATIO, 0, &slope);
    set_over(&q[QUANTITY_CS], good, negative(slope), unloading, 0);
}

/* Solid fraction that is left at no pressure: from the unloading, or the loading if there is none. */
static void jamming(const struct compression_branch *loading, const struct compression_branch *unloading,
                    struct quantity *quantity)
{
    const struct compression_branch *branch = unloading->n >= LOCAL_POINTS_MIN ? unloading : loading;
    const double *p = branch->y[BRANCH_STRESS];
    const struct local_curves curves = {p, branch->n, 1, {branch->y[BRANCH_SOLID]}};
    struct estimate value, slope;
    const bool wide = branch->n >= LOCAL_POINTS_MIN && p[0] < 0.5 * p[branch->n - 1];
    if (!wide || !local_at(&curves, 0, p[branch->n - 1], &value, &slope)) {
        quantity_undefined(quantity, "the pressure does not change by a factor of 2 over %d samples",
                           (int)LOCAL_POINTS_MIN);
        return;
    }
    quantity_set(quantity, value);
    quantity_note(quantity, "extrapolated to p = 0 from %.4g Pa on the %s", p[0],
                  branch == unloading ? "unloading" : "loading");
}

static void isotropic(const struct curves *curves, const struct compression_branch *loading,
                      const struct compression_branch *unloading, struct quantity *q)
{
    struct estimate modulus;
    bool good = compression_branch_secant(loading, &modulus);
    set_over(&q[QUANTITY_K_LOADING], good, modulus, loading, 0);
    good = compression_branch_tangent(loading, &modulus);
    set_over(&q[QUANTITY_K_TANGENT], good, modulus, loading, 1);
    good = compression_branch_secant(unloading, &modulus);
    set_over(&q[QUANTITY_K_UNLOADING], good, modulus, unloading, 0);
    jamming(loading, unloading, &q[QUANTITY_JAMMING_FRACTION]);
    quantity_set(&q[QUANTITY_COORDINATION_END],
                 (struct estimate){curves->n ? curves->column[CURVE_COORDINATION][curves->n - 1] : NAN, NAN});
}

/* Mean of sigma_xx/sigma_zz over samples [begin, end) of a branch, over their stress. */
static void k0(const struct compression_branch *branch, size_t begin, size_t end, struct quantity *quantity)
{
    double ratio[64], deviation;
    const size_t n = end > begin ? end - begin : 0, groups = n < 64 ? n : 64;
    for (size_t g = 0; g < groups; g++) {
        const size_t k = begin + g * n / groups;
        ratio[g] = branch->y[BRANCH_LATERAL][k] / branch->y[BRANCH_STRESS][k];
    }
    if (groups < 3) {
        quantity_undefined(quantity, "the stage has no such branch");
        return;
    }
    const struct estimate mean = statistics_plain_mean(ratio, groups, &deviation);
    /* the ratio drifts along the branch: its scatter, not that of the mean, is what is not known */
    quantity_set(quantity, (struct estimate){mean.value, deviation});
    quantity_window(quantity, branch->y[BRANCH_STRESS][begin], branch->y[BRANCH_STRESS][end - 1]);
    quantity_note(quantity, "window in Pa; the uncertainty is the scatter along it");
}

static void oedometric(const struct compression_branch *loading, const struct compression_branch *unloading,
                       struct quantity *q)
{
    struct estimate modulus;
    bool good = compression_branch_secant(loading, &modulus);
    set_over(&q[QUANTITY_M_LOADING], good, modulus, loading, 0);
    good = compression_branch_tangent(loading, &modulus);
    set_over(&q[QUANTITY_M_TANGENT], good, modulus, loading, 1);
    good = compression_branch_secant(unloading, &modulus);
    set_over(&q[QUANTITY_M_UNLOADING], good, modulus, unloading, 0);
    const double *stress = loading->y[BRANCH_STRESS];
    const double middle = loading->n ? (stress[0] + stress[loading->n - 1]) / 2 : 0;
    k0(loading, statistics_lower_bound(stress, loading->n, middle), loading->n, &q[QUANTITY_K0_LOADING]);
    /* the last tenth of the unloading */
    k0(unloading, 0, unloading->n / 10 + (unloading->n >= 10 ? 1 : 0) + (unloading->n >= 3 ? 2 : 0),
       &q[QUANTITY_K0_UNLOADING]);
}

enum status compression_evaluate(const struct curves *curves, struct quantity *quantities)
{
    const bool isotropy = curves->controls.kind == TEST_ISOTROPIC;
    const enum curve stress = isotropy ? CURVE_P : CURVE_SIGMA_ZZ;
    const enum curve strain = isotropy ? CURVE_EPS_V_LOG : CURVE_EPS_ZZ_LOG;
    struct compression_branch loading, unloading;
    TRY(compression_branch_loading(&loading, curves, stress, strain));
    enum status status = compression_branch_unloading(&unloading, curves, stress, strain);
    if (status == STATUS_OK) {
        indices(&loading, &unloading, quantities);
        if (isotropy)
            isotropic(curves, &loading, &unloading, quantities);
        else
            oedometric(&loading, &unloading, quantities);
        compression_branch_free(&unloading);
    }
    compression_branch_free(&loading);
    return status;
}
