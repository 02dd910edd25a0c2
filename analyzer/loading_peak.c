#include "analyzer/loading_peak.h"

#include <math.h>
#include <string.h>

#include "analyzer/local_fit.h"

_Static_assert((int)LOADING_CURVES < (int)LOCAL_CURVES_MAX, "a peak has more curves than local_fit takes");

enum { SMOOTH_MIN = 9 };

static const double smooth_fraction = 1.0 / 40; /* half window over the strain range */

bool loading_peak_find(const struct loading *loading, enum loading_curve which, struct loading_peak *peak)
{
    struct local_curves curves = {.x = loading->eps, .n = loading->n, .count = 1, .y = {loading->y[which]}};
    struct local_peak found;
    if (loading->n < LOCAL_POINTS_MIN)
        return false;
    for (int k = 0; k < LOADING_CURVES; k++)
        curves.y[curves.count++] = loading->y[k];
    double span = loading->eps[loading->n - 1] - loading->eps[0];
    double narrow = fmax(span * smooth_fraction, span * SMOOTH_MIN / 2 / (double)loading->n);
    if (!local_peak_find(&curves, narrow, &found))
        return false;
    *peak = (struct loading_peak){.eps = found.place, .value = found.value[0], .at_end = found.at_end};
    memcpy(peak->window, found.window, sizeof peak->window);
    memcpy(peak->along, found.value + 1, sizeof peak->along);
    return true;
}
