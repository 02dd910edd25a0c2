/* The particles as a structure of arrays. Components in the order of the scene's axes: 2D x, z; 3D x, y, z. */
#ifndef SHAKEDOWN_SIM_GRAINS_PARTICLES_H
#define SHAKEDOWN_SIM_GRAINS_PARTICLES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/scene.h"
#include "common/status.h"

struct particles {
    int count;
    int from;         /* first that drift and kick treat; 0 but in a part for a thread (threads.c) */
    int dimension;    /* components of x, v, a, force */
    int n_rotations;  /* components of omega: 0 without friction, 1 in 2D (about x cross z), 3 in 3D */
    int32_t *id;      /* [count] name of the particle in each slot; all else here is by slot (locality_order.h) */
    int32_t *slot;    /* [count] and the slot of each id */
    double *x[3];     /* [count] m; what is state goes into renumber.c too; mixed: as of particles_export_positions */
    double *v[3];     /* m/s; between drift and kick that at the middle of the step (mixed: out of date then) */
    double *a[3];     /* m/s^2, when the step is complete */
    double *omega[3]; /* rad/s; like v */
    double *alpha[3]; /* rad/s^2 */
    double *radius;   /* m */
    double *mass;     /* kg */
    double *inv_mass;
    double *inv_inertia; /* 1/(2/5 m a^2); only with rotations */
    double *x_list[3];   /* positions at the last rebuild of the lists */
    bool mixed;          /* contacts in float (mixed precision) */
    int n_padded;        /* of columns: whole vectors, and the padding particles behind them */
    int n_rows;          /* of records and rows of sums: n_padded, and room for copies behind them (halo.h) */
    void *record;        /* [n_rows][RECORD_STRIDE] what contacts need, side by side; made by drift */
    void *force;         /* sums of contact forces [N] and of moments n x f_t [N]: below; rows are zeroed by kick */
    double quantum;      /* mixed: the unit of u [m] */
    /* Single: what floats count velocities and forces in [m/s, N], powers of 2 that suit the sample, so that its size,
     * mass and pace are out of reach of float's range; rotations go in speed_unit/m, accelerations in speed_unit/s.
     * Double: 1. */
    double speed_unit, force_unit;
    /* Single, what the steps go on with: position x_list + quantum (u + u_rest), velocity v* + v_rest and rotation
     * omega* + omega_rest of the middle of the last step, with u and the predicted v* and omega* of the views: */
    float *u_rest[3], *v_rest[3], *omega_rest[3]; /* [count] quanta, speed_unit, speed_unit/m */
    /* As the contacts have them, double or float: */
    void *view;      /* the columns of the views, [n_padded] each, in blocks: below */
    void *view_v[3]; /* predicted velocities, made by drift */
    void *view_omega[3];
    /* With friction: what the mean of the predicted velocities at both ends of a step is short of that of the middle,
     * v(k+1/2) = (v*(k) + v*(k+1) + lag)/2; so contacts follow the particles exactly. Those of velocities, and then of
     * rotations; 3D, mixed: pairs (lanes_reference.h) of one of each. What a pair leaves out, at most 2^-7 of a lag, is
     * left to v* and omega*, whose own error is the lag of the next step. */
    void *view_lag[6];
    bool springs;       /* contacts have springs, for whose sake v* makes up for what pairs leave out */
    int32_t *view_u[3]; /* mixed: u; made by drift */
    void *view_radius;  /* with friction */
    void *view_inv_mass, *view_minus_lever; /* plain arrays [count]; minus_lever: -a/I */
};

/* Records, in doubles. 2D: [x0 x1 v0 v1], with friction [omega lag0 lag1 lag_omega]; 3D: [x0 x1 x2 lag0][v0 v1 v2
 * lag1], with friction [omega0 omega1 omega2 lag2][lag_omega0 lag_omega1 lag_omega2 -]. Single, in integers u
 * (position: x_list + u quantum) and floats: 2D [u0 u1 v0 v1], with friction [omega lag0 lag1 lag_omega]; 3D [u0 u1 u2
 * v0 v1 v2 omega0 omega1], with friction [omega2 lag0 lag1 lag2] of pairs, and a block of air. Sums, double
 * or float: first a row for each particle, 2D [f0 f1], with friction [f0 f1 moment -]; 3D [f0 f1 f2 -], with friction
 * [moment0 moment1 moment2 -]. Behind the n_rows rows a column of n_padded for each component of force and moment, in
 * blocks, for sums over particles side by side, which the kernel of the pairs starts anew. Torque = -a moment. */
#define RECORD_STRIDE(dimension, frictional, mixed)                                                                    \
    (((dimension) == 2 ? 4 : 8) * ((frictional) ? 2 : 1) / ((mixed) ? 2 : 1))
