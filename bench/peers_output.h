/* What LAMMPS and LIGGGHTS say: the time of the loop, and the state of every particle; and how far that is from ours.
 */
#ifndef SHAKEDOWN_BENCH_PEERS_OUTPUT_H
#define SHAKEDOWN_BENCH_PEERS_OUTPUT_H

#include "common/status.h"

/* Time per step [us] of the last run in a log of LAMMPS or LIGGGHTS ("Loop time of 0.5 on 1 procs for 1000 steps with
 * ..."), or of one of sim --progress ("sim: 1000 steps, 0.5 s, 500.00 us per step, ..."). STATUS_FORMAT if there is
 * none, if it was no step, or not of as many processes; ours is one process, whatever its threads. */
enum status peers_read_loop(const char *log, int processes, double *us_per_step) MUST_USE;

/* One line per particle, "id x y z fx fy fz" of ids 1 ... count in order, from the last snapshot of a dump's text; to
 * position and force [3 count]. STATUS_FORMAT names what is wrong. */
enum status peers_read_dump(const char *text, int count, double *position_m, double *force_n) MUST_USE;

/* The same from snapshot `snapshot` (0: the first) of lines "id x y z vx vy vz fx fy fz". */
enum status peers_read_snapshot(const char *text, int snapshot, int count, double *position_m, double *velocity_m_per_s,
                                double *force_n) MUST_USE;

/* |a - b| over all particles, [3 count] each. */
struct peers_difference {
    double largest, rms;
};
struct peers_difference peers_compare(const double *a, const double *b, int count);

#endif
