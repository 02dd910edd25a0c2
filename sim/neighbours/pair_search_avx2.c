/* Eight candidates at a time with AVX2. */
#include <immintrin.h>

#include "sim/neighbours/pair_search.h"

/* As in search_avx512.c. */
static inline __attribute__((always_inline)) int search_emit(const struct search_block *block, const int dimension,
                                                             int a, int n, float skin, int32_t *lo, int32_t *hi)
{
    const float limit = block->reach[a] - skin;
    const int32_t id = block->id[a];
    int count = 0;
    for (int m = a + 1; m < n; m += 8) {
        __m256 reach = _mm256_add_ps(_mm256_loadu_ps(block->reach + m), _mm256_set1_ps(limit)), d2;
        for (int c = 0; c < dimension; c++) {
            __m256 d = _mm256_sub_ps(_mm256_loadu_ps(block->x[c] + m), _mm256_set1_ps(block->x[c][a]));
            d2 = c == 0 ? _mm256_mul_ps(d, d) : _mm256_add_ps(d2, _mm256_mul_ps(d, d));
        }
        unsigned hit = (unsigned)_mm256_movemask_ps(_mm256_cmp_ps(d2, _mm256_mul_ps(reach, reach), _CMP_LT_OQ));
        for (hit &= n - m >= 8 ? 0xffu : (1u << (n - m)) - 1; hit; hit &= hit - 1) {
            int32_t other = block->id[m + __builtin_ctz(hit)];
            lo[count] = other < id ? other : id;
            hi[count++] = other < id ? id : other;
        }
    }
    return count;
}

#define ISA avx2
#include "sim/neighbours/pair_search_tmpl.h"
