/* One frame of a run: particles, box and contacts, as run.h5 has them (docs/file-format.md). */
#ifndef SHAKEDOWN_STUDIES_RUN_FRAME_H
#define SHAKEDOWN_STUDIES_RUN_FRAME_H

#include "common/status.h"

enum frame_moment { MOMENT_START, MOMENT_PEAK, MOMENT_END, MOMENTS };

struct frame_contact {
    int i, j;         /* particles; j < 0: wall */
    double normal[3]; /* from j to i */
    double force_n;   /* normal force, repulsion positive */
};

struct frame {
    int dimension;
    int n_particles, n_contacts;
    double *position_m; /* [n_particles][3] */
    double *radius_m;   /* [n_particles] */
    double *force_n;    /* [n_particles] sum of the sizes of normal forces on it */
    struct frame_contact *contact;
    double lower_m[3], upper_m[3]; /* the box */
    double strain;                 /* of the axial direction, from the first frame of the stage */
};

/* Reads one of three frames of a stage of PATH: its first one, the one nearest to the strain `peak` of direction `axis`
 * (NaN: there is none, STATUS_FORMAT), its last one. STATUS_IO, STATUS_FORMAT, STATUS_NO_MEMORY. On success release it
 * with frame_free. */
enum status frame_read(struct frame *frame, const char *path, int stage, int axis, double peak,
                       enum frame_moment moment) MUST_USE;

void frame_free(struct frame *frame);

#endif
