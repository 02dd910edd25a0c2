#include "sim/neighbours/neighbour_chains.h"

#include <stdlib.h>
#include <string.h>

/* Large samples: places of the order that a path stays within, the box of a span. */
enum { STRETCH = SPAN_WIDTH };

struct walk {
    int n;
    int stretch;              /* places that paths stay within */
    int32_t *rank;            /* [n] place in the order that is there already; -1: passed */
    int32_t *left;            /* [n] partners that are not passed yet */
    int32_t *first, *partner; /* [n + 1], [2 pairs] partners of q: partner[first[q]] ... partner[first[q + 1] - 1] */
    int32_t *path, *back;     /* [n] */
};

static bool within_reach(const struct walk *w, int i, int j)
{
    return w->rank[i] / w->stretch == w->rank[j] / w->stretch;
}

static void find_partners(struct walk *w, const struct contact_list *pairs)
{
    int32_t *next = w->path; /* only lent */
    for (int k = 0; k < pairs->count; k++) {
        const bool counts = within_reach(w, pairs->i[k], pairs->j[k]);
        w->left[pairs->i[k]] += counts;
        w->left[pairs->j[k]] += counts;
    }
    w->first[0] = 0;
    for (int q = 0; q < w->n; q++)
        w->first[q + 1] = (next[q] = w->first[q]) + w->left[q];
    for (int k = 0; k < pairs->count; k++) {
        if (!within_reach(w, pairs->i[k], pairs->j[k]))
            continue;
        w->partner[next[pairs->i[k]]++] = pairs->j[k];
        w->partner[next[pairs->j[k]]++] = pairs->i[k];
    }
}

static void pass(struct walk *w, int q)
{
    w->rank[q] = -1;
    for (int m = w->first[q]; m < w->first[q + 1]; m++)
        w->left[w->partner[m]]--;
}

/* Where to go from q: to who has the fewest partners left, as it would be left alone soonest, and among them to where
 * the order is most behind. -1: nowhere. */
static int next_of(const struct walk *w, int q)
{
    int best = -1;
    int64_t least = INT64_MAX;
    for (int m = w->first[q]; m < w->first[q + 1]; m++) {
        const int to = w->partner[m];
        const int64_t key = (int64_t)w->left[to] << 32 | w->rank[to];
        if (w->rank[to] >= 0 && key < least) {
            least = key;
            best = to;
        }
    }
    return best;
}

/* From q, which is passed, as far as it goes; q itself is not in the path. */
static int go(struct walk *w, int q, int32_t *path)
{
    int length = 0;
    while ((q = next_of(w, q)) >= 0) {
        pass(w, q);
        path[length++] = q;
    }
    return length;
}

/* Both ways from each particle that no path has passed. */
static void go_everywhere(struct walk *w, const int32_t *start, int32_t *order)
{
    int done = 0;
    for (int k = 0; k < w->n; k++) {
        const int q = start[k];
        if (w->rank[q] < 0)
            continue;
        pass(w, q);
        const int on = go(w, q, w->path), back = go(w, q, w->back);
        for (int m = back - 1; m >= 0; m--)
            order[done++] = w->back[m];
        order[done++] = q;
        memcpy(order + done, w->path, (size_t)on * sizeof *order);
        done += on;
    }
}

enum status neighbour_chains_order(const struct contact_list *pairs, int n, int32_t *order)
{
    const size_t size = (size_t)n, total = 6 * size + 1 + 2 * (size_t)pairs->count;
    int32_t *memory = calloc(total, sizeof *memory), *start = memory;
    if (!memory)
        return status_fail(STATUS_NO_MEMORY, "no memory for a new order of the particles");
    const int stretch = n < PARTICLES_LARGE_SAMPLE ? n : STRETCH;
    struct walk w = {
        .n = n, .stretch = stretch, .rank = memory + size, .left = memory + 2 * size, .path = memory + 3 * size};
    w.back = memory + 4 * size;
    w.first = memory + 5 * size;
    w.partner = w.first + size + 1;
    memcpy(start, order, size * sizeof *start);
    for (int k = 0; k < n; k++)
        w.rank[start[k]] = k;
    find_partners(&w, pairs);
    go_everywhere(&w, start, order);
    free(memory);
    return STATUS_OK;
}
