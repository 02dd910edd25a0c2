/* Stress control of one degree of freedom (a wall, or a mirrored pair) over one exchange interval, by each scheme of
 * docs/coupling.md. */
#ifndef SHAKEDOWN_WALLCTL_STRESS_CONTROL_H
#define SHAKEDOWN_WALLCTL_STRESS_CONTROL_H

#include "common/scene.h"
#include "common/wall_dynamics.h"

/* What the motion over the coming interval is computed from; velocities and forces outward. */
struct stress_loop {
    double mass_kg, damping_kg_per_s;
    double stiffness_n_per_m, contact_damping_kg_per_s; /* bounds: how the sample's force answers a motion */
    double last_interval_s, interval_s;                 /* 0: no interval before */
    double ahead_s;                                     /* compensated: the force was told so long before the start */
    bool one_step;                                      /* the interval is a single time step: the exact loop */
    double velocity_m_per_s;                            /* mean over the last interval */
    double acceleration_m_per_s2;                       /* of the last interval, as commanded; 0: none to go on with */
    double force_n;                                     /* of the sample, at the start of the interval, or expected */
    double target_n;                                    /* target pressure times area, at the same time */
};

struct stress_motion {
    struct wall_motion motion;
    double force_n; /* of the sample, as the motion takes it: with what the scheme foresees of its answer */
};

/* enum coupling_scheme; SCHEME_IMPEDANCE has its loop in sim and is not for here. */
struct stress_motion stress_motion(int scheme, const struct stress_loop *loop);

/* The force [N] that is expected when it goes on as it went: `part` times the way from before_n to now_n beyond now_n.
 */
double stress_force_ahead_n(double before_n, double now_n, double part);

/* The longest interval [steps] at which the scheme is stable for a wall that pushes on a spring and a damper of the
 * bounds in `loop` (last_interval_s, interval_s, ahead_s, velocity, force and target are not used), found by trying the
 * scheme; at most `limit`, 0 if even a single step is not. */
int stress_stable_steps(const struct scene_coupling *coupling, const struct stress_loop *loop, double dt_s, int limit);

#endif
