/* Whether to look for a message again and again, or to sleep until it comes. A core that sleeps takes tens of
 * microseconds to wake, on a virtual machine more than a whole exchange takes; looking costs the core. So waits that
 * are expected to be short look, as long as nobody else wants the core. */
#ifndef SHAKEDOWN_COMMON_SHORT_WAIT_H
#define SHAKEDOWN_COMMON_SHORT_WAIT_H

#include <stdbool.h>

/* A wait is short up to here [s]: waking adds less than a tenth to a longer one. */
extern const double SHORT_WAIT_S;

/* Zero to start with. */
struct short_wait {
    double last_s;           /* how long the last message was waited for */
    double looked_s, lost_s; /* lately: time spent looking, and of it what others had the core for */
    double sleeps_until_s;   /* others want the core; */
    double sleeps_s;         /* for so long at a time */
};

/* Whether a wait that begins now, or goes on, looks: the last one was short, and the core is to be had. */
bool short_wait_looks(const struct short_wait *wait, double now_s);

/* A message came, or did not within the limit, after `waited_s`. */
void short_wait_note(struct short_wait *wait, double waited_s);

/* One look took `look_s`, and offering the core to others then `yield_s`; until `now_s`. */
void short_wait_note_look(struct short_wait *wait, double look_s, double yield_s, double now_s);

#endif
