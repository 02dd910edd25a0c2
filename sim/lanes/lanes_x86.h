/* What the lanes of AVX2 and AVX-512 have in common; each is compiled for its instruction set. */
#include <immintrin.h>
#include <stddef.h>
#include <stdint.h>

#define LANES_INLINE static inline __attribute__((always_inline))

LANES_INLINE void *lanes_sums(void *base, uint32_t row, int unit)
{
    return (char *)base + (size_t)unit * row;
}
/* Two rows, which are not the same one. */
LANES_INLINE void lanes_add_two_rows(void *base, const uint32_t *row, int unit, __m128 two)
{
    float *to = lanes_sums(base, row[0], unit), *and_to = lanes_sums(base, row[4], unit);
    const __m128 sum = _mm_loadh_pi(_mm_castsi128_ps(_mm_loadu_si64(to)), (const __m64 *)and_to) + two;
    _mm_storel_pi((__m64 *)to, sum);
    _mm_storeh_pi((__m64 *)and_to, sum);
}
