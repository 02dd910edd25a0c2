/* Recording from the bus: subscriptions, acknowledgements, timers. */
#ifndef SHAKEDOWN_RECORDER_BUS_RECORDING_H
#define SHAKEDOWN_RECORDER_BUS_RECORDING_H

#include "recorder/record_receiver.h"

struct bus_recording_options {
    const char *lcm_url; /* NULL: the default */
    double
        timeout_s; /* the recorder gives up after so long without a sign of life, STATUS among them; may be INFINITY */
};

/* Records until the run is complete (STATUS_OK), a stop request or silence (STATUS_INCOMPLETE), or a failure of the
 * disk (STATUS_IO; the sender is told) or the bus. Finishes the recording in every case. */
enum status bus_recording_record(struct record_receiver *recording,
                                 const struct bus_recording_options *options) MUST_USE;

#endif
