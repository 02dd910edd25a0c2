/* Eight contacts at a time with AVX-512. */
#include <immintrin.h>
#include <stdbool.h>
#include <stddef.h>
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
LANES_INLINE bool mask_all(mask m)
{
    return m == 0xff;
}
LANES_INLINE real real_fma(real a, real b, real c)
{
    return _mm512_fmadd_pd(a, b, c);
}
LANES_INLINE real real_rsqrt_seed(real x)
{
    return _mm512_cvtps_pd(_mm256_div_ps(_mm256_set1_ps(1.0f), _mm256_sqrt_ps(_mm512_cvtpd_ps(x))));
}
/* Two records of 4 doubles in one register. */
LANES_INLINE __m512d lanes_two(const double *low, const double *high)
{
    return _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_loadu_pd(low)), _mm256_loadu_pd(high), 1);
}
/* Rows 0 and 2, 1 and 3, 4 and 6, 5 and 7 in one register each: then two shuffles a column bring them in order. */
LANES_INLINE void lanes_transpose4(__m512d r02, __m512d r13, __m512d r46, __m512d r57, real *column)
{
    __m512d lo0 = _mm512_unpacklo_pd(r02, r13), hi0 = _mm512_unpackhi_pd(r02, r13);
    __m512d lo4 = _mm512_unpacklo_pd(r46, r57), hi4 = _mm512_unpackhi_pd(r46, r57);
    column[0] = _mm512_shuffle_f64x2(lo0, lo4, 0x88);
    column[1] = _mm512_shuffle_f64x2(hi0, hi4, 0x88);
    column[2] = _mm512_shuffle_f64x2(lo0, lo4, 0xdd);
    column[3] = _mm512_shuffle_f64x2(hi0, hi4, 0xdd);
}
LANES_INLINE void lanes_gather4(const double *base, const uint32_t *row, real *column)
{
    lanes_transpose4(lanes_two(base + row[0], base + row[2]), lanes_two(base + row[1], base + row[3]),
                     lanes_two(base + row[4], base + row[6]), lanes_two(base + row[5], base + row[7]), column);
}
LANES_INLINE void lanes_load4(const double *from, int stride, real *column)
{
    lanes_transpose4(lanes_two(from, from + 2 * stride), lanes_two(from + stride, from + 3 * stride),
                     lanes_two(from + 4 * stride, from + 6 * stride), lanes_two(from + 5 * stride, from + 7 * stride),
                     column);
}
/* The inverse: rows 0 and 2, 1 and 3, 4 and 6, 5 and 7 in one register each. */
LANES_INLINE void lanes_rows4(const real *column, __m512d *rows)
{
    const __m512i front = _mm512_set_epi64(11, 10, 3, 2, 9, 8, 1, 0),
                  back = _mm512_set_epi64(15, 14, 7, 6, 13, 12, 5, 4);
    __m512d even01 = _mm512_unpacklo_pd(column[0], column[1]), odd01 = _mm512_unpackhi_pd(column[0], column[1]);
    __m512d even23 = _mm512_unpacklo_pd(column[2], column[3]), odd23 = _mm512_unpackhi_pd(column[2], column[3]);
    rows[0] = _mm512_permutex2var_pd(even01, front, even23);
    rows[1] = _mm512_permutex2var_pd(odd01, front, odd23);
    rows[2] = _mm512_permutex2var_pd(even01, back, even23);
    rows[3] = _mm512_permutex2var_pd(odd01, back, odd23);
}
LANES_INLINE void lanes_store_two(double *low, double *high, __m512d rows)
{
    _mm256_storeu_pd(low, _mm512_castpd512_pd256(rows));
    _mm256_storeu_pd(high, _mm512_extractf64x4_pd(rows, 1));
}
LANES_INLINE void lanes_store4(double *to, int stride, const real *column)
{
    __m512d rows[4];
    lanes_rows4(column, rows);
    lanes_store_two(to, to + 2 * stride, rows[0]);
    lanes_store_two(to + stride, to + 3 * stride, rows[1]);
    lanes_store_two(to + 4 * stride, to + 6 * stride, rows[2]);
    lanes_store_two(to + 5 * stride, to + 7 * stride, rows[3]);
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
    __m512d even = _mm512_unpacklo_pd(column[0], column[1]), odd = _mm512_unpackhi_pd(column[0], column[1]);
    lanes_add_row2(lanes_half(base, i[0]), lanes_half(base, j[0]), _mm512_extractf64x2_pd(even, 0));
    lanes_add_row2(lanes_half(base, i[1]), lanes_half(base, j[1]), _mm512_extractf64x2_pd(odd, 0));
    lanes_add_row2(lanes_half(base, i[2]), lanes_half(base, j[2]), _mm512_extractf64x2_pd(even, 1));
    lanes_add_row2(lanes_half(base, i[3]), lanes_half(base, j[3]), _mm512_extractf64x2_pd(odd, 1));
    lanes_add_row2(lanes_half(base, i[4]), lanes_half(base, j[4]), _mm512_extractf64x2_pd(even, 2));
    lanes_add_row2(lanes_half(base, i[5]), lanes_half(base, j[5]), _mm512_extractf64x2_pd(odd, 2));
    lanes_add_row2(lanes_half(base, i[6]), lanes_half(base, j[6]), _mm512_extractf64x2_pd(even, 3));
    lanes_add_row2(lanes_half(base, i[7]), lanes_half(base, j[7]), _mm512_extractf64x2_pd(odd, 3));
}
LANES_INLINE void lanes_add_row4(double *to_i, double *to_j, __m256d row, __m256d sign)
{
    _mm256_storeu_pd(to_i, _mm256_loadu_pd(to_i) + row);
    _mm256_storeu_pd(to_j, _mm256_loadu_pd(to_j) + sign * row);
}
LANES_INLINE void lanes_add4(double *base, const uint32_t *i, const uint32_t *j, const real *column, const double *sign)
{
    __m512d rows[4];
    __m256d signs = _mm256_loadu_pd(sign);
    lanes_rows4(column, rows);
    for (int r = 0; r < LANES; r++) { /* unrolled: rows[] holds 0|2, 1|3, 4|6, 5|7 */
        __m512d both = rows[(r & 1) + (r & 4) / 2];
        __m256d row = r & 2 ? _mm512_extractf64x4_pd(both, 1) : _mm512_castpd512_pd256(both);
        lanes_add_row4(lanes_half(base, i[r]), lanes_half(base, j[r]), row, signs);
    }
}
LANES_INLINE void lanes_load2(const double *from, real *column)
{
    const __m512i even = _mm512_set_epi64(14, 12, 10, 8, 6, 4, 2, 0), odd = _mm512_set_epi64(15, 13, 11, 9, 7, 5, 3, 1);
    __m512d a = _mm512_loadu_pd(from), b = _mm512_loadu_pd(from + 8);
    column[0] = _mm512_permutex2var_pd(a, even, b);
    column[1] = _mm512_permutex2var_pd(a, odd, b);
}
LANES_INLINE double real_sum(real x)
{
    double lane[LANES];
    _mm512_storeu_pd(lane, x);
    return ((lane[0] + lane[1]) + (lane[2] + lane[3])) + ((lane[4] + lane[5]) + (lane[6] + lane[7]));
}
