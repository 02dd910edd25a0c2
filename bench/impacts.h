/* Impacts of one sphere with a wall, or of two spheres: what comes out, by us, by LAMMPS, and by closed forms. */
#ifndef SHAKEDOWN_BENCH_IMPACTS_H
#define SHAKEDOWN_BENCH_IMPACTS_H

#include <stdbool.h>

#include "common/status.h"
#include "sim/sample/sample.h"

enum { IMPACTS_MAX = 32 };

/* One impact. Pairs approach along x and slip along z; a sphere falls on the floor along -z and slips along x. Spins
 * are about y. */
struct impact {
    bool pair;
    int i, j; /* ids; j only of a pair */
    double radius_m[2], mass_kg[2];
    /* Before. */
    double normal_m_per_s;     /* approach */
    double slip_m_per_s;       /* of the contact points */
    double tangential_m_per_s; /* of the centre of i */
    double spin_rad_per_s;     /* of i */
    /* Found on the way, and after. */
    double peak_force_n, peak_overlap_m;
    double contact_s; /* from the start, where they touch, until they part; 0: not yet */
    double rebound_m_per_s, slip_after_m_per_s, tangential_after_m_per_s, spin_after_rad_per_s;
    double overlap_before_m, time_before_s; /* of the step before */
};

struct impacts {
    int count;
    struct impact impact[IMPACTS_MAX];
    double floor_m;
};

/* State of all grains, by id. */
struct impact_state {
    double time_s;
    const double *x[3], *v[3], *omega_y, *force[3]; /* [count] */
};

/* The impacts of a sample at its start: of pairs 0-1, 2-3 ..., or of each grain with the floor. STATUS_LIMIT if there
 * are too many. */
enum status impacts_of(struct impacts *impacts, const struct sample *sample, bool pairs) MUST_USE;

/* The state after a step; at the end the velocities that are left. */
void impacts_look(struct impacts *impacts, const struct impact_state *state);

/* Steps the sample to the end of its stage, walls at rest, and looks at every step. */
enum status impacts_run(struct impacts *impacts, struct sample *sample) MUST_USE;

/* The same sample by LAMMPS with this tangential style, in `folder`. STATUS_IO, STATUS_FORMAT. */
enum status impacts_run_lammps(struct impacts *impacts, const struct sample *sample, const char *tangential,
                               const char *folder, const char *name) MUST_USE;

/* Hertz's impact with the dashpot of Tsuji et al., in units of mass m, approach v, E* and R: m_ij x'' = -(4/3) E*
 * sqrt(R) x^(3/2) - gamma_n x'. Without loss in closed form (Johnson 1985), else the same equation integrated by steps
 * of a 20000th of the contact time (Runge-Kutta, fourth order). */
struct impact_theory {
    double contact_s, peak_overlap_m, peak_force_n;
    double push_per_mv; /* impulse of the pushing force over m_ij v: what friction can take part of */
};

struct impact_theory impact_theory_of(const struct impact *impact, const struct scene_material *material);

/* Reduced mass of an impact. */
double impact_mass_kg(const struct impact *impact);

/* Sliding from beginning to end: slip and spin of i afterwards, for rigid spheres (2/5 m a^2) and for these. False:
 * the slip does not last, and this is no solution. */
bool impact_sliding(const struct impact *impact, const struct impact_theory *theory, double mu, double *slip_m_per_s,
                    double *spin_rad_per_s);

#endif
