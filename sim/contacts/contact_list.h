/* Contacts: the lists of candidate pairs and wall contacts with their history. `n` is the
 * unit normal from j (or the wall) to i; forces act on i and, reversed, on j. */
#ifndef SHAKEDOWN_SIM_CONTACTS_CONTACT_LIST_H
#define SHAKEDOWN_SIM_CONTACTS_CONTACT_LIST_H

#include <stdint.h>

#include "common/scene.h"
#include "sim/base/thread_team.h"
#include "sim/grains/particles.h"
#include "sim/law/contact_history.h"
#include "sim/law/contact_law.h"

/* What kernels take at a time: a set, of two halves; and what a range of a list is made of, a span of particles, which
 * is wide in small samples in 2D. */
enum { SET_WIDTH = PARTICLES_BLOCK, HALF_WIDTH = 8, SPAN_WIDTH = 1024, WIDE_SPAN = 2048 };

/* Particles first ... last - 1, in whole sets, and the sets that are theirs: those of neighbours in the order, one
 * after the other, if there are any, from set `next` on; from `whole` on others of SET_WIDTH particles side by side;
 * and from `halves` to end - 1 those whose halves may stand apart. */
struct contact_span {
    int first, last;
    int next, whole, halves, end;
};

/* The kernels' order of a list, slot by slot; SET_WIDTH slots are a set. Pairs: a half of a set, in 3D a whole one,
 * belongs to particles that stand side by side, and its slot l holds a partner of the l-th, so that these are read and
 * summed without looking around; either member of a pair may be the one whose slot it is in. If most particles have a
 * candidate right behind them (neighbour_chains.h), these partners have sets of their own, each of SET_WIDTH particles
 * side by side, whose partners stand side by side as well. Walls: the members one after the other. Empty slots hold the
 * padding particle, which never touches, or partners out of reach. Double, or float if the contacts are mixed. */
struct contact_slots {
    struct contact_span *span; /* [n_spans] pairs */
    int n_spans, span_capacity;
    int capacity;      /* in sets */
    double unit;       /* of lengths as told [m]: mixed: the quantum (particles.h), a power of 2; else 1 */
    double force_unit; /* of forces as told [N]: particles->force_unit */
    uint32_t *first;   /* [2 n_sets] pairs: the first of the particles i of each half */
    uint32_t *partner; /* [slots] where the record of j starts [doubles]; walls: that of i */
    float *built[3];   /* mixed: x_i - x_j when the lists were built [unit]; not of walls */
    float *gap;        /* mixed: (a_i + a_j)^2 less that distance's square [unit^2]; of walls the overlap then [unit] */
    void *reach;       /* a_i + a_j [unit], walls a_i [m] */
    void *pair[PAIR_CONSTANTS];     /* of each contact; NULL: the normal law does not ask */
    void *history[HISTORY_COLUMNS]; /* of i against j, lengths in units; NULL: the model has no such column */
};

/* Candidates for contact, sorted by (i, j). Open candidates have zero history and force. The history belongs to the
 * slots as soon as the list is closed; until then, and after contact_list_read, the list has a copy in its own order.
 */
struct contact_list {
    int count, capacity;
    int32_t *i;                       /* [count] */
    int32_t *j;                       /* [count] other particle, i < j; in the list of a wall: particles->count */
    double *reach;                    /* a_i + a_j, walls a_i [m] */
    double *history[HISTORY_COLUMNS]; /* [count] a copy in the order of the list: contact_list_read */
    struct contact_model model;
    bool closed;              /* the kernels have the history */
    struct thread_team *team; /* that hands it over to the kernels; NULL: the caller alone */
    int search_max;   /* particles asked for room before a set is added (slot_assignment.h); 0: as many as ever pay */
    int n_sets;       /* that the kernels go through; set by contact_list_close */
    uint32_t *slot;   /* [count] where the kernels have it: twice the slot, 1 more if that is j's */
    int32_t *scratch; /* of contact_list_close */
    size_t scratch_size;
    struct contact_slots slots;
};

struct wall {
    int axis;      /* component of its normal */
    double inward; /* +1: lower wall, -1: upper wall: its normal into the box */
    double x, v;   /* coordinate and velocity along the axis at the current step [m, m/s] */
    double force;  /* of the particles on it, outward [N] */
    int touching;  /* and how many they are */
    double x_list; /* at the last rebuild of the lists */
    struct contact_list contacts;
};

/* Brings the members' history, or one column of it, up to date with what the kernels did; to be called before it is
 * read.
 */
void contact_list_read(struct contact_list *list);
void contact_list_read_column(struct contact_list *list, int c);

/* The copy of a column that the kernels have is not needed any more; its memory is given back. */
void contact_list_forget_column(struct contact_list *list, int c);

/* Column c of the history of member k as it is now, without contact_list_read; a spring (Mindlin: its
 * force) with what rounding left out; whether a contact slides. */
double contact_list_value(const struct contact_list *list, int c, int k);
double contact_list_whole(const struct contact_list *list, int c, int k); /* column c with its rest */
double contact_list_spring(const struct contact_list *list, int component, int k);
bool contact_list_slides(const struct contact_list *list, int k);

/* The history of member f of `from` becomes that of member t of `to`, a list of the same model; or none. For lists
 * that are read and not closed yet. */
void contact_list_carry(struct contact_list *to, int t, const struct contact_list *from, int f);
void contact_list_clear(struct contact_list *to, int t);

/* Hands the list over to the kernels: finds slots and copies the history there. To be called whenever i, j, reach or
 * the history have changed, with x_list of the particles and of the wall as they were built for. wall: NULL for pairs.
 * Errors: STATUS_NO_MEMORY. */
enum status contact_list_close(struct contact_list *list, const struct particles *particles,
                               const struct wall *wall) MUST_USE;

/* The same but for the history, which the caller is to write into every slot (history_transfer.h). */
enum status contact_list_place(struct contact_list *list, const struct particles *particles,
                               const struct wall *wall) MUST_USE;

/* Makes room for `capacity` members; contents are kept. */
enum status contact_list_reserve(struct contact_list *list, int capacity, int dimension) MUST_USE;
void contact_list_free(struct contact_list *list);

/* Room for `count` members of the working memory, of which the first `kept` keep what they are. Errors:
 * STATUS_NO_MEMORY. */
enum status contact_list_work(struct contact_list *list, size_t count, size_t kept) MUST_USE;

#endif
