/* Large samples cut into blocks of particles that threads treat at the same time, without a sum in common. A block is
 * a few spans, compact in space (locality_order.h). The pairs in its slots may have partners outside, its halo: it has
 * copies of their records, taken before its pairs, and sums of forces for these copies, which are added to those of
 * the particles themselves when all blocks that have copies of them are done, in the order of the blocks. Blocks and
 * order depend on the sample alone, so that any number of threads gives the same bits. */
#ifndef SHAKEDOWN_SIM_SAMPLE_HALO_H
#define SHAKEDOWN_SIM_SAMPLE_HALO_H

#include <stdatomic.h>

#include "sim/base/thread_team.h"
#include "sim/contacts/contact_list.h"

struct halo_block {
    int first_span, last_span;
    int first_row; /* of its copies, behind which stands a padding particle of its own */
    int n, capacity;
    int32_t *of; /* [n] particles that have a copy */
    int n_parts, parts_capacity;
    int32_t *part; /* [n_parts] those whose sums this block adds to, its own ones among them */
    bool full;     /* no room for all its copies */
};

/* The particles of one span. */
struct halo_part {
    int first, last; /* of copies: range in halo.of and halo.copy */
    int blocks;      /* that add to their sums */
    int last_block;  /* only lent */
    atomic_int left; /* blocks that are still to do so */
};

struct halo {
    int n_blocks; /* 1: the sample in one go, without copies, as particles in no order in space are */
    int n_parts;
    struct halo_block *block; /* [blocks_max] */
    struct halo_part *part;   /* [n_parts] */
    int blocks_max, spans_per_block;
    int n_copies, capacity;
    int32_t *of, *copy; /* [n_copies] for each part the particle and the row of its copy, by blocks */
};

/* For particles in n_spans spans. Errors: STATUS_NO_MEMORY. */
enum status halo_init(struct halo *halo, int n_spans) MUST_USE;
void halo_free(struct halo *halo);

/* For a list of pairs that has just been closed: finds copies and lets slots point at them. The team may be NULL.
 * Errors: STATUS_NO_MEMORY. */
enum status halo_cut(struct halo *halo, struct thread_team *team, struct particles *particles,
                     struct contact_list *pairs) MUST_USE;

/* The copies of block b are brought up to date; the sums of all copies of the particles of part q are added up. */
void halo_fetch(const struct halo *halo, struct particles *particles, int b);
void halo_add(const struct halo *halo, struct particles *particles, int q);

#endif
