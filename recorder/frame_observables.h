/* Which sample belongs to which frame: H5MD's observables are given at the frames, so that a reader of frames finds
 * there what its frame has. */
#ifndef SHAKEDOWN_RECORDER_FRAME_OBSERVABLES_H
#define SHAKEDOWN_RECORDER_FRAME_OBSERVABLES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

/* When something was. */
struct moment {
    int64_t step;
    int32_t stage;
};

struct moments {
    struct moment *at; /* [n], in the order of steps */
    int64_t n, room;
};

/* All that came so far; zeros: nothing. */
struct frame_observables {
    struct moments samples, frames;
    int64_t next; /* first frame whose sample was not yet asked for */
    int64_t near; /* samples up to here are not after that frame */
};

enum status frame_observables_sample(struct frame_observables *observed, struct moment moment) MUST_USE;
enum status frame_observables_frame(struct frame_observables *observed, struct moment moment) MUST_USE;

/* Gives the frames' samples in the order of frames, one a call: the row of the last sample that is not after the frame,
 * or of the first if all are. False: there is no more, or, unless `last`, the sample may still come. */
bool frame_observables_next(struct frame_observables *observed, bool last, int64_t *sample);

void frame_observables_free(struct frame_observables *observed);

#endif
