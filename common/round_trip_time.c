#include "common/round_trip_time.h"

#include <math.h>

void round_trip_note(struct round_trip *trip, double sample_s)
{
    const double error_s = sample_s - trip->mean_s;
    if (trip->mean_s <= 0) {
        *trip = (struct round_trip){.mean_s = sample_s, .deviation_s = 0.5 * sample_s};
        return;
    }
    trip->deviation_s += 0.25 * (fabs(error_s) - trip->deviation_s);
    trip->mean_s += 0.125 * error_s;
}

double round_trip_late_s(const struct round_trip *trip, double low_s, double first_s, double high_s)
{
    if (trip->mean_s <= 0)
        return first_s;
    return fmax(low_s, fmin(trip->mean_s + 4 * trip->deviation_s, high_s));
}
