/* What LAMMPS and LIGGGHTS read: a packing and a script to step it. Both are told what our scene says as far as they
 * can model it, in the form that is fastest for them. */
#ifndef SHAKEDOWN_BENCH_PEERS_INPUT_H
#define SHAKEDOWN_BENCH_PEERS_INPUT_H

#include <stdbool.h>
#include <stdio.h>

#include "common/scene.h"
#include "sim/sample/sample.h"

enum peer { PEER_LAMMPS, PEER_LIGGGHTS };

/* LAMMPS: gran/hooke(/history), the plain style, whose damping is gamma x reduced mass; `granular`, slower, with
 * damping in kg/s as ours. LIGGGHTS: hooke/stiffness with absolute damping, as ours; `luding`, hysteretic, with a k2
 * that grows with the history and damping by a coefficient of restitution. Both: Hertz-Mindlin from E, nu and e. */
enum peer_law { PEER_HOOKE, PEER_GRANULAR, PEER_STIFFNESS, PEER_LUDING, PEER_HERTZ };

enum { PEER_STATES_MAX = 20 };

/* A state in which forces are evaluated: what changes in it against the state before. All lengths are changed about the
 * middle of the box. */
struct peer_state {
    const char *name;            /* NULL: forces are not compared */
    double strain;               /* of all distances, > 0: apart */
    double velocity_per_s[3][3]; /* gradient: v_c = sum over d of [c][d] (x_d - middle) */
    bool instant;                /* no time passes: histories stay */
    double mu;
};

struct peer_input {
    enum peer peer;
    enum peer_law law;
    int dimension;
    bool frictional;
    const char *data; /* the packing, as written by peers_write_data */
    const char *dump; /* NULL: none; else id, position and force of every particle after the last step, by id */
    double kn, gamma_n, kt, gamma_t, mu; /* N/m, kg/s; Luding: kn is k1 */
    double k2, kc;                       /* N/m, Luding's law; k2: the most that it grows to */
    double plasticity_depth;             /* Luding's law: phi_f */
    double youngs_modulus, poisson;      /* Hertz: Pa, 1 */
    const char *tangential;              /* Hertz in LAMMPS: its form of Mindlin's force */
    double restitution;                  /* Hertz, Luding's law; 1: no damping */
    double reduced_mass;                 /* kg, a typical one: for damping by mass */
    double gamma_b;                      /* kg/s, background; rotations are not damped, which no peer offers */
    double lo[3], hi[3];                 /* of the box [m], in our components: smooth walls by the same normal law */
    bool walls_move;                     /* LAMMPS only, 3D: six walls, each on a path of its own */
    double dt_s, skin_m;
    int delay; /* steps after a build of the lists without a look whether they hold */
    long warm_up, steps;
    int processes;                  /* ranks of MPI; 0, 1: without it */
    const struct peer_state *state; /* NULL: the packing is stepped; else nothing moves but as these states say, and */
    int n_states;                   /* the dump has a snapshot of each, with velocities, after one of the start */
};

/* The packing as a data file of atom style sphere (LIGGGHTS: granular). 2D: our components x, z become x, y, at z = 0.
 */
void peers_write_data(FILE *out, enum peer peer, const struct sample *sample);

void peers_write_script(FILE *out, const struct peer_input *input);

/* The coefficient of restitution by which LAMMPS' damping "tsuji" has the dashpot that gives the restitution e: it
 * takes a polynomial of Tsuji's for the mass of a particle, but the reduced mass with it. e: 0.12 to 1. */
double peers_tsuji_restitution(double e);

#endif
