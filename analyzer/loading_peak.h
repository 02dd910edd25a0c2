/* The peak of a curve of the loading branch. */
#ifndef SHAKEDOWN_ANALYZER_LOADING_PEAK_H
#define SHAKEDOWN_ANALYZER_LOADING_PEAK_H

#include "analyzer/loading_branch.h"

/* A maximum of a curve. */
struct loading_peak {
    double window[2];    /* of the fit that counts most */
    struct estimate eps; /* its place */
    struct estimate value;
    struct estimate along[LOADING_CURVES]; /* value of every curve there; the error includes that of the place */
    int at_end; /* 0: a true peak; 1: the curve still rises at the last sample; -1: falls from the first */
};

/* The maximum of curve `which` (local_peak_find), its rough place with half windows of 1/40 of the strain range. False
 * if there are too few samples. */
bool loading_peak_find(const struct loading *loading, enum loading_curve which, struct loading_peak *peak);

#endif
