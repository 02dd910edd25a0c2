/* The floating-point environment of the processes that compute motion. */
#ifndef SHAKEDOWN_COMMON_FLOATING_POINT_H
#define SHAKEDOWN_COMMON_FLOATING_POINT_H

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

/* Numbers below 2.2e-308 are taken as zero in this thread. Rattlers come to rest under background damping by way of
 * such numbers, and each costs the CPU a hundred cycles. sim and wallctl both call it, so that the law gives the same
 * bits in either. */
static inline void floating_point_flush_subnormals(void)
{
#if defined(__SSE2__)
    const unsigned flush_to_zero = 0x8000, subnormals_are_zero = 0x0040;
    _mm_setcsr(_mm_getcsr() | flush_to_zero | subnormals_are_zero);
#endif
}

#endif
