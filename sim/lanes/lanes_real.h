/* `real`: what the law is computed in, float lanes if SINGLE, else double; included anew for each precision. `scalar`
 * is one of it; PARTS f64 make as many lanes as one real. */
#undef real
#undef real_mask
#undef scalar
#undef LANES
#undef PARTS
#undef REAL
#if SINGLE
#define real      f32
#define real_mask f32_mask
#define scalar    float
#define LANES     F32_LANES
#define REAL(op)  f32_##op
#else
#define real      f64
#define real_mask f64_mask
#define scalar    double
#define LANES     F64_LANES
#define REAL(op)  f64_##op
#endif
#define PARTS (LANES / F64_LANES)

#ifndef REAL_OPERATIONS
#define REAL_OPERATIONS
#define real_all      REAL(all)
#define real_load     REAL(load)
#define real_store    REAL(store)
#define real_greater  REAL(greater)
#define real_at_least REAL(at_least)
#define real_and      REAL(and)
#define real_select   REAL(select)
#define real_where    REAL(where)
#define real_larger   REAL(larger)
#define real_smaller  REAL(smaller)
#define real_fma      REAL(fma)

/* As of f32: one part is all. */
LANES_INLINE void f64_widen(f64 x, f64 *part)
{
    part[0] = x;
}
LANES_INLINE f64 f64_narrow(const f64 *part)
{
    return part[0];
}

/* 1/sqrt(x) to about one unit in the last place: the seed is right to 1e-7, and the step's error is of third order.
 * The same bits in every instruction set, and much cheaper than square root and division in double. */
LANES_INLINE f64 lanes_rsqrt(f64 x, f64 seed)
{
    f64 y = seed;
    f64 e = f64_fma(-x, y * y, f64_all(1.0)); /* y = (1 - e)^(1/2) / sqrt(x) */
    return f64_fma(f64_fma(f64_all(0.375), e, f64_all(0.5)), e * y, y);
}

/* x^(-1/4) from a seed in float, likewise: with e = 1 - x y^4, (1 - e)^(-1/4) = 1 + e/4 + 5 e^2/32 ...; what is left
 * out is below 10^-19. */
LANES_INLINE f64 lanes_fourth_root_inverse(f64 x, f64 seed)
{
    f64 y = seed, y2 = y * y;
    f64 e = f64_fma(-x * y2, y2, f64_all(1.0));
    return f64_fma(f64_fma(f64_all(0.15625), e, f64_all(0.25)), e * y, y);
}
#endif
