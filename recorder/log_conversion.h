/* Recording from an LCM event log. */
#ifndef SHAKEDOWN_RECORDER_LOG_CONVERSION_H
#define SHAKEDOWN_RECORDER_LOG_CONVERSION_H

#include "recorder/record_receiver.h"

/* Takes all messages of the log at `path` and finishes the recording. STATUS_INCOMPLETE, with a readable run.h5, if the
 * log lacks messages of the run; STATUS_IO if it cannot be read or run.h5 cannot be written. */
enum status convert_log(struct record_receiver *recording, const char *path) MUST_USE;

/* The same into DIR/run.h5, whether it is there or not. */
enum status convert_into(const char *path, const char *directory, struct run_counts *counts) MUST_USE;

#endif
