/* Of a normal law that remembers nothing: no columns of the history. Included among its lanes (contact_law_tmpl.h). */
struct NAME(normal_memory) {
    char none;
};

LANES_INLINE struct NAME(normal_memory) NAME(normal_memory_at)(void *const *history, size_t slot)
{
    (void)history;
    (void)slot;
    return (struct NAME(normal_memory)){0};
}
