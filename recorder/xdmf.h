/* run.xdmf: tells ParaView (its Xdmf 3 reader and the one before) where in run.h5 the particles are. */
#ifndef SHAKEDOWN_RECORDER_XDMF_H
#define SHAKEDOWN_RECORDER_XDMF_H

#include "recorder/chunk_assembly.h"

/* Times of the frames so far; starts as zero. */
struct xdmf {
    double *time_s; /* [n_frames] */
    size_t n_frames, capacity;
};

enum status xdmf_frame_add(struct xdmf *xdmf, double time_s) MUST_USE;

/* Writes (or overwrites) `path`: a temporal collection of the frames as points with radius, mass, id, velocity and,
 * with friction, angular velocity; the numbers stay in run.h5 beside it. */
enum status xdmf_write(const struct xdmf *xdmf, const struct run_facts *facts, const char *path) MUST_USE;
void xdmf_free(struct xdmf *xdmf);

#endif
