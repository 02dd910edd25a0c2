/* Recording from the bus: subscriptions, acknowledgements, timers. */
#ifndef SHAKEDOWN_RECORDER_LIVE_H
#define SHAKEDOWN_RECORDER_LIVE_H

#include "recorder/recording.h"

struct live_options {
    const char *lcm_url; /* NULL: the default */
    double
        timeout_s; /* the recorder gives up after so long without a sign of life, STATUS among them; may be INFINITY */
};

/* Records until the run is complete (STATUS_OK), a stop request or silence (STATUS_INCOMPLETE), or a failure of the
 * disk (STATUS_IO; the sender is told) or the bus. Finishes the recording in every case. */
enum status live_record(struct recording *recording, const struct live_options *options) MUST_USE;

#endif
