/* Of a normal law that loses nothing by itself: no sums. Included among its lanes (contact_law_tmpl.h). */
struct NAME(normal_sums) {
    char none;
};

struct NAME(normal_totals) {
    char none;
};

LANES_INLINE void NAME(normal_sums_close)(struct NAME(normal_sums) * sums, struct NAME(normal_totals) * totals)
{
    (void)sums;
    (void)totals;
}

LANES_INLINE double NAME(normal_hysteresis_j)(const struct NAME(normal_totals) * totals, const double *constant,
                                              const struct law_units *units)
{
    (void)totals;
    (void)constant;
    (void)units;
    return 0;
}
