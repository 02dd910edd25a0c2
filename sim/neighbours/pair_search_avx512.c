/* Sixteen candidates at a time with AVX-512. */
#include <immintrin.h>

#include "sim/neighbours/pair_search.h"

/* Appends the pairs of member a of the block with members a + 1 ... n - 1 in reach; returns how many. Writes up to a
 * vector beyond them. */
static inline __attribute__((always_inline)) int search_emit(const struct search_block *block, const int dimension,
                                                             int a, int n, float skin, int32_t *lo, int32_t *hi)
{
    const __m512 limit = _mm512_set1_ps(block->reach[a] - skin);
    const __m512i id = _mm512_set1_epi32(block->id[a]);
    __m512 x[3];
    int count = 0;
    for (int c = 0; c < dimension; c++)
        x[c] = _mm512_set1_ps(block->x[c][a]);
    for (int m = a + 1; m < n; m += 16) {
        __m512 reach = _mm512_add_ps(_mm512_loadu_ps(block->reach + m), limit);
        __m512 d = _mm512_sub_ps(_mm512_loadu_ps(block->x[0] + m), x[0]), d2 = _mm512_mul_ps(d, d);
        for (int c = 1; c < dimension; c++) {
            d = _mm512_sub_ps(_mm512_loadu_ps(block->x[c] + m), x[c]);
            d2 = _mm512_add_ps(d2, _mm512_mul_ps(d, d));
        }
        __mmask16 there = n - m >= 16 ? 0xffff : (__mmask16)((1u << (n - m)) - 1);
        __mmask16 hit = _mm512_mask_cmp_ps_mask(there, d2, _mm512_mul_ps(reach, reach), _CMP_LT_OQ);
        __m512i other = _mm512_maskz_compress_epi32(hit, _mm512_loadu_si512(block->id + m));
        _mm512_storeu_si512(lo + count, _mm512_min_epi32(other, id));
        _mm512_storeu_si512(hi + count, _mm512_max_epi32(other, id));
        count += __builtin_popcount(hit);
    }
    return count;
}

#define ISA avx512
#include "sim/neighbours/pair_search_tmpl.h"
