/* Wall messages in the order in which they were sent: state 0, command 0, state 1, ... On the bus a command may come
 * before its state, and what was lost comes later (lcmtypes/CHANNELS.md). */
#ifndef SHAKEDOWN_RECORDER_WALL_ORDER_H
#define SHAKEDOWN_RECORDER_WALL_ORDER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/coupling.h"

/* Messages that wait for one before them: as many exchanges as a sender has on their way. */
enum { WALL_ORDER_WINDOW = 2 * WALLS_WINDOW };

struct wall_order {
    int64_t next; /* place of the one that is wanted: twice its seq, and one more for a command */
    struct {
        size_t size; /* 0: none */
        unsigned char data[WALL_MESSAGE_MAX];
    } waiting[WALL_ORDER_WINDOW]; /* by place, modulo the window */
};

enum wall_place {
    WALL_NEXT,     /* the one that is wanted: the caller uses it, and then those that waited for it */
    WALL_WAITS,    /* a copy was kept */
    WALL_REPEATED, /* was here before */
    WALL_TOO_EARLY /* beyond the window: nothing was kept */
};

/* Where a message stands. `order` starts as zero. */
enum wall_place wall_order_take(struct wall_order *order, bool command, int64_t seq, const void *data, size_t size);

/* A message that waited. */
struct wall_waiting {
    bool command;
    size_t size;
    const unsigned char *data; /* [size], until the next call */
};

/* The one that is next, if it is here: it counts as used. */
bool wall_order_next(struct wall_order *order, struct wall_waiting *message);

/* Gives up those that are missing before the first that waits; if none waits, those before state `seq`. false if there
 * was nothing to give up. */
bool wall_order_skip(struct wall_order *order, int64_t seq);

/* Which messages are here, as record_ack_t.walls_held says: bit 2k is the state, 2k+1 the command, of the k-th exchange
 * that is not used in full. */
uint32_t wall_order_held(const struct wall_order *order);

/* Exchanges that are used in full. */
int64_t wall_order_exchanges(const struct wall_order *order);

#endif
