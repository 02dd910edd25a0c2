/* One contact at a time, in plain C: the reference of the vector kernels, and what runs on a CPU without them. */
#include <math.h>
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
LANES_INLINE double real_sum(real x)
{
    return x;
}
