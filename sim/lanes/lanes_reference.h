/* One contact or particle at a time, in plain C: the reference of the vector kernels, and what runs on a CPU without
 * them. Names: f64 and f32 are vectors of double and float. A row is where a record starts, in doubles. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define F64_LANES 1
#define F32_LANES 1
typedef double f64;
typedef int f64_mask;
typedef float f32;
typedef int f32_mask;

#define LANES_INLINE static inline __attribute__((always_inline))

LANES_INLINE f64 f64_all(double x)
{
    return x;
}
LANES_INLINE f32 f32_all(double x)
{
    return (float)x;
}
LANES_INLINE f64 f64_load(const double *from)
{
    return *from;
}
LANES_INLINE f32 f32_load(const float *from)
{
    return *from;
}
LANES_INLINE void f64_store(double *to, f64 x)
{
    *to = x;
}
LANES_INLINE void f32_store(float *to, f32 x)
{
    *to = x;
}
LANES_INLINE f64_mask f64_greater(f64 a, f64 b)
{
    return a > b;
}
LANES_INLINE f32_mask f32_greater(f32 a, f32 b)
{
    return a > b;
}
LANES_INLINE f64_mask f64_at_least(f64 a, f64 b)
{
    return a >= b;
}
LANES_INLINE f32_mask f32_at_least(f32 a, f32 b)
{
    return a >= b;
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
    return m ? a : b;
}
LANES_INLINE f32 f32_select(f32_mask m, f32 a, f32 b)
{
    return m ? a : b;
}
LANES_INLINE f64 f64_where(f64_mask m, f64 x) /* x or 0 */
{
    return m ? x : 0;
}
LANES_INLINE f32 f32_where(f32_mask m, f32 x)
{
    return m ? x : 0;
}
LANES_INLINE f64 f64_larger(f64 a, f64 b) /* b if one is NaN */
{
    return a > b ? a : b;
}
LANES_INLINE f32 f32_larger(f32 a, f32 b)
{
    return a > b ? a : b;
}
LANES_INLINE f64 f64_smaller(f64 a, f64 b)
{
    return a < b ? a : b;
}
LANES_INLINE f32 f32_smaller(f32 a, f32 b)
{
    return a < b ? a : b;
}
LANES_INLINE bool f64_mask_all(f64_mask m)
{
    return m != 0;
}
LANES_INLINE bool f32_mask_all(f32_mask m)
{
    return m != 0;
}
/* a b + c with one rounding. */
LANES_INLINE f64 f64_fma(f64 a, f64 b, f64 c)
{
    return fma(a, b, c);
}
LANES_INLINE f32 f32_fma(f32 a, f32 b, f32 c)
{
    return fmaf(a, b, c);
}
LANES_INLINE f32 f32_sqrt(f32 x)
{
    return sqrtf(x);
}
/* 1/sqrt(x) in single precision, from square root and division that are exactly rounded everywhere. */
LANES_INLINE f64 f64_rsqrt_seed(f64 x)
{
    return 1.0f / sqrtf((float)x);
}
LANES_INLINE f64 f64_fourth_root_seed(f64 x)
{
    return 1.0f / sqrtf(sqrtf((float)x));
}
LANES_INLINE double f64_sum(f64 x)
{
    return x;
}
/* Each lane from the one before it, the first from the last of `before`. */
LANES_INLINE f64 f64_shifted(f64 before, f64 x)
{
    (void)x;
    return before;
}
LANES_INLINE f32 f32_shifted(f32 before, f32 x)
{
    (void)x;
    return before;
}
/* Each lane from the one behind it, the last from the first of `next`. */
LANES_INLINE f64 f64_behind(f64 x, f64 next)
{
    (void)x;
    return next;
}
LANES_INLINE f32 f32_behind(f32 x, f32 next)
{
    (void)x;
    return next;
}
/* F32_LANES/F64_LANES f64 from an f32. */
LANES_INLINE void f32_widen(f32 x, f64 *part)
{
    part[0] = x;
}
/* And back. */
LANES_INLINE f32 f32_narrow(const f64 *part)
{
    return (float)part[0];
}
LANES_INLINE int32_t lanes_integer(float bits)
{
    int32_t integer;
    memcpy(&integer, &bits, sizeof integer);
    return integer;
}
/* The nearest whole number, even if it is between two. */
LANES_INLINE f32 f32_round(f32 x)
{
    return rintf(x);
}
/* Integers in a float's place: of whole numbers (INT32_MIN if there is none), the same in every lane, as floats, the
 * difference and the sum of two. */
