/* Four doubles or eight floats at a time with AVX2; what each does is said in lanes_reference.h. */
#include <immintrin.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "sim/lanes/lanes_x86.h"

#define F64_LANES 4
#define F32_LANES 8
typedef __m256d f64;
typedef __m256d f64_mask;
typedef __m256 f32;
typedef __m256 f32_mask;

LANES_INLINE f64 f64_all(double x)
{
    return _mm256_set1_pd(x);
}
LANES_INLINE f32 f32_all(double x)
{
    return _mm256_set1_ps((float)x);
}
LANES_INLINE f64 f64_load(const double *from)
{
    return _mm256_loadu_pd(from);
}
LANES_INLINE f32 f32_load(const float *from)
{
    return _mm256_loadu_ps(from);
}
LANES_INLINE void f64_store(double *to, f64 x)
{
    _mm256_storeu_pd(to, x);
}
LANES_INLINE void f32_store(float *to, f32 x)
{
    _mm256_storeu_ps(to, x);
}
LANES_INLINE f64_mask f64_greater(f64 a, f64 b)
{
    return _mm256_cmp_pd(a, b, _CMP_GT_OQ);
}
LANES_INLINE f32_mask f32_greater(f32 a, f32 b)
{
    return _mm256_cmp_ps(a, b, _CMP_GT_OQ);
}
LANES_INLINE f64_mask f64_at_least(f64 a, f64 b)
{
    return _mm256_cmp_pd(a, b, _CMP_GE_OQ);
}
LANES_INLINE f32_mask f32_at_least(f32 a, f32 b)
{
    return _mm256_cmp_ps(a, b, _CMP_GE_OQ);
}
LANES_INLINE f64_mask f64_and(f64_mask a, f64_mask b)
{
    return _mm256_and_pd(a, b);
}
LANES_INLINE f32_mask f32_and(f32_mask a, f32_mask b)
{
    return _mm256_and_ps(a, b);
}
LANES_INLINE f64 f64_select(f64_mask m, f64 a, f64 b)
{
    return _mm256_blendv_pd(b, a, m);
}
LANES_INLINE f32 f32_select(f32_mask m, f32 a, f32 b)
{
    return _mm256_blendv_ps(b, a, m);
}
LANES_INLINE f64 f64_where(f64_mask m, f64 x)
{
    return _mm256_and_pd(m, x);
}
LANES_INLINE f32 f32_where(f32_mask m, f32 x)
{
    return _mm256_and_ps(m, x);
}
LANES_INLINE f64 f64_larger(f64 a, f64 b)
{
    return _mm256_max_pd(a, b);
}
LANES_INLINE f32 f32_larger(f32 a, f32 b)
{
    return _mm256_max_ps(a, b);
}
LANES_INLINE f64 f64_smaller(f64 a, f64 b)
{
    return _mm256_min_pd(a, b);
}
LANES_INLINE f32 f32_smaller(f32 a, f32 b)
{
    return _mm256_min_ps(a, b);
}
LANES_INLINE bool f64_mask_all(f64_mask m)
{
    return _mm256_movemask_pd(m) == 0xf;
}
LANES_INLINE bool f32_mask_all(f32_mask m)
{
    return _mm256_movemask_ps(m) == 0xff;
}
LANES_INLINE f64 f64_fma(f64 a, f64 b, f64 c)
{
    return _mm256_fmadd_pd(a, b, c);
}
LANES_INLINE f32 f32_fma(f32 a, f32 b, f32 c)
{
    return _mm256_fmadd_ps(a, b, c);
}
LANES_INLINE f32 f32_sqrt(f32 x)
{
    return _mm256_sqrt_ps(x);
}
LANES_INLINE f64 f64_rsqrt_seed(f64 x)
{
    return _mm256_cvtps_pd(_mm_div_ps(_mm_set1_ps(1.0f), _mm_sqrt_ps(_mm256_cvtpd_ps(x))));
}
LANES_INLINE f64 f64_fourth_root_seed(f64 x)
{
    return _mm256_cvtps_pd(_mm_div_ps(_mm_set1_ps(1.0f), _mm_sqrt_ps(_mm_sqrt_ps(_mm256_cvtpd_ps(x)))));
}
LANES_INLINE double f64_sum(f64 x)
{
    __m128d two = _mm_add_pd(_mm256_castpd256_pd128(x), _mm256_extractf128_pd(x, 1));
    return _mm_cvtsd_f64(_mm_add_sd(two, _mm_unpackhi_pd(two, two)));
}
LANES_INLINE f64 f64_shifted(f64 before, f64 x)
{
    return _mm256_shuffle_pd(_mm256_permute2f128_pd(before, x, 0x21), x, 5);
}
LANES_INLINE f32 f32_shifted(f32 before, f32 x)
{
    __m256i middle = _mm256_castps_si256(_mm256_permute2f128_ps(before, x, 0x21));
    return _mm256_castsi256_ps(_mm256_alignr_epi8(_mm256_castps_si256(x), middle, 12));
}
LANES_INLINE f64 f64_behind(f64 x, f64 next)
{
    return _mm256_shuffle_pd(x, _mm256_permute2f128_pd(x, next, 0x21), 5);
}
LANES_INLINE f32 f32_behind(f32 x, f32 next)
{
    __m256i middle = _mm256_castps_si256(_mm256_permute2f128_ps(x, next, 0x21));
    return _mm256_castsi256_ps(_mm256_alignr_epi8(middle, _mm256_castps_si256(x), 4));
}
LANES_INLINE void f32_widen(f32 x, f64 *part)
{
    part[0] = _mm256_cvtps_pd(_mm256_castps256_ps128(x));
    part[1] = _mm256_cvtps_pd(_mm256_extractf128_ps(x, 1));
}
LANES_INLINE f32 f32_narrow(const f64 *part)
{
    return _mm256_set_m128(_mm256_cvtpd_ps(part[1]), _mm256_cvtpd_ps(part[0]));
}
LANES_INLINE f32 f32_round(f32 x)
{
    return _mm256_round_ps(x, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
}
LANES_INLINE f32 f32_to_integers(f32 x)
{
    return _mm256_castsi256_ps(_mm256_cvtps_epi32(x));
}
LANES_INLINE f32 f32_all_integers(int32_t integer)
{
    return _mm256_castsi256_ps(_mm256_set1_epi32(integer));
}
LANES_INLINE f32 f32_of_integers(f32 bits)
{
    return _mm256_cvtepi32_ps(_mm256_castps_si256(bits));
}
LANES_INLINE f32 f32_of_difference(f32 a, f32 b)
{
    return _mm256_cvtepi32_ps(_mm256_sub_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b)));
}
LANES_INLINE f32 f32_sum_of_integers(f32 a, f32 b)
{
    return _mm256_castsi256_ps(_mm256_add_epi32(_mm256_castps_si256(a), _mm256_castps_si256(b)));
}
LANES_INLINE f32 f32_pair(f32 a, f32 b)
{
    const __m256i second = _mm256_srli_epi32(_mm256_castps_si256(b), 16);
    return _mm256_castsi256_ps(_mm256_blend_epi16(second, _mm256_castps_si256(a), 0xaa));
}
LANES_INLINE f32 f32_first(f32 pair)
{
    return _mm256_and_ps(pair, _mm256_castsi256_ps(_mm256_set1_epi32(-0x10000)));
}
LANES_INLINE f32 f32_second(f32 pair)
{
    return _mm256_castsi256_ps(_mm256_slli_epi32(_mm256_castps_si256(pair), 16));
}
/* Rows 0 and 2, 1 and 3 share registers: two halves from memory, and one shuffle a column. */
LANES_INLINE f64 lanes_two(const double *low, const double *high)
{
    return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(low)), _mm_loadu_pd(high), 1);
}
LANES_INLINE void f64_gather4(const double *base, const uint32_t *row, f64 *column)
{
    for (int half = 0; half < 2; half++) {
        const double *from = base + 2 * half;
        f64 r02 = lanes_two(from + row[0], from + row[2]), r13 = lanes_two(from + row[1], from + row[3]);
        column[2 * half] = _mm256_unpacklo_pd(r02, r13);
        column[2 * half + 1] = _mm256_unpackhi_pd(r02, r13);
    }
}
LANES_INLINE f32 lanes_two_quads(const double *base, uint32_t a, uint32_t b)
{
    f32 low = _mm256_castps128_ps256(_mm_loadu_ps((const float *)(base + a)));
    return _mm256_insertf128_ps(low, _mm_loadu_ps((const float *)(base + b)), 1);
}
LANES_INLINE f32 lanes_low_pairs(f32 a, f32 b)
{
    return _mm256_castpd_ps(_mm256_unpacklo_pd(_mm256_castps_pd(a), _mm256_castps_pd(b)));
}
LANES_INLINE f32 lanes_high_pairs(f32 a, f32 b)
{
    return _mm256_castpd_ps(_mm256_unpackhi_pd(_mm256_castps_pd(a), _mm256_castps_pd(b)));
}
/* Transposes the 4 x 4 floats in each half of four registers. */
LANES_INLINE void lanes_halves(const f32 *from, f32 *to)
{
    f32 lo01 = _mm256_unpacklo_ps(from[0], from[1]), hi01 = _mm256_unpackhi_ps(from[0], from[1]);
    f32 lo23 = _mm256_unpacklo_ps(from[2], from[3]), hi23 = _mm256_unpackhi_ps(from[2], from[3]);
    to[0] = lanes_low_pairs(lo01, lo23);
    to[1] = lanes_high_pairs(lo01, lo23);
    to[2] = lanes_low_pairs(hi01, hi23);
    to[3] = lanes_high_pairs(hi01, hi23);
}
LANES_INLINE void f32_gather4(const double *base, const uint32_t *row, f32 *column)
{
    f32 rows[4];
    for (int r = 0; r < 4; r++)
        rows[r] = lanes_two_quads(base, row[r], row[4 + r]);
    lanes_halves(rows, column);
}
LANES_INLINE void f32_gather8(const double *base, const uint32_t *row, f32 *column)
{
    f32_gather4(base, row, column);
    f32_gather4(base + 2, row, column + 4);
}
LANES_INLINE void lanes_transpose4(f64 r0, f64 r1, f64 r2, f64 r3, f64 *column)
{
    f64 lo01 = _mm256_unpacklo_pd(r0, r1), hi01 = _mm256_unpackhi_pd(r0, r1);
    f64 lo23 = _mm256_unpacklo_pd(r2, r3), hi23 = _mm256_unpackhi_pd(r2, r3);
    column[0] = _mm256_permute2f128_pd(lo01, lo23, 0x20);
    column[1] = _mm256_permute2f128_pd(hi01, hi23, 0x20);
    column[2] = _mm256_permute2f128_pd(lo01, lo23, 0x31);
    column[3] = _mm256_permute2f128_pd(hi01, hi23, 0x31);
}
LANES_INLINE void f64_load4(const double *from, int stride, f64 *column)
{
    lanes_transpose4(_mm256_loadu_pd(from), _mm256_loadu_pd(from + stride), _mm256_loadu_pd(from + 2 * stride),
                     _mm256_loadu_pd(from + 3 * stride), column);
}
LANES_INLINE void f64_store4(double *to, int stride, const f64 *column)
{
    f64 row[4];
    lanes_transpose4(column[0], column[1], column[2], column[3], row);
    for (int r = 0; r < 4; r++)
        _mm256_storeu_pd(to + stride * r, row[r]);
}
LANES_INLINE void f64_load2(const double *from, f64 *column)
{
    f64 a = _mm256_loadu_pd(from), b = _mm256_loadu_pd(from + 4);
    f64 front = _mm256_permute2f128_pd(a, b, 0x20), back = _mm256_permute2f128_pd(a, b, 0x31);
    column[0] = _mm256_unpacklo_pd(front, back);
    column[1] = _mm256_unpackhi_pd(front, back);
}
LANES_INLINE void f32_load2(const float *from, f32 *column)
{
    f32 a = _mm256_loadu_ps(from), b = _mm256_loadu_ps(from + 8); /* rows 0 1 | 2 3 and 4 5 | 6 7 */
    f32 front = _mm256_permute2f128_ps(a, b, 0x20), back = _mm256_permute2f128_ps(a, b, 0x31);
    column[0] = _mm256_shuffle_ps(front, back, 0x88);
    column[1] = _mm256_shuffle_ps(front, back, 0xdd);
}
/* Columns of 4 of rows that are `stride` apart; and rows from columns. */
LANES_INLINE void lanes_load_quads(const float *from, int stride, f32 *column)
{
    f32 rows[4];
    for (int r = 0; r < 4; r++)
        rows[r] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(from + stride * r)),
                                       _mm_loadu_ps(from + stride * (4 + r)), 1);
    lanes_halves(rows, column);
}
LANES_INLINE void lanes_store_quads(float *to, int stride, const f32 *column)
{
    f32 rows[4];
    lanes_halves(column, rows);
    for (int r = 0; r < 4; r++) {
        _mm_storeu_ps(to + stride * r, _mm256_castps256_ps128(rows[r]));
        _mm_storeu_ps(to + stride * (4 + r), _mm256_extractf128_ps(rows[r], 1));
    }
}
LANES_INLINE void f32_load4(const float *from, f32 *column)
{
    lanes_load_quads(from, 4, column);
}
LANES_INLINE void f32_load8(const float *from, f32 *column)
{
    lanes_load_quads(from, 8, column);
    lanes_load_quads(from + 4, 8, column + 4);
}
LANES_INLINE void f32_store4(float *to, const f32 *column)
{
    lanes_store_quads(to, 4, column);
}
LANES_INLINE void f32_store8(float *to, const f32 *column)
{
    lanes_store_quads(to, 8, column);
    lanes_store_quads(to + 4, 8, column + 4);
}
LANES_INLINE void f32_store16(float *to, const f32 *column)
{
    for (int c = 0; c < 16; c += 4)
        lanes_store_quads(to + c, 16, column + c);
}
/* Sums, row by row. */
LANES_INLINE void f64_add2(void *base, const uint32_t *row, const f64 *column)
{
    double buffer[2][4] __attribute__((aligned(32)));
    _mm256_store_pd(buffer[0], _mm256_unpacklo_pd(column[0], column[1]));
    _mm256_store_pd(buffer[1], _mm256_unpackhi_pd(column[0], column[1]));
    for (int r = 0; r < 4; r++) {
        double *to = lanes_sums(base, row[r], 4);
        _mm_storeu_pd(to, _mm_loadu_pd(to) + _mm_load_pd(&buffer[r & 1][r & 2]));
    }
}
LANES_INLINE void f64_add4(void *base, const uint32_t *row, const f64 *column)
{
    f64 rows[4];
    lanes_transpose4(column[0], column[1], column[2], column[3], rows);
    for (int r = 0; r < 4; r++) {
        double *to = lanes_sums(base, row[r], 4);
        _mm256_storeu_pd(to, _mm256_loadu_pd(to) + rows[r]);
    }
}
LANES_INLINE void f32_add2(void *base, const uint32_t *row, int unit, const f32 *column)
{
    const f32 pairs[2] = {_mm256_unpacklo_ps(column[0], column[1]), _mm256_unpackhi_ps(column[0], column[1])};
    for (int q = 0; q < 2; q++) { /* rows 2q, 2q + 4 | 2q + 1, 2q + 5 */
        const __m256d crossed = _mm256_permute4x64_pd(_mm256_castps_pd(pairs[q]), 0xd8);
        lanes_add_two_rows(base, row + 2 * q, unit, _mm_castpd_ps(_mm256_castpd256_pd128(crossed)));
        lanes_add_two_rows(base, row + 2 * q + 1, unit, _mm_castpd_ps(_mm256_extractf128_pd(crossed, 1)));
    }
}
LANES_INLINE void f32_add4(void *base, const uint32_t *row, int unit, const f32 *column)
{
    float buffer[4][8] __attribute__((aligned(32)));
    f32 rows[4];
    lanes_halves(column, rows);
    for (int k = 0; k < 4; k++)
        _mm256_store_ps(buffer[k], rows[k]);
    for (int r = 0; r < 8; r++) {
        float *to = lanes_sums(base, row[r], unit);
        _mm_storeu_ps(to, _mm_loadu_ps(to) + _mm_load_ps(&buffer[r & 3][r & 4]));
    }
}
LANES_INLINE void f32_add8(void *base, const uint32_t *row, int unit, const f32 *column)
{
    f32 low[4], high[4], rows[8];
    lanes_halves(column, low);
    lanes_halves(column + 4, high);
    for (int q = 0; q < 4; q++) {
        rows[q] = _mm256_permute2f128_ps(low[q], high[q], 0x20);
        rows[4 + q] = _mm256_permute2f128_ps(low[q], high[q], 0x31);
    }
    for (int r = 0; r < 8; r++) {
        float *to = lanes_sums(base, row[r], unit);
        _mm256_storeu_ps(to, _mm256_loadu_ps(to) + rows[r]);
    }
}
