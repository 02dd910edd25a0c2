/* Eight doubles or sixteen floats at a time with AVX-512; what each does is said in lanes_reference.h. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "sim/lanes/lanes_x86.h"

#define F64_LANES 8
#define F32_LANES 16
typedef __m512d f64;
typedef __mmask8 f64_mask;
typedef __m512 f32;
typedef __mmask16 f32_mask;

LANES_INLINE f64 f64_all(double x)
{
    return _mm512_set1_pd(x);
}
LANES_INLINE f32 f32_all(double x)
{
    return _mm512_set1_ps((float)x);
}
LANES_INLINE f64 f64_load(const double *from)
{
    return _mm512_loadu_pd(from);
}
LANES_INLINE f32 f32_load(const float *from)
{
    return _mm512_loadu_ps(from);
}
LANES_INLINE void f64_store(double *to, f64 x)
{
    _mm512_storeu_pd(to, x);
}
LANES_INLINE void f32_store(float *to, f32 x)
{
    _mm512_storeu_ps(to, x);
}
LANES_INLINE f64_mask f64_greater(f64 a, f64 b)
{
    return _mm512_cmp_pd_mask(a, b, _CMP_GT_OQ);
}
LANES_INLINE f32_mask f32_greater(f32 a, f32 b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_GT_OQ);
}
LANES_INLINE f64_mask f64_at_least(f64 a, f64 b)
{
    return _mm512_cmp_pd_mask(a, b, _CMP_GE_OQ);
}
LANES_INLINE f32_mask f32_at_least(f32 a, f32 b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_GE_OQ);
}
LANES_INLINE f64_mask f64_and(f64_mask a, f64_mask b)
{
    return a & b;
}
LANES_INLINE f32_mask f32_and(f32_mask a, f32_mask b)
{
    return a & b;
}
LANES_INLINE f64 f64_select(f64_mask m, f64 a, f64 b)
{
    return _mm512_mask_blend_pd(m, b, a);
}
LANES_INLINE f32 f32_select(f32_mask m, f32 a, f32 b)
{
    return _mm512_mask_blend_ps(m, b, a);
}
LANES_INLINE f64 f64_where(f64_mask m, f64 x)
{
    return _mm512_maskz_mov_pd(m, x);
}
LANES_INLINE f32 f32_where(f32_mask m, f32 x)
{
    return _mm512_maskz_mov_ps(m, x);
}
LANES_INLINE f64 f64_larger(f64 a, f64 b)
{
    return _mm512_max_pd(a, b);
}
LANES_INLINE f32 f32_larger(f32 a, f32 b)
{
    return _mm512_max_ps(a, b);
}
LANES_INLINE f64 f64_smaller(f64 a, f64 b)
{
    return _mm512_min_pd(a, b);
}
LANES_INLINE f32 f32_smaller(f32 a, f32 b)
{
    return _mm512_min_ps(a, b);
}
LANES_INLINE bool f64_mask_all(f64_mask m)
{
    return m == 0xff;
}
LANES_INLINE bool f32_mask_all(f32_mask m)
{
    return m == 0xffff;
}
LANES_INLINE f64 f64_fma(f64 a, f64 b, f64 c)
{
    return _mm512_fmadd_pd(a, b, c);
}
LANES_INLINE f32 f32_fma(f32 a, f32 b, f32 c)
{
    return _mm512_fmadd_ps(a, b, c);
}
LANES_INLINE f32 f32_sqrt(f32 x)
{
    return _mm512_sqrt_ps(x);
}
LANES_INLINE f64 f64_rsqrt_seed(f64 x)
{
    return _mm512_cvtps_pd(_mm256_div_ps(_mm256_set1_ps(1.0f), _mm256_sqrt_ps(_mm512_cvtpd_ps(x))));
}
LANES_INLINE f64 f64_fourth_root_seed(f64 x)
{
    const __m256 root = _mm256_sqrt_ps(_mm256_sqrt_ps(_mm512_cvtpd_ps(x)));
    return _mm512_cvtps_pd(_mm256_div_ps(_mm256_set1_ps(1.0f), root));
}
LANES_INLINE double f64_sum(f64 x)
{
    __m256d four = _mm256_add_pd(_mm512_castpd512_pd256(x), _mm512_extractf64x4_pd(x, 1));
    __m128d two = _mm_add_pd(_mm256_castpd256_pd128(four), _mm256_extractf128_pd(four, 1));
    return _mm_cvtsd_f64(_mm_add_sd(two, _mm_unpackhi_pd(two, two)));
}
LANES_INLINE f64 f64_shifted(f64 before, f64 x)
{
    return _mm512_castsi512_pd(_mm512_alignr_epi64(_mm512_castpd_si512(x), _mm512_castpd_si512(before), 7));
}
LANES_INLINE f32 f32_shifted(f32 before, f32 x)
{
    return _mm512_castsi512_ps(_mm512_alignr_epi32(_mm512_castps_si512(x), _mm512_castps_si512(before), 15));
}
LANES_INLINE f64 f64_behind(f64 x, f64 next)
{
    return _mm512_castsi512_pd(_mm512_alignr_epi64(_mm512_castpd_si512(next), _mm512_castpd_si512(x), 1));
}
LANES_INLINE f32 f32_behind(f32 x, f32 next)
{
    return _mm512_castsi512_ps(_mm512_alignr_epi32(_mm512_castps_si512(next), _mm512_castps_si512(x), 1));
}
LANES_INLINE void f32_widen(f32 x, f64 *part)
{
    part[0] = _mm512_cvtps_pd(_mm512_castps512_ps256(x));
    part[1] = _mm512_cvtps_pd(_mm512_extractf32x8_ps(x, 1));
}
LANES_INLINE f32 lanes_join(__m256 low, __m256 high)
{
    return _mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
}
LANES_INLINE f32 f32_narrow(const f64 *part)
{
    return lanes_join(_mm512_cvtpd_ps(part[0]), _mm512_cvtpd_ps(part[1]));
}
LANES_INLINE f32 f32_round(f32 x)
{
    return _mm512_roundscale_ps(x, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC);
}
LANES_INLINE f32 f32_to_integers(f32 x)
{
    return _mm512_castsi512_ps(_mm512_cvtps_epi32(x));
}
LANES_INLINE f32 f32_all_integers(int32_t integer)
{
    return _mm512_castsi512_ps(_mm512_set1_epi32(integer));
}
LANES_INLINE f32 f32_of_integers(f32 bits)
{
    return _mm512_cvtepi32_ps(_mm512_castps_si512(bits));
}
LANES_INLINE f32 f32_of_difference(f32 a, f32 b)
{
    return _mm512_cvtepi32_ps(_mm512_sub_epi32(_mm512_castps_si512(a), _mm512_castps_si512(b)));
}
LANES_INLINE f32 f32_sum_of_integers(f32 a, f32 b)
{
    return _mm512_castsi512_ps(_mm512_add_epi32(_mm512_castps_si512(a), _mm512_castps_si512(b)));
}
LANES_INLINE f32 f32_pair(f32 a, f32 b)
{
    const __m512i first = _mm512_set1_epi32(-0x10000), second = _mm512_srli_epi32(_mm512_castps_si512(b), 16);
    return _mm512_castsi512_ps(_mm512_ternarylogic_epi32(first, _mm512_castps_si512(a), second, 0xca));
}
LANES_INLINE f32 f32_first(f32 pair)
{
    return _mm512_and_ps(pair, _mm512_castsi512_ps(_mm512_set1_epi32(-0x10000)));
}
LANES_INLINE f32 f32_second(f32 pair)
{
    return _mm512_castsi512_ps(_mm512_slli_epi32(_mm512_castps_si512(pair), 16));
}
/* Two halves that stand apart; and x taken from them. */
LANES_INLINE f32 f32_load_halves(const float *low, const float *high)
{
    return lanes_join(_mm256_loadu_ps(low), _mm256_loadu_ps(high));
}
LANES_INLINE void f32_subtract_halves(float *low, float *high, f32 x)
{
    _mm256_storeu_ps(low, _mm256_loadu_ps(low) - _mm512_castps512_ps256(x));
    _mm256_storeu_ps(high, _mm256_loadu_ps(high) - _mm512_extractf32x8_ps(x, 1));
}
/* Two records of 4 doubles in one register. */
LANES_INLINE f64 lanes_two(const double *low, const double *high)
{
    return _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_loadu_pd(low)), _mm256_loadu_pd(high), 1);
}
/* Rows 0 and 2, 1 and 3, 4 and 6, 5 and 7 in one register each: then two shuffles a column bring them in order. */
LANES_INLINE void lanes_transpose4(f64 r02, f64 r13, f64 r46, f64 r57, f64 *column)
{
    f64 lo0 = _mm512_unpacklo_pd(r02, r13), hi0 = _mm512_unpackhi_pd(r02, r13);
    f64 lo4 = _mm512_unpacklo_pd(r46, r57), hi4 = _mm512_unpackhi_pd(r46, r57);
    column[0] = _mm512_shuffle_f64x2(lo0, lo4, 0x88);
    column[1] = _mm512_shuffle_f64x2(hi0, hi4, 0x88);
    column[2] = _mm512_shuffle_f64x2(lo0, lo4, 0xdd);
    column[3] = _mm512_shuffle_f64x2(hi0, hi4, 0xdd);
}
LANES_INLINE void f64_gather4(const double *base, const uint32_t *row, f64 *column)
{
    lanes_transpose4(lanes_two(base + row[0], base + row[2]), lanes_two(base + row[1], base + row[3]),
                     lanes_two(base + row[4], base + row[6]), lanes_two(base + row[5], base + row[7]), column);
}
/* Four records of 4 floats, one in each quarter. */
LANES_INLINE f32 lanes_four(const double *base, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    f32 all = _mm512_castps128_ps512(_mm_loadu_ps((const float *)(base + a)));
    all = _mm512_insertf32x4(all, _mm_loadu_ps((const float *)(base + b)), 1);
    all = _mm512_insertf32x4(all, _mm_loadu_ps((const float *)(base + c)), 2);
    return _mm512_insertf32x4(all, _mm_loadu_ps((const float *)(base + d)), 3);
}
LANES_INLINE f32 lanes_low_pairs(f32 a, f32 b)
{
    return _mm512_castpd_ps(_mm512_unpacklo_pd(_mm512_castps_pd(a), _mm512_castps_pd(b)));
}
LANES_INLINE f32 lanes_high_pairs(f32 a, f32 b)
{
    return _mm512_castpd_ps(_mm512_unpackhi_pd(_mm512_castps_pd(a), _mm512_castps_pd(b)));
}
/* Transposes the 4 x 4 floats in each quarter of four registers. */
LANES_INLINE void lanes_quarters(const f32 *from, f32 *to)
{
    f32 lo01 = _mm512_unpacklo_ps(from[0], from[1]), hi01 = _mm512_unpackhi_ps(from[0], from[1]);
    f32 lo23 = _mm512_unpacklo_ps(from[2], from[3]), hi23 = _mm512_unpackhi_ps(from[2], from[3]);
    to[0] = lanes_low_pairs(lo01, lo23);
    to[1] = lanes_high_pairs(lo01, lo23);
    to[2] = lanes_low_pairs(hi01, hi23);
    to[3] = lanes_high_pairs(hi01, hi23);
}
LANES_INLINE void f32_gather4(const double *base, const uint32_t *row, f32 *column)
{
    f32 rows[4] = {lanes_four(base, row[0], row[4], row[8], row[12]), lanes_four(base, row[1], row[5], row[9], row[13]),
                   lanes_four(base, row[2], row[6], row[10], row[14]),
                   lanes_four(base, row[3], row[7], row[11], row[15])};
    lanes_quarters(rows, column);
}
/* Two records of 8 floats in one register. */
LANES_INLINE f32 lanes_two_octets(const double *base, uint32_t a, uint32_t b)
{
    return _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_loadu_ps((const float *)(base + a))),
                              _mm256_loadu_ps((const float *)(base + b)), 1);
}
LANES_INLINE void f32_gather8(const double *base, const uint32_t *row, f32 *column)
{
    f32 rows[8], part[8];
    for (int r = 0; r < 8; r++) /* 0|4 1|5 2|6 3|7, 8|12 9|13 ... */
        rows[r] = lanes_two_octets(base, row[r + (r & 4)], row[r + (r & 4) + 4]);
    lanes_quarters(rows, part);
    lanes_quarters(rows + 4, part + 4);
    for (int c = 0; c < 4; c++) {
        column[c] = _mm512_shuffle_f32x4(part[c], part[4 + c], 0x88);
        column[4 + c] = _mm512_shuffle_f32x4(part[c], part[4 + c], 0xdd);
    }
}
LANES_INLINE void f64_load4(const double *from, int stride, f64 *column)
{
    lanes_transpose4(lanes_two(from, from + 2 * stride), lanes_two(from + stride, from + 3 * stride),
                     lanes_two(from + 4 * stride, from + 6 * stride), lanes_two(from + 5 * stride, from + 7 * stride),
                     column);
}
/* The inverse: rows 0 and 2, 1 and 3, 4 and 6, 5 and 7 in one register each. */
LANES_INLINE void lanes_rows4(const f64 *column, f64 *rows)
{
    const __m512i front = _mm512_set_epi64(11, 10, 3, 2, 9, 8, 1, 0),
                  back = _mm512_set_epi64(15, 14, 7, 6, 13, 12, 5, 4);
    f64 even01 = _mm512_unpacklo_pd(column[0], column[1]), odd01 = _mm512_unpackhi_pd(column[0], column[1]);
    f64 even23 = _mm512_unpacklo_pd(column[2], column[3]), odd23 = _mm512_unpackhi_pd(column[2], column[3]);
    rows[0] = _mm512_permutex2var_pd(even01, front, even23);
    rows[1] = _mm512_permutex2var_pd(odd01, front, odd23);
    rows[2] = _mm512_permutex2var_pd(even01, back, even23);
    rows[3] = _mm512_permutex2var_pd(odd01, back, odd23);
}
LANES_INLINE void lanes_store_two(double *low, double *high, f64 rows)
{
    _mm256_storeu_pd(low, _mm512_castpd512_pd256(rows));
    _mm256_storeu_pd(high, _mm512_extractf64x4_pd(rows, 1));
}
LANES_INLINE void f64_store4(double *to, int stride, const f64 *column)
{
    f64 rows[4];
    lanes_rows4(column, rows);
    lanes_store_two(to, to + 2 * stride, rows[0]);
    lanes_store_two(to + stride, to + 3 * stride, rows[1]);
    lanes_store_two(to + 4 * stride, to + 6 * stride, rows[2]);
    lanes_store_two(to + 5 * stride, to + 7 * stride, rows[3]);
}
LANES_INLINE void f64_load2(const double *from, f64 *column)
{
    const __m512i even = _mm512_set_epi64(14, 12, 10, 8, 6, 4, 2, 0), odd = _mm512_set_epi64(15, 13, 11, 9, 7, 5, 3, 1);
    f64 a = _mm512_loadu_pd(from), b = _mm512_loadu_pd(from + 8);
    column[0] = _mm512_permutex2var_pd(a, even, b);
    column[1] = _mm512_permutex2var_pd(a, odd, b);
}
LANES_INLINE void f32_load2(const float *from, f32 *column)
{
    const __m512i even = _mm512_set_epi32(30, 28, 26, 24, 22, 20, 18, 16, 14, 12, 10, 8, 6, 4, 2, 0),
                  odd = _mm512_set_epi32(31, 29, 27, 25, 23, 21, 19, 17, 15, 13, 11, 9, 7, 5, 3, 1);
    f32 a = _mm512_loadu_ps(from), b = _mm512_loadu_ps(from + 16);
    column[0] = _mm512_permutex2var_ps(a, even, b);
    column[1] = _mm512_permutex2var_ps(a, odd, b);
}
/* Columns of sixteen rows of 4 floats, of which each register has four. */
LANES_INLINE void lanes_columns4(const f32 *rows, f32 *column)
{
    const __m512i first = _mm512_set_epi32(29, 25, 21, 17, 13, 9, 5, 1, 28, 24, 20, 16, 12, 8, 4, 0),
                  second = _mm512_set_epi32(31, 27, 23, 19, 15, 11, 7, 3, 30, 26, 22, 18, 14, 10, 6, 2);
    for (int c = 0; c < 4; c += 2) {
        f32 low = _mm512_permutex2var_ps(rows[0], c ? second : first, rows[1]);
        f32 high = _mm512_permutex2var_ps(rows[2], c ? second : first, rows[3]);
        column[c] = _mm512_shuffle_f32x4(low, high, 0x44);
        column[c + 1] = _mm512_shuffle_f32x4(low, high, 0xee);
    }
}
/* The inverse. */
LANES_INLINE void lanes_rows_of_4(const f32 *column, f32 *rows)
{
    const __m512i low = _mm512_set_epi32(23, 7, 22, 6, 21, 5, 20, 4, 19, 3, 18, 2, 17, 1, 16, 0),
                  high = _mm512_set_epi32(31, 15, 30, 14, 29, 13, 28, 12, 27, 11, 26, 10, 25, 9, 24, 8);
    const __m512i front = _mm512_set_epi64(11, 3, 10, 2, 9, 1, 8, 0),
                  back = _mm512_set_epi64(15, 7, 14, 6, 13, 5, 12, 4);
    for (int h = 0; h < 2; h++) { /* eight rows each */
        f64 first = _mm512_castps_pd(_mm512_permutex2var_ps(column[0], h ? high : low, column[1]));
        f64 second = _mm512_castps_pd(_mm512_permutex2var_ps(column[2], h ? high : low, column[3]));
        rows[2 * h] = _mm512_castpd_ps(_mm512_permutex2var_pd(first, front, second));
        rows[2 * h + 1] = _mm512_castpd_ps(_mm512_permutex2var_pd(first, back, second));
    }
}
LANES_INLINE void f32_load4(const float *from, f32 *column)
{
    f32 rows[4];
    for (int r = 0; r < 4; r++)
        rows[r] = _mm512_loadu_ps(from + 16 * r);
    lanes_columns4(rows, column);
}
LANES_INLINE void f32_load8(const float *from, f32 *column)
{
    f32 front[4], back[4];
    for (int r = 0; r < 4; r++) {
        f32 a = _mm512_loadu_ps(from + 32 * r), b = _mm512_loadu_ps(from + 32 * r + 16);
        front[r] = _mm512_shuffle_f32x4(a, b, 0x88);
        back[r] = _mm512_shuffle_f32x4(a, b, 0xdd);
    }
    lanes_columns4(front, column);
    lanes_columns4(back, column + 4);
}
LANES_INLINE void f32_store4(float *to, const f32 *column)
{
    f32 rows[4];
    lanes_rows_of_4(column, rows);
    for (int r = 0; r < 4; r++)
        _mm512_storeu_ps(to + 16 * r, rows[r]);
}
LANES_INLINE void f32_store8(float *to, const f32 *column)
{
    const __m512i even = _mm512_set_epi64(11, 10, 3, 2, 9, 8, 1, 0), odd = _mm512_set_epi64(15, 14, 7, 6, 13, 12, 5, 4);
    f32 front[4], back[4];
    lanes_rows_of_4(column, front);
    lanes_rows_of_4(column + 4, back);
    for (int r = 0; r < 4; r++) {
        f64 a = _mm512_castps_pd(front[r]), b = _mm512_castps_pd(back[r]);
        _mm512_storeu_pd(to + 32 * r, _mm512_permutex2var_pd(a, even, b));
        _mm512_storeu_pd(to + 32 * r + 16, _mm512_permutex2var_pd(a, odd, b));
    }
}
/* Four quads of each of four rows, in as many registers: one row each. */
LANES_INLINE void f32_store16(float *to, const f32 *column)
{
    f32 quad[4][4];
    for (int q = 0; q < 4; q++)
        lanes_rows_of_4(column + 4 * q, quad[q]);
    for (int r = 0; r < 4; r++, to += 64) {
        f32 even0 = _mm512_shuffle_f32x4(quad[0][r], quad[1][r], 0x88),
            odd0 = _mm512_shuffle_f32x4(quad[0][r], quad[1][r], 0xdd);
        f32 even2 = _mm512_shuffle_f32x4(quad[2][r], quad[3][r], 0x88),
            odd2 = _mm512_shuffle_f32x4(quad[2][r], quad[3][r], 0xdd);
        _mm512_storeu_ps(to, _mm512_shuffle_f32x4(even0, even2, 0x88));
        _mm512_storeu_ps(to + 16, _mm512_shuffle_f32x4(odd0, odd2, 0x88));
        _mm512_storeu_ps(to + 32, _mm512_shuffle_f32x4(even0, even2, 0xdd));
        _mm512_storeu_ps(to + 48, _mm512_shuffle_f32x4(odd0, odd2, 0xdd));
    }
}
/* Sums, row by row. */
LANES_INLINE void lanes_add_row2(double *to, const double *row)
{
    _mm_storeu_pd(to, _mm_loadu_pd(to) + _mm_loadu_pd(row));
}
LANES_INLINE void f64_add2(void *base, const uint32_t *row, const f64 *column)
{
    double buffer[2][8] __attribute__((aligned(64)));
    _mm512_store_pd(buffer[0], _mm512_unpacklo_pd(column[0], column[1]));
    _mm512_store_pd(buffer[1], _mm512_unpackhi_pd(column[0], column[1]));
    for (int r = 0; r < 8; r++)
        lanes_add_row2(lanes_sums(base, row[r], 4), &buffer[r & 1][r & 6]);
}
LANES_INLINE void f64_add4(void *base, const uint32_t *row, const f64 *column)
{
    f64 rows[4];
    lanes_rows4(column, rows);
    for (int r = 0; r < 8; r++) { /* rows[] holds 0|2, 1|3, 4|6, 5|7 */
        double *to = lanes_sums(base, row[r], 4);
        const f64 two = rows[(r & 1) + (r & 4) / 2];
        const __m256d one = r & 2 ? _mm512_extractf64x4_pd(two, 1) : _mm512_castpd512_pd256(two);
        _mm256_storeu_pd(to, _mm256_loadu_pd(to) + one);
    }
}
LANES_INLINE void f32_add2(void *base, const uint32_t *row, int unit, const f32 *column)
{
    const __m512i of_first = _mm512_setr_epi32(0, 16, 4, 20, 1, 17, 5, 21, 2, 18, 6, 22, 3, 19, 7, 23);
    const __m512i of_second = _mm512_add_epi32(of_first, _mm512_set1_epi32(8));
    const f32 first = _mm512_permutex2var_ps(column[0], of_first, column[1]),
              second = _mm512_permutex2var_ps(column[0], of_second, column[1]);
    lanes_add_two_rows(base, row, unit, _mm512_castps512_ps128(first));
    lanes_add_two_rows(base, row + 1, unit, _mm512_extractf32x4_ps(first, 1));
    lanes_add_two_rows(base, row + 2, unit, _mm512_extractf32x4_ps(first, 2));
    lanes_add_two_rows(base, row + 3, unit, _mm512_extractf32x4_ps(first, 3));
    lanes_add_two_rows(base, row + 8, unit, _mm512_castps512_ps128(second));
    lanes_add_two_rows(base, row + 9, unit, _mm512_extractf32x4_ps(second, 1));
    lanes_add_two_rows(base, row + 10, unit, _mm512_extractf32x4_ps(second, 2));
    lanes_add_two_rows(base, row + 11, unit, _mm512_extractf32x4_ps(second, 3));
}
LANES_INLINE void f32_add4(void *base, const uint32_t *row, int unit, const f32 *column)
{
    float buffer[4][16] __attribute__((aligned(64)));
    f32 rows[4];
    lanes_quarters(column, rows);
    for (int k = 0; k < 4; k++)
        _mm512_store_ps(buffer[k], rows[k]);
    for (int r = 0; r < 16; r++) {
        float *to = lanes_sums(base, row[r], unit);
        _mm_storeu_ps(to, _mm_loadu_ps(to) + _mm_load_ps(&buffer[r & 3][r & 12]));
    }
}
LANES_INLINE void f32_add8(void *base, const uint32_t *row, int unit, const f32 *column)
{
    const __m512i front = _mm512_set_epi64(11, 10, 3, 2, 9, 8, 1, 0),
                  back = _mm512_set_epi64(15, 14, 7, 6, 13, 12, 5, 4);
    f64 rows[8];
    f32 low[4], high[4];
    lanes_quarters(column, low);
    lanes_quarters(column + 4, high);
    for (int q = 0; q < 4; q++) { /* rows q, 4 + q | 8 + q, 12 + q */
        f64 l = _mm512_castps_pd(low[q]), h = _mm512_castps_pd(high[q]);
        rows[2 * q] = _mm512_permutex2var_pd(l, front, h);
        rows[2 * q + 1] = _mm512_permutex2var_pd(l, back, h);
    }
    for (int r = 0; r < 16; r++) {
        float *to = lanes_sums(base, row[r], unit);
        const f64 two = rows[2 * (r & 3) + r / 8];
        const __m256d one = r & 4 ? _mm512_extractf64x4_pd(two, 1) : _mm512_castpd512_pd256(two);
        _mm256_storeu_ps(to, _mm256_loadu_ps(to) + _mm256_castpd_ps(one));
    }
}
