/* One contact at a time, in plain C: the reference of the vector kernels, and what runs on a CPU without them. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define LANES 1
typedef double real;
typedef int mask;
typedef int32_t indices;

#define LANES_INLINE static inline __attribute__((always_inline))

LANES_INLINE real real_all(double x)
{
    return x;
}
LANES_INLINE real real_load(const double *from)
{
    return *from;
}
LANES_INLINE void real_store(double *to, real x)
{
    *to = x;
}
LANES_INLINE indices indices_load(const int32_t *from)
{
    return *from;
}
LANES_INLINE real real_gather(const double *base, indices at)
{
    return base[at];
}
LANES_INLINE real real_sqrt(real x)
{
    return sqrt(x);
}
LANES_INLINE mask mask_greater(real a, real b)
{
    return a > b;
}
LANES_INLINE mask mask_at_least(real a, real b)
{
    return a >= b;
}
LANES_INLINE mask mask_and(mask a, mask b)
{
    return a & b;
}
LANES_INLINE real real_select(mask m, real a, real b)
{
    return m ? a : b;
}
LANES_INLINE real real_larger(real a, real b)
{
    return a > b ? a : b;
}
LANES_INLINE real real_smaller(real a, real b)
{
    return a < b ? a : b;
}
LANES_INLINE bool mask_all(mask m)
{
    return m != 0;
}
/* 1/sqrt(x) to about one unit in the last place from single-precision square root and division, both exactly rounded
 * everywhere, and two Newton steps: the same bits in every instruction set, and much cheaper than in double. */
LANES_INLINE real real_rsqrt(real x)
{
    real y = 1.0f / sqrtf((float)x);
    real half = 0.5 * x;
    y = y * (1.5 - half * y * y);
    return y * (1.5 - half * y * y);
}
/* Columns of records of 4 doubles, at rows at[0 ... LANES-1] of `stride` doubles. */
LANES_INLINE void lanes_gather4(const double *base, int stride, const int32_t *at, real *column)
{
    for (int c = 0; c < 4; c++)
        column[c] = base[stride * (size_t)at[0] + (size_t)c];
}
/* Writes LANES consecutive records of 4 doubles. */
LANES_INLINE void lanes_store4(double *to, int stride, const real *column)
{
    (void)stride;
    for (int c = 0; c < 4; c++)
        to[c] = column[c];
}
/* Reads LANES consecutive records of 2 or 4 doubles, without gaps. */
LANES_INLINE void lanes_load2(const double *from, real *column)
{
    column[0] = from[0];
    column[1] = from[1];
}
LANES_INLINE void lanes_load4(const double *from, int stride, real *column)
{
    (void)stride;
    for (int c = 0; c < 4; c++)
        column[c] = from[c];
}
/* Adds the records (column[0], column[1]) to those at i of `into` and subtracts them from those at j, in the order of
 * the lanes. */
LANES_INLINE void lanes_add2(double *into, const int32_t *i, const int32_t *j, const real *column)
{
    for (int c = 0; c < 2; c++)
        into[2 * (size_t)i[0] + (size_t)c] += column[c];
    for (int c = 0; c < 2; c++)
        into[2 * (size_t)j[0] + (size_t)c] -= column[c];
}
/* The same for records of 4 with `stride` doubles between them; sign[c] (1 or -1) is how column c counts at j. */
LANES_INLINE void lanes_add4(double *into, int stride, const int32_t *i, const int32_t *j, const real *column,
                             const double *sign)
{
    for (int c = 0; c < 4; c++)
        into[stride * (size_t)i[0] + (size_t)c] += column[c];
    for (int c = 0; c < 4; c++)
        into[stride * (size_t)j[0] + (size_t)c] += sign[c] * column[c];
}
LANES_INLINE double real_sum(real x)
{
    return x;
}
