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
/* a b + c with one rounding. */
LANES_INLINE real real_fma(real a, real b, real c)
{
    return fma(a, b, c);
}
/* 1/sqrt(x) in single precision, from square root and division that are exactly rounded everywhere. */
LANES_INLINE real real_rsqrt_seed(real x)
{
    return 1.0f / sqrtf((float)x);
}
/* Columns of records of 4 doubles that start at base + row[lane]. */
LANES_INLINE void lanes_gather4(const double *base, const uint32_t *row, real *column)
{
    for (int c = 0; c < 4; c++)
        column[c] = base[row[0] + (size_t)c];
}
/* The same for LANES records, one after the other with `stride` doubles from one to the next. */
LANES_INLINE void lanes_load4(const double *from, int stride, real *column)
{
    (void)stride;
    for (int c = 0; c < 4; c++)
        column[c] = from[c];
}
LANES_INLINE void lanes_store4(double *to, int stride, const real *column)
{
    (void)stride;
    for (int c = 0; c < 4; c++)
        to[c] = column[c];
}
/* Where the sums of a particle are whose record starts at `row`: records are twice as long (particles.h). */
LANES_INLINE double *lanes_half(double *base, uint32_t row)
{
    return (double *)((char *)base + sizeof(double) / 2 * (size_t)row);
}
/* Adds (column[0], column[1]) to the sums of the particles with records at i[lane] and subtracts it from those at
 * j, in the order of the lanes. */
LANES_INLINE void lanes_add2(double *base, const uint32_t *i, const uint32_t *j, const real *column)
{
    for (int c = 0; c < 2; c++)
        lanes_half(base, i[0])[c] += column[c];
    for (int c = 0; c < 2; c++)
        lanes_half(base, j[0])[c] -= column[c];
}
/* The same for records of 4; sign[c] (1 or -1) is how column c counts at j. */
LANES_INLINE void lanes_add4(double *base, const uint32_t *i, const uint32_t *j, const real *column, const double *sign)
{
    for (int c = 0; c < 4; c++)
        lanes_half(base, i[0])[c] += column[c];
    for (int c = 0; c < 4; c++)
        lanes_half(base, j[0])[c] += sign[c] * column[c];
}
/* Columns of LANES consecutive records of 2 doubles. */
LANES_INLINE void lanes_load2(const double *from, real *column)
{
    column[0] = from[0];
    column[1] = from[1];
}
LANES_INLINE double real_sum(real x)
{
    return x;
}
