/* The search of pairs in reach among the particles of neighbouring cells, compiled for each instruction set
 * (search_tmpl.h); all find the same pairs in the same order. */
#ifndef SHAKEDOWN_SIM_NEIGHBOURS_PAIR_SEARCH_H
#define SHAKEDOWN_SIM_NEIGHBOURS_PAIR_SEARCH_H

#include "sim/lanes/instruction_set.h"
#include "sim/neighbours/cell_list.h"

/* Pairs found, lo < hi, in no particular order. */
struct pair_buffer {
    int count, capacity;
    int32_t *lo, *hi; /* [capacity + ARRAY_PADDING] */
};

/* Particles whose distances to those of one cell are looked at, side by side; positions are relative to the cell, so
 * that single precision is enough however large the sample is. */
struct search_block {
    int capacity;
    float *x[3];  /* [capacity] m */
    float *reach; /* radius and skin [m] */
    int32_t *id;
};

/* Appends every pair that is closer than both radii and `skin_m`, and few that are a millionth of a cell farther, for
 * the k-th of n pieces of the cells. `block`: search_block_reserve. Errors: STATUS_NO_MEMORY, STATUS_LIMIT (more
 * than 2^31 pairs). */
typedef enum status pair_search(const struct cell_list *cells, double skin_m, int k, int n, struct search_block *block,
                                struct pair_buffer *pairs);

/* to[s] = from[source[s] / 2], the other way round where source[s] is odd and `turns`, or 0 where source[s] < 0;
 * s = 0 ... count - 1. No overlap. */
typedef void transfer_doubles(double *to, const double *from, const int32_t *source, int count, bool turns);
typedef void transfer_floats(float *to, const float *from, const int32_t *source, int count, bool turns);

/* to[k] = value[i[k]] + value[j[k]]. */
typedef void add_values(double *to, const double *value, const int32_t *i, const int32_t *j, int count);

struct search {
    pair_search *pairs;
    transfer_doubles *transfer_doubles;
    transfer_floats *transfer_floats;
    add_values *add;
};

struct search search_select(enum instruction_set isa);

/* Room for what a cell may have around it, at most all `count` particles. Errors: STATUS_NO_MEMORY. */
enum status search_block_reserve(struct search_block *block, const struct cell_list *cells, int count) MUST_USE;
void search_block_free(struct search_block *block);

/* Room for `more` pairs and a vector beyond. Errors: as above. */
enum status pair_buffer_reserve(struct pair_buffer *pairs, int more) MUST_USE;
void pair_buffer_free(struct pair_buffer *pairs);

#endif
