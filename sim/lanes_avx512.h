/* Eight contacts at a time with AVX-512. */
#include <immintrin.h>
#include <stdint.h>

#define LANES 8
typedef __m512d real;
typedef __mmask8 mask;
typedef __m256i indices;

#define LANES_INLINE static inline __attribute__((always_inline))

LANES_INLINE real real_all(double x)
{
    return _mm512_set1_pd(x);
}
LANES_INLINE real real_load(const double *from)
{
    return _mm512_loadu_pd(from);
}
LANES_INLINE void real_store(double *to, real x)
{
    _mm512_storeu_pd(to, x);
}
LANES_INLINE indices indices_load(const int32_t *from)
{
    return _mm256_loadu_si256((const __m256i *)from);
}
LANES_INLINE real real_gather(const double *base, indices at)
{
    return _mm512_i32gather_pd(at, base, 8);
}
LANES_INLINE real real_sqrt(real x)
{
    return _mm512_sqrt_pd(x);
}
LANES_INLINE mask mask_greater(real a, real b)
{
    return _mm512_cmp_pd_mask(a, b, _CMP_GT_OQ);
}
LANES_INLINE mask mask_at_least(real a, real b)
{
    return _mm512_cmp_pd_mask(a, b, _CMP_GE_OQ);
}
LANES_INLINE mask mask_and(mask a, mask b)
{
    return a & b;
}
LANES_INLINE real real_select(mask m, real a, real b)
{
    return _mm512_mask_blend_pd(m, b, a);
}
LANES_INLINE real real_larger(real a, real b) /* a > b ? a : b, also for NaN and zeros, as the reference */
{
    return _mm512_max_pd(a, b);
}
LANES_INLINE real real_smaller(real a, real b)
{
    return _mm512_min_pd(a, b);
}
LANES_INLINE double real_sum(real x)
{
    double lane[LANES];
    _mm512_storeu_pd(lane, x);
    return ((lane[0] + lane[1]) + (lane[2] + lane[3])) + ((lane[4] + lane[5]) + (lane[6] + lane[7]));
}
