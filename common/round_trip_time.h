/* How long an answer takes, measured: mean and mean deviation as in RFC 6298. */
#ifndef SHAKEDOWN_COMMON_ROUND_TRIP_TIME_H
#define SHAKEDOWN_COMMON_ROUND_TRIP_TIME_H

struct round_trip {
    double mean_s, deviation_s; /* 0: not measured yet */
};

/* Takes one more measurement; not of what was sent more than once, as nobody knows which of them was answered. */
void round_trip_note(struct round_trip *trip, double sample_s);

/* After how long without an answer something counts as lost: the mean and four deviations, within low_s ... high_s;
 * first_s as long as nothing was measured. */
double round_trip_late_s(const struct round_trip *trip, double low_s, double first_s, double high_s);

#endif
