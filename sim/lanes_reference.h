/* One contact or particle at a time, in plain C: the reference of the vector kernels, and what runs on a CPU without
 * them. Names: f64 and f32 are vectors of double and float, f32h as many floats as an f64 has doubles. A row is where a
 * record starts, in doubles. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define F64_LANES 1
#define F32_LANES 1
typedef double f64;
typedef int f64_mask;
typedef float f32, f32h;
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
LANES_INLINE void f32h_store(float *to, f32h x)
{
    *to = x;
}
LANES_INLINE f32h f32h_load(const float *from)
{
    return *from;
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
LANES_INLINE double f64_sum(f64 x)
{
    return x;
}
LANES_INLINE f32h f64_narrow(f64 x)
{
    return (float)x;
}
LANES_INLINE f64 f32h_widen(f32h x)
{
    return x;
}
/* An f32 from F32_LANES/F64_LANES of f64, and back. */
LANES_INLINE f32 f32_of(const f64 *part)
{
    return (float)part[0];
}
LANES_INLINE void f32_widen(f32 x, f64 *part)
{
    part[0] = x;
}
/* Two floats side by side in each double, and back; `part` as of f32_of. */
LANES_INLINE f64 f64_pair(f32h even, f32h odd)
{
    float both[2] = {even, odd};
    f64 pair;
    memcpy(&pair, both, sizeof pair);
    return pair;
}
LANES_INLINE void f32_split(const f64 *part, f32 *even, f32 *odd)
{
    float both[2];
    memcpy(both, part, sizeof both);
    *even = both[0];
    *odd = both[1];
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
/* Columns of F64_LANES consecutive records of 2 doubles, of 4 or of 8 floats. */
LANES_INLINE void f64_load2(const double *from, f64 *column)
{
    column[0] = from[0];
    column[1] = from[1];
}
LANES_INLINE void f32h_load4(const float *from, f32h *column)
{
    for (int c = 0; c < 4; c++)
        column[c] = from[c];
}
LANES_INLINE void f32h_load8(const float *from, f32h *column)
{
    for (int c = 0; c < 8; c++)
        column[c] = from[c];
}
/* Where the sums of a particle are whose record starts at `row`: records are twice as long (particles.h). */
LANES_INLINE void *lanes_half(void *base, uint32_t row)
{
    return (char *)base + sizeof(double) / 2 * (size_t)row;
}
/* Adds columns to the sums that belong to records, in the order of the lanes: rows of 2 and 4 doubles, 2, 4 and 8
 * floats. */
LANES_INLINE void f64_add2(void *base, const uint32_t *row, const f64 *column)
{
    double *to = lanes_half(base, row[0]);
    for (int c = 0; c < 2; c++)
        to[c] += column[c];
}
LANES_INLINE void f64_add4(void *base, const uint32_t *row, const f64 *column)
{
    double *to = lanes_half(base, row[0]);
    for (int c = 0; c < 4; c++)
        to[c] += column[c];
}
LANES_INLINE void f32_add2(void *base, const uint32_t *row, const f32 *column)
{
    float *to = lanes_half(base, row[0]);
    for (int c = 0; c < 2; c++)
        to[c] += column[c];
}
LANES_INLINE void f32_add4(void *base, const uint32_t *row, const f32 *column)
{
    float *to = lanes_half(base, row[0]);
    for (int c = 0; c < 4; c++)
        to[c] += column[c];
}
LANES_INLINE void f32_add8(void *base, const uint32_t *row, const f32 *column)
{
    float *to = lanes_half(base, row[0]);
    for (int c = 0; c < 8; c++)
        to[c] += column[c];
}
