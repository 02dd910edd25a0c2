#include "common/short_wait.h"

#include <math.h>

const double SHORT_WAIT_S = 1e-3;

/* A yield that nobody takes is over in less. Where others had more than this share over a window that is longer than a
 * slice of the scheduler, one sleeps, each time twice as long as the last if they still want the core then. */
static const double YIELD_S = 1e-5, SHARE_MAX = 0.25, WINDOW_S = 0.01, SLEEPS_MIN_S = 0.1, SLEEPS_MAX_S = 10;

bool short_wait_looks(const struct short_wait *wait, double now_s)
{
    return wait->last_s < SHORT_WAIT_S && now_s >= wait->sleeps_until_s;
}

void short_wait_note(struct short_wait *wait, double waited_s)
{
    wait->last_s = waited_s;
}

void short_wait_note_look(struct short_wait *wait, double look_s, double yield_s, double now_s)
{
    wait->looked_s += look_s + yield_s;
    wait->lost_s += yield_s > YIELD_S ? yield_s : 0;
    if (wait->looked_s < WINDOW_S)
        return;
    const bool wanted = wait->lost_s > SHARE_MAX * wait->looked_s;
    wait->sleeps_s = fmin(fmax(wait->sleeps_s, SLEEPS_MIN_S), SLEEPS_MAX_S);
    wait->sleeps_until_s = wanted ? now_s + wait->sleeps_s : 0;
    wait->sleeps_s *= wanted ? 2 : 0.5;
    wait->looked_s = wait->lost_s = 0;
}
