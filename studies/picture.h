/* Pictures of a frame. */
#ifndef SHAKEDOWN_STUDIES_PICTURE_H
#define SHAKEDOWN_STUDIES_PICTURE_H

#include <stdbool.h>

#include "common/status.h"
#include "studies/run_frame.h"

enum picture_kind {
    PICTURE_NETWORK,   /* 2D: contacts as lines, the wider and darker the stronger [LH fig. 1.3]; attraction in red */
    PICTURE_PARTICLES, /* 2D: particles, the lighter the more force is on them */
    PICTURE_SPHERES,   /* 3D, by POV-Ray */
};

/* Draws into BASE.svg and BASE.png; spheres into BASE.pov and BASE.png. `mean_n`: the force that is drawn as middling.
 * STATUS_IO, STATUS_NO_MEMORY. */
enum status picture_draw(const struct frame *frame, enum picture_kind kind, double mean_n, const char *base) MUST_USE;

/* Mean size of the normal forces of a frame. */
double picture_mean_force_n(const struct frame *frame);

/* Whether spheres can be drawn here. */
bool picture_has_renderer(void);

#endif
