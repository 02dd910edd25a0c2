/* Contacts: the lists of candidate pairs and wall contacts with their history, and the constants of the law. `n` is the
 * unit normal from j (or the wall) to i; forces act on i and, reversed, on j. */
#ifndef SHAKEDOWN_SIM_CONTACTS_H
#define SHAKEDOWN_SIM_CONTACTS_H

#include <stdint.h>

#include "common/scene.h"
#include "sim/particles.h"

/* One stage's law, ready for the kernels. */
struct contact_law_constants {
    double k1, k2, kc; /* N/m; linear law: k1 = k2, kc = 0 */
    double gamma_n;    /* kg/s */
    double mu_s, mu_d;
    double kt, inv_kt;    /* N/m, m/N */
    double gamma_t;       /* kg/s */
    double dt;            /* s; 0: forces are evaluated anew and no time passes */
    double k2_minus_k1;   /* k2 delta_0 = (k2 - k1) delta_max */
    double branch_ratio;  /* on the adhesion branch delta_max = branch_ratio delta; 0 if k1 = k2 */
    double loading_loss;  /* hysteresis loss per increase of delta_max^2: k1 (1 - k1/k2) / 2 */
    double adhesion_loss; /* and per decrease: kc (1 + kc/k2) ((k2 - k1)/(k2 + kc))^2 / 2 */
};

/* Energy lost in contacts since the start of the stage [J]. */
struct contact_losses {
    double hysteresis, viscous_normal, viscous_tangential, friction;
};

/* What kernels take at a time: a set; a range of a list is one of sets. */
enum { SET_WIDTH = 16 };

/* Candidates for contact with their history, sorted by (i, j). Open candidates have zero history and force. Arrays are
 * filled up to a whole set with pairs of the padding particles, which never touch. The kernels may keep the history
 * (history, spring, sliding) in an order of their own: contact_list_read brings it here, contact_list_close hands it
 * over. */
struct contact_list {
    int count, capacity;
    int n_sets;      /* that the kernels go through; set by contact_list_close */
    int32_t *i;      /* [count] */
    int32_t *j;      /* [count] other particle, i < j; in the list of a wall: the first padding particle */
    uint32_t *row_i; /* where the records of i and j start [doubles] */
    uint32_t *row_j;
    double *reach;     /* a_i + a_j [m] */
    double *history;   /* delta_max [m]; hysteretic law only */
    double *spring[3]; /* tangential spring at the middle of the step to come [m]: 1 component in 2D, 3 in 3D */
    double *sliding;   /* 1: slides, 0: sticks */
    bool keep_forces;  /* whether the kernels fill force and moment: only walls need them, measurements do not */
    double *force[3];  /* on i [N], dimension components */
    double *moment[3]; /* n x f_t [N]: torque on i is -a_i moment, on j -a_j moment; as many as spring */
    int n_springs;     /* 0 without friction */
    bool hysteretic;
};

struct wall {
    int axis;      /* component of its normal */
    double inward; /* +1: lower wall, -1: upper wall: its normal into the box */
    double x, v;   /* coordinate and velocity along the axis at the current step [m, m/s] */
    double force;  /* of the particles on it, outward [N] */
    double x_list; /* at the last rebuild of the lists */
    struct contact_list contacts;
};

/* Constants of a stage; dt is set by the caller at each force evaluation. */
struct contact_law_constants contact_law_constants_of(const struct scene_material *material);

/* Adds the losses of `lost` to `sum`. */
void contact_losses_add(struct contact_losses *sum, const struct contact_losses *lost);

/* Brings the members' history up to date with what the kernels did; to be called before it is read. */
void contact_list_read(struct contact_list *list);

/* The history of member f of `from` becomes that of member t of `to`, a list of the same model; or none. For lists
 * that are read and not closed yet. */
void contact_list_carry(struct contact_list *to, int t, const struct contact_list *from, int f);
void contact_list_clear(struct contact_list *to, int t);

/* Hands the list over to the kernels: completes the last set with padding pairs, particles->count and the one behind
 * it, and sets the rows. To be called whenever i, j or the history have changed. Errors: STATUS_NO_MEMORY. */
enum status contact_list_close(struct contact_list *list, const struct particles *particles) MUST_USE;

/* Makes room for `capacity` members; contents are kept. */
enum status contact_list_reserve(struct contact_list *list, int capacity, int dimension) MUST_USE;
void contact_list_free(struct contact_list *list);

#endif