#define SUMS_BYTES(dimension, frictional, mixed)                                                                       \
    ((int)((dimension) == 2 ? ((frictional) ? 4 : 2) : ((frictional) ? 8 : 4)) * ((mixed) ? 4 : 8))
#define FORCE_MOMENT(dimension) ((dimension) == 2 ? 2 : 4)
/* Columns of view_lag. */
#define LAG_COLUMNS(dimension, mixed) ((dimension) == 3 && !(mixed) ? 6 : 3)
/* Columns in blocks: PARTICLES_BLOCK members of the first, then as many of the second, and so on, and then the next
 * members of the first: who goes over all columns at once reads one stream of memory. The CPU sees only some twenty
 * streams coming. Member i of a column is COLUMN_AT(columns, i) behind its first. */
enum { PARTICLES_BLOCK = 16 };
#define COLUMN_AT(columns, i)                                                                                          \
    ((size_t)(i) / PARTICLES_BLOCK * (PARTICLES_BLOCK * (size_t)(columns)) + (size_t)(i) % PARTICLES_BLOCK)
/* Components of omega with friction; how many columns views and sums have. */
#define ROTATIONS(dimension) ((dimension) == 2 ? 1 : 3)
#define VIEW_COLUMNS(dimension, frictional, mixed)                                                                     \
    ((dimension) * ((mixed) ? 2 : 1) + ((frictional) ? ROTATIONS(dimension) + LAG_COLUMNS(dimension, mixed) + 1 : 0))
#define SUMS_COLUMNS(dimension, frictional) ((dimension) + ((frictional) ? ROTATIONS(dimension) : 0))
/* Where the columns of sums start, in bytes. */
#define PARTICLES_COLUMNS_OFFSET(rows, dimension, frictional, mixed)                                                   \
    ((size_t)(rows)*SUMS_BYTES(dimension, frictional, mixed))

/* Samples from here on are large: they are cut for threads (threads.h). */
enum { PARTICLES_LARGE_SAMPLE = 10000, PARTICLES_PADDINGS = 8 };

/* Index of the padding particle, far from everything, that fills up sets of contacts. Large samples have
 * PARTICLES_PADDINGS of them, the k-th the k-th, and no two in one line of memory. */
int particles_padding(const struct particles *particles);
int particles_spare_padding(const struct particles *particles, int k);

/* Copies of particles behind all others, rows n_padded and on, which contacts take for others of the same kind:
 * room for so many rows in all, sums of forces in columns being lost; sums of `count` rows start from zero, and the
 * last of them is a padding particle; row `to` and on become copies of the `count` particles `of`, whose sums start
 * from zero; and the sums of `count` copies are added to those of `of`. Errors: STATUS_NO_MEMORY. */
enum status particles_reserve_rows(struct particles *particles, int rows) MUST_USE;
void particles_start_rows(struct particles *particles, int row, int count);
void particles_copy_rows(struct particles *particles, int to, const int32_t *of, int count);
void particles_add_rows(struct particles *particles, const int32_t *of, const int32_t *copy, int count);

/* Allocates `count` zeroed particles. Errors: STATUS_NO_MEMORY. */
enum status particles_init(struct particles *particles, int count, int dimension, bool rotations, bool mixed) MUST_USE;
void particles_free(struct particles *particles);

/* Size of particles->force [B]. */
size_t particles_force_size(const struct particles *particles);

/* Mass of a sphere [LH, D], also in 2D, and the moment of inertia (2/5) m a^2, from radius and density. */
void particles_set_mass(struct particles *particles, double density_kg_per_m3);

/* The lists are built for the positions as they are: x_list, and the quantum, so that u has room for 4 skins. The
 * records say so too. */
void particles_mark_listed(struct particles *particles, double skin_m);

/* Single: steps go on from x, v and omega as they are in double; or x is brought up to date with the steps. Else
 * nothing. */
void particles_import_state(struct particles *particles);
void particles_export_positions(struct particles *particles);

/* Component c of the velocity of particle i in the last step [m/s], be it complete or not: that at its middle or end;
 * mixed: as predicted for its end. */
double particles_velocity(const struct particles *particles, int c, int i);

/* Square of how far particle i is from where the lists were built [m^2]. */
double particles_moved2_m2(const struct particles *particles, int i);

/* How many columns the views have; and where member i of one is, in members from its first. */
int particles_view_columns(const struct particles *particles);
size_t particles_view_at(const struct particles *particles, int i);

/* Single: the units of velocity and force, from the mean radius and mass and a time of the sample, its time step. To be
 * called before there are views and histories. */
void particles_set_units(struct particles *particles, double time_s);

/* Single: the quantum for lists of this skin, and radii in float. */
void particles_set_views(struct particles *particles, double skin_m);

/* Inverse masses and moments of inertia from masses and radii. */
void particles_set_inverse(struct particles *particles);

/* Volume of all particles [m^3]; in 2D the area of the discs [m^2]. */
double particles_solid_volume(const struct particles *particles);

#endif
