/* The kernels of every model under the including file's ISA, and the table of them: [law][dimension - 2][friction]
 * [mixed]. */
enum {
    CHUNK = 8, /* sets that go through a kernel's parts together */
    APART = F64_LANES == 4,
    CLOSE_EVERY = 1024 /* slots: sums in float stay short */
};

/* Sets of pairs (contact_list.h): j is the particle behind i; i are side by side; or in two halves. */
enum pair_kind { PAIRS_NEXT, PAIRS_WHOLE, PAIRS_HALVES };

#define MODEL_TEXT "sim/kernels/kernel_model.h"
#include "sim/law/for_each_model.h"

#define ENTRY(d, n, f, s)                                                                                              \
    {                                                                                                                  \
        NAME__(pair, ISA, d, n, f, s), NAME__(wall, ISA, d, n, f, s), NAME__(drift, ISA, d, n, f, s),                  \
            NAME__(kick, ISA, d, n, f, s), NAME__(advance, ISA, d, n, f, s)                                            \
    }
#define BOTH(d, n, f)                                                                                                  \
    {                                                                                                                  \
        ENTRY(d, n, f, 0), ENTRY(d, n, f, 1)                                                                           \
    }
#define LAW(name, NAME_)                                                                                               \
    {{BOTH(2, name, 0), BOTH(2, name, 1), BOTH(2, name, 2)},                                                           \
     {BOTH(3, name, 0), BOTH(3, name, 1), BOTH(3, name, 2), BOTH(3, name, 3)}},
#define TABLE__(isa) kernel_table_##isa
#define TABLE_(isa)  TABLE__(isa)

extern const struct kernels TABLE_(ISA)[LAW_COUNT][2][4][2];
const struct kernels TABLE_(ISA)[LAW_COUNT][2][4][2] = {CONTACT_LAWS(LAW)};
