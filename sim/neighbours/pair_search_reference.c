/* One candidate at a time. */
#include "sim/neighbours/pair_search.h"

/* As in search_avx512.c. No branch in the loop: what to keep cannot be predicted. */
static inline __attribute__((always_inline)) int search_emit(const struct search_block *block, const int dimension,
                                                             int a, int n, float skin, int32_t *lo, int32_t *hi)
{
    const float limit = block->reach[a] - skin;
    const int32_t id = block->id[a];
    int count = 0;
    for (int m = a + 1; m < n; m++) {
        float reach = block->reach[m] + limit, d2 = 0;
        for (int c = 0; c < dimension; c++) {
            float d = block->x[c][m] - block->x[c][a];
            d2 = c == 0 ? d * d : d2 + d * d;
        }
        int32_t other = block->id[m];
        lo[count] = other < id ? other : id;
        hi[count] = other < id ? id : other;
        count += d2 < reach * reach;
    }
    return count;
}

#define ISA reference
#include "sim/neighbours/pair_search_tmpl.h"
