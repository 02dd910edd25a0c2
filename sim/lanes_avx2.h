/* Four contacts at a time with AVX2. */
#include <immintrin.h>
#include <stdbool.h>
#include <stddef.h>
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
LANES_INLINE bool mask_all(mask m)
{
    return _mm256_movemask_pd(m) == 0xf;
}
LANES_INLINE real real_fma(real a, real b, real c)
{
    return _mm256_fmadd_pd(a, b, c);
}
LANES_INLINE real real_rsqrt_seed(real x)
{
    return _mm256_cvtps_pd(_mm_div_ps(_mm_set1_ps(1.0f), _mm_sqrt_ps(_mm256_cvtpd_ps(x))));
}
LANES_INLINE void lanes_transpose4(__m256d r0, __m256d r1, __m256d r2, __m256d r3, real *column)
{
    __m256d lo01 = _mm256_unpacklo_pd(r0, r1), hi01 = _mm256_unpackhi_pd(r0, r1);
    __m256d lo23 = _mm256_unpacklo_pd(r2, r3), hi23 = _mm256_unpackhi_pd(r2, r3);
    column[0] = _mm256_permute2f128_pd(lo01, lo23, 0x20);
    column[1] = _mm256_permute2f128_pd(hi01, hi23, 0x20);
    column[2] = _mm256_permute2f128_pd(lo01, lo23, 0x31);
    column[3] = _mm256_permute2f128_pd(hi01, hi23, 0x31);
}
LANES_INLINE void lanes_gather4(const double *base, const uint32_t *row, real *column)
{
    lanes_transpose4(_mm256_loadu_pd(base + row[0]), _mm256_loadu_pd(base + row[1]), _mm256_loadu_pd(base + row[2]),
                     _mm256_loadu_pd(base + row[3]), column);
}
LANES_INLINE void lanes_store4(double *to, int stride, const real *column)
{
    real row[4];
    lanes_transpose4(column[0], column[1], column[2], column[3], row);
    for (int r = 0; r < 4; r++)
        _mm256_storeu_pd(to + stride * r, row[r]);
}
LANES_INLINE void lanes_load4(const double *from, int stride, real *column)
{
    lanes_transpose4(_mm256_loadu_pd(from), _mm256_loadu_pd(from + stride), _mm256_loadu_pd(from + 2 * stride),
                     _mm256_loadu_pd(from + 3 * stride), column);
}
LANES_INLINE double *lanes_half(double *base, uint32_t row)
{
    return (double *)((char *)base + sizeof(double) / 2 * (size_t)row);
}
LANES_INLINE void lanes_add_row2(double *to_i, double *to_j, __m128d row)
{
    _mm_storeu_pd(to_i, _mm_add_pd(_mm_loadu_pd(to_i), row));
    _mm_storeu_pd(to_j, _mm_sub_pd(_mm_loadu_pd(to_j), row));
}
LANES_INLINE void lanes_add2(double *base, const uint32_t *i, const uint32_t *j, const real *column)
{
    __m256d even = _mm256_unpacklo_pd(column[0], column[1]), odd = _mm256_unpackhi_pd(column[0], column[1]);
    lanes_add_row2(lanes_half(base, i[0]), lanes_half(base, j[0]), _mm256_castpd256_pd128(even));
    lanes_add_row2(lanes_half(base, i[1]), lanes_half(base, j[1]), _mm256_castpd256_pd128(odd));
    lanes_add_row2(lanes_half(base, i[2]), lanes_half(base, j[2]), _mm256_extractf128_pd(even, 1));
    lanes_add_row2(lanes_half(base, i[3]), lanes_half(base, j[3]), _mm256_extractf128_pd(odd, 1));
}
LANES_INLINE void lanes_add4(double *base, const uint32_t *i, const uint32_t *j, const real *column, const double *sign)
{
    real row[4], signs = _mm256_loadu_pd(sign);
    lanes_transpose4(column[0], column[1], column[2], column[3], row);
    for (int r = 0; r < LANES; r++) {
        double *to_i = lanes_half(base, i[r]), *to_j = lanes_half(base, j[r]);
        _mm256_storeu_pd(to_i, _mm256_loadu_pd(to_i) + row[r]);
        _mm256_storeu_pd(to_j, _mm256_loadu_pd(to_j) + signs * row[r]);
    }
}
LANES_INLINE void lanes_load2(const double *from, real *column)
{
    __m256d a = _mm256_loadu_pd(from), b = _mm256_loadu_pd(from + 4);
    __m256d front = _mm256_permute2f128_pd(a, b, 0x20), back = _mm256_permute2f128_pd(a, b, 0x31);
    column[0] = _mm256_unpacklo_pd(front, back);
    column[1] = _mm256_unpackhi_pd(front, back);
}
LANES_INLINE double real_sum(real x)
{
    double lane[LANES];
    _mm256_storeu_pd(lane, x);
    return (lane[0] + lane[1]) + (lane[2] + lane[3]);
}
