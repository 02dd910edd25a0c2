/* Four contacts at a time with AVX2. */
#include <immintrin.h>
#include <stdint.h>

#define LANES 4
typedef __m256d real;
typedef __m256d mask;
typedef __m128i indices;

#define LANES_INLINE static inline __attribute__((always_inline))

LANES_INLINE real real_all(double x)
{
    return _mm256_set1_pd(x);
}
LANES_INLINE real real_load(const double *from)
{
    return _mm256_loadu_pd(from);
}
LANES_INLINE void real_store(double *to, real x)
{
    _mm256_storeu_pd(to, x);
}
LANES_INLINE indices indices_load(const int32_t *from)
{
    return _mm_loadu_si128((const __m128i *)from);
}
LANES_INLINE real real_gather(const double *base, indices at)
{
    return _mm256_i32gather_pd(base, at, 8);
}
LANES_INLINE real real_sqrt(real x)
{
    return _mm256_sqrt_pd(x);
}
LANES_INLINE mask mask_greater(real a, real b)
{
    return _mm256_cmp_pd(a, b, _CMP_GT_OQ);
}
LANES_INLINE mask mask_at_least(real a, real b)
{
    return _mm256_cmp_pd(a, b, _CMP_GE_OQ);
}
LANES_INLINE mask mask_and(mask a, mask b)
{
    return _mm256_and_pd(a, b);
}
LANES_INLINE real real_select(mask m, real a, real b)
{
    return _mm256_blendv_pd(b, a, m);
}
LANES_INLINE real real_larger(real a, real b) /* a > b ? a : b, also for NaN and zeros, as the reference */
{
    return _mm256_max_pd(a, b);
}
LANES_INLINE real real_smaller(real a, real b)
{
    return _mm256_min_pd(a, b);
}
LANES_INLINE double real_sum(real x)
{
    double lane[LANES];
    _mm256_storeu_pd(lane, x);
    return (lane[0] + lane[1]) + (lane[2] + lane[3]);
}
