/* Mohr-Coulomb from tests at several confining stresses: the common tangent of their circles. */
#ifndef SHAKEDOWN_ANALYZER_MOHR_H
#define SHAKEDOWN_ANALYZER_MOHR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "analyzer/ensemble.h"
#include "analyzer/statistics.h"
#include "common/status.h"

/* Principal stresses at a peak, the larger and the smaller one. */
struct mohr_circle {
    struct estimate major_pa, minor_pa;
};

struct mohr {
    size_t n;
    struct estimate friction_angle_deg, cohesion_pa; /* uncertainty from the scatter of the circles about the tangent */
    double friction_angle_own, cohesion_own; /* uncertainty that follows from the circles' own; NaN without these */
    double curvature_pa;                     /* 1/(d2 t/d s2); infinite for a straight envelope */
    bool curved;                             /* the envelope bends by more than twice the uncertainty of that */
    bool curvature_known;                    /* there are the 4 circles that it takes */
};

/* Common tangent t = s sin(phi) + c cos(phi) of circles with centres s = (major + minor)/2 and radii t = (major -
 * minor)/2, by least squares with errors in both: the weight of a circle is 1/var(t - s sin phi), iterated (York 1966).
 * Uncertainties: from the scatter, widened by Student's t of n - 2, and from the circles' own. False with fewer than 2
 * circles, or if their centres do not differ by 5 %. */
bool mohr_fit(struct mohr *mohr, const struct mohr_circle *circle, size_t n);

/* The circles of an ensemble's peaks; owned by the caller, NULL if there are none. STATUS_NO_MEMORY. */
enum status mohr_circles(const struct ensemble *ensemble, struct mohr_circle **circle, size_t *n) MUST_USE;

/* Fits the peaks of an ensemble if their confining stresses differ, and prints the result; with `directory` also writes
 * mohr.csv, mohr.json and mohr.gp there. *found: there was a series to fit. STATUS_IO, STATUS_NO_MEMORY. */
enum status mohr_report(FILE *out, const struct ensemble *ensemble, const char *directory, bool *found) MUST_USE;

#endif