LANES_INLINE f32 f32_to_integers(f32 x)
{
    const int32_t integer = x >= -2147483648.0f && x < 2147483648.0f ? (int32_t)x : INT32_MIN;
    f32 bits;
    memcpy(&bits, &integer, sizeof bits);
    return bits;
}
LANES_INLINE f32 f32_all_integers(int32_t integer)
{
    f32 bits;
    memcpy(&bits, &integer, sizeof bits);
    return bits;
}
LANES_INLINE f32 f32_of_integers(f32 bits)
{
    return (float)lanes_integer(bits);
}
LANES_INLINE f32 f32_of_difference(f32 a, f32 b)
{
    return (float)(int32_t)((uint32_t)lanes_integer(a) - (uint32_t)lanes_integer(b));
}
LANES_INLINE f32 f32_sum_of_integers(f32 a, f32 b)
{
    return f32_all_integers((int32_t)((uint32_t)lanes_integer(a) + (uint32_t)lanes_integer(b)));
}
/* Two numbers in the place of one: the upper half of the bits of each. */
LANES_INLINE f32 f32_pair(f32 a, f32 b)
{
    return f32_all_integers((int32_t)(((uint32_t)lanes_integer(a) & 0xffff0000) | (uint32_t)lanes_integer(b) >> 16));
}
LANES_INLINE f32 f32_first(f32 pair)
{
    return f32_all_integers((int32_t)((uint32_t)lanes_integer(pair) & 0xffff0000));
}
LANES_INLINE f32 f32_second(f32 pair)
{
    return f32_all_integers((int32_t)((uint32_t)lanes_integer(pair) << 16));
}
/* Columns of blocks of 4 doubles or floats that start `base` + row[lane] doubles. */
LANES_INLINE void f64_gather4(const double *base, const uint32_t *row, f64 *column)
{
    for (int c = 0; c < 4; c++)
        column[c] = base[row[0] + (size_t)c];
}
LANES_INLINE void f32_gather4(const double *base, const uint32_t *row, f32 *column)
{
    memcpy(column, base + row[0], 4 * sizeof *column);
}
LANES_INLINE void f32_gather8(const double *base, const uint32_t *row, f32 *column)
{
    memcpy(column, base + row[0], 8 * sizeof *column);
}
/* The same for F64_LANES records, one after the other with `stride` members from one to the next. */
LANES_INLINE void f64_load4(const double *from, int stride, f64 *column)
{
    (void)stride;
    for (int c = 0; c < 4; c++)
        column[c] = from[c];
}
LANES_INLINE void f64_store4(double *to, int stride, const f64 *column)
{
    (void)stride;
    for (int c = 0; c < 4; c++)
        to[c] = column[c];
}
/* Columns of consecutive records of 2 doubles. */
LANES_INLINE void f64_load2(const double *from, f64 *column)
{
    column[0] = from[0];
    column[1] = from[1];
}
/* Columns of F32_LANES consecutive records of 2, 4 or 8 floats, and records, of 16 too, from columns. */
LANES_INLINE void f32_load2(const float *from, f32 *column)
{
    memcpy(column, from, 2 * sizeof *column);
}
LANES_INLINE void f32_load4(const float *from, f32 *column)
{
    memcpy(column, from, 4 * sizeof *column);
}
LANES_INLINE void f32_load8(const float *from, f32 *column)
{
    memcpy(column, from, 8 * sizeof *column);
}
LANES_INLINE void f32_store4(float *to, const f32 *column)
{
    memcpy(to, column, 4 * sizeof *column);
}
LANES_INLINE void f32_store8(float *to, const f32 *column)
{
    memcpy(to, column, 8 * sizeof *column);
}
LANES_INLINE void f32_store16(float *to, const f32 *column)
{
    memcpy(to, column, 16 * sizeof *column);
}
/* Where the sums of a particle are whose record starts at `row`, `unit` bytes for each double of a record. */
LANES_INLINE void *lanes_sums(void *base, uint32_t row, int unit)
{
    return (char *)base + (size_t)unit * row;
}
/* Adds columns to the sums that belong to records, in the order of the lanes: rows of 2 and 4 doubles, 2, 4 and 8
 * floats. But for rows of 2 floats those of lanes l and l + 4 of 8 are not the same and added at once, so that the
 * order is 0 4 1 5 2 6 3 7. */
LANES_INLINE void f64_add2(void *base, const uint32_t *row, const f64 *column)
{
    double *to = lanes_sums(base, row[0], 4);
    for (int c = 0; c < 2; c++)
        to[c] += column[c];
}
LANES_INLINE void f64_add4(void *base, const uint32_t *row, const f64 *column)
{
    double *to = lanes_sums(base, row[0], 4);
    for (int c = 0; c < 4; c++)
        to[c] += column[c];
}
LANES_INLINE void f32_add2(void *base, const uint32_t *row, int unit, const f32 *column)
{
    float *to = lanes_sums(base, row[0], unit);
    for (int c = 0; c < 2; c++)
        to[c] += column[c];
}
LANES_INLINE void f32_add4(void *base, const uint32_t *row, int unit, const f32 *column)
{
    float *to = lanes_sums(base, row[0], unit);
    for (int c = 0; c < 4; c++)
        to[c] += column[c];
}
LANES_INLINE void f32_add8(void *base, const uint32_t *row, int unit, const f32 *column)
{
    float *to = lanes_sums(base, row[0], unit);
    for (int c = 0; c < 8; c++)
        to[c] += column[c];
}
