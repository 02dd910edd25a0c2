#include "recorder/wall_order.h"

#include <string.h>

_Static_assert(WALL_ORDER_WINDOW <= 32, "record_ack_t.walls_held has 32 bits");

enum wall_place wall_order_take(struct wall_order *order, bool command, int64_t seq, const void *data, size_t size)
{
    if (seq < order->next / 2)
        return WALL_REPEATED;
    if (seq - order->next / 2 >= WALLS_WINDOW || size == 0 || size > WALL_MESSAGE_MAX)
        return WALL_TOO_EARLY;
    const int64_t place = 2 * seq + command;
    if (place < order->next)
        return WALL_REPEATED;
    if (place == order->next) {
        order->next++;
        return WALL_NEXT;
    }
    const int64_t slot = place % WALL_ORDER_WINDOW;
    if (order->waiting[slot].size > 0)
        return WALL_REPEATED;
    order->waiting[slot].size = size;
    memcpy(order->waiting[slot].data, data, size);
    return WALL_WAITS;
}

bool wall_order_next(struct wall_order *order, struct wall_waiting *message)
{
    const int64_t slot = order->next % WALL_ORDER_WINDOW;
    *message = (struct wall_waiting){order->next % 2, order->waiting[slot].size, order->waiting[slot].data};
    if (message->size == 0)
        return false;
    order->waiting[slot].size = 0;
    order->next++;
    return true;
}

bool wall_order_skip(struct wall_order *order, int64_t seq)
{
    const int64_t before = order->next;
    for (int64_t place = before; place < before + WALL_ORDER_WINDOW; place++) {
        if (order->waiting[place % WALL_ORDER_WINDOW].size == 0)
            continue;
        order->next = place;
        return place > before;
    }
    if (seq > before / 2 && seq < INT64_MAX / 4)
        order->next = 2 * seq;
    return order->next > before;
}

uint32_t wall_order_held(const struct wall_order *order)
{
    const int64_t first = order->next / 2 * 2;
    uint32_t held = order->next > first; /* a state without its command */
    for (int64_t place = order->next; place < first + WALL_ORDER_WINDOW; place++) {
        if (order->waiting[place % WALL_ORDER_WINDOW].size > 0)
            held |= UINT32_C(1) << (place - first);
    }
    return held;
}

int64_t wall_order_exchanges(const struct wall_order *order)
{
    return order->next / 2;
}
