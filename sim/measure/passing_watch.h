/* Sees particles that pass through each other: pairs that overlap deeply, and whose normal turns round meanwhile. */
#ifndef SHAKEDOWN_SIM_MEASURE_PASSING_WATCH_H
#define SHAKEDOWN_SIM_MEASURE_PASSING_WATCH_H

#include "sim/sample/sample.h"

/* The normal of such a pair may not turn by more than 90 degrees within so many steps: longer contacts are of particles
 * that roll about each other. */
enum { PASSING_WATCH_TURN_STEPS = 64 };

/* Pairs are followed from this overlap on, over the sum of their radii, which most contacts never have: those that pass
 * through at more than 0.67 of the sum of the radii are missed. */
static const double PASSING_WATCH_FOLLOWED = 0.05;

/* Particles that overlapped by a twentieth of the sum of their radii at the last look, by their ids, i < j. */
struct passing_pair {
    int32_t i, j;
    int64_t since;    /* step at which the normal was that: */
    double normal[3]; /* from j to i, of any length */
    double overlap;   /* the largest since, over the sum of the radii */
};

struct passing_watch {
    struct passing_pair *pair, *next; /* [capacity], in the order of the list; and the ones under construction */
    size_t n, n_next, capacity;
    int32_t *first, *before; /* [first_count] by id, the last pair with this i, [capacity] and the one before it; -1 */
    int first_count;
    int64_t passed;  /* so far */
    int32_t last[2]; /* ids of the last two that did, and the step at which it was seen */
    int64_t last_step;
};

/* A look, as part of overlaps_look: what has become of those that were followed; then every pair of the list that
 * overlaps by more than PASSING_WATCH_FOLLOWED, others at will, by its place in it and its overlap over the sum of the
 * radii; then the end of it. Positions are exported; the last step need not be complete. Between looks particles may
 * move by part of a radius. Errors: STATUS_NO_MEMORY.
 */
enum status passing_watch_begin(struct passing_watch *watch, const struct sample *sample) MUST_USE;
void passing_watch_add(struct passing_watch *watch, const struct sample *sample, int place, double overlap);
void passing_watch_end(struct passing_watch *watch);

/* Forgets who touched: the next look begins anew. */
void passing_watch_forget(struct passing_watch *watch);
void passing_watch_free(struct passing_watch *watch);

#endif
