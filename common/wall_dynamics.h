/* How a wall moves under a force, m dv/dt = net - gamma v [LH eq. 1.2]: shared by the controller, which closes the loop
 * from exchange to exchange, and by sim, which closes it in every step when the command is an impedance. */
#ifndef SHAKEDOWN_COMMON_WALL_DYNAMICS_H
#define SHAKEDOWN_COMMON_WALL_DYNAMICS_H

/* v(t) = velocity + acceleration t over an interval */
struct wall_motion {
    double velocity_m_per_s, acceleration_m_per_s2;
};

/* Velocity after the time t under a constant net force: exact, and so right for m -> 0 and gamma -> 0 as well. */
double wall_velocity_after(double mass_kg, double damping_kg_per_s, double t_s, double velocity_m_per_s, double net_n);

/* The exact loop, one step: staggered leapfrog. `last` is the mean velocity over the last interval, net_n the force at
 * the moment between it and the next one; intervals in s. The velocity over the next interval is the straight line
 * through the means of both at their middles, so that contacts see it with second order. */
struct wall_motion wall_motion_step(double mass_kg, double damping_kg_per_s, double last_interval_s, double interval_s,
                                    double last_m_per_s, double net_n);

#endif
