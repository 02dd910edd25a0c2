#include "sim/neighbours/bisection.h"

static bool is_before(const double *x, int32_t a, int32_t b)
{
    return x[a] < x[b] || (x[a] == x[b] && a < b);
}

static void swap(int32_t *order, int a, int b)
{
    const int32_t other = order[a];
    order[a] = order[b];
    order[b] = other;
}

/* The middle one of the first, the middle and the last comes to the middle. */
static void order_three(const double *x, int32_t *order, int first, int middle, int last)
{
    if (is_before(x, order[middle], order[first]))
        swap(order, middle, first);
    if (is_before(x, order[last], order[middle]))
        swap(order, last, middle);
    if (is_before(x, order[middle], order[first]))
        swap(order, middle, first);
}

/* Hoare's selection: those that come before the k-th of order[first ... end - 1] stand before it then. */
static void select_first(const double *x, int32_t *order, int first, int end, int k)
{
    while (end - first > 2) {
        const int middle = first + (end - first) / 2;
        int a = first, b = end - 1;
        order_three(x, order, first, middle, end - 1);
        const int32_t pivot = order[middle];
        while (a <= b) {
            while (is_before(x, order[a], pivot))
                a++;
            while (is_before(x, pivot, order[b]))
                b--;
            if (a <= b)
                swap(order, a++, b--);
        }
        if (k <= b)
            end = b + 1;
        else if (k >= a)
            first = a;
        else
            return;
    }
    if (end - first == 2 && is_before(x, order[first + 1], order[first]))
        swap(order, first, first + 1);
}

static int longest_side(const struct particles *p, const int32_t *order, int first, int end)
{
    double longest = -1;
    int axis = 0;
    for (int c = 0; c < p->dimension; c++) {
        const double *x = p->x[c];
        double lo = x[order[first]], hi = lo;
        for (int k = first; k < end; k++) {
            lo = x[order[k]] < lo ? x[order[k]] : lo;
            hi = x[order[k]] > hi ? x[order[k]] : hi;
        }
        if (hi - lo > longest) {
            longest = hi - lo;
            axis = c;
        }
    }
    return axis;
}

static void bisect(const struct particles *p, int leaf, int32_t *order, int first, int end)
{
    const int leaves = (end - first + leaf - 1) / leaf;
    int left = 1;
    if (leaves < 2)
        return;
    while (2 * left < leaves)
        left *= 2;
    const int middle = first + left * leaf;
    select_first(p->x[longest_side(p, order, first, end)], order, first, end, middle);
    bisect(p, leaf, order, first, middle);
    bisect(p, leaf, order, middle, end);
}

void bisection_order(const struct particles *p, int leaf, int32_t *order)
{
    bisect(p, leaf, order, 0, p->count);
}
