/* Instantiates the kernels for every model and precision under the including file's ISA, and the table of them:
 * [dimension - 2][hysteretic][frictional][single]. */
enum {
    CHUNK = 8,         /* sets that go through a kernel's parts together */
    ASK_AHEAD = 8,     /* sets, of what the caches do not hold */
    CLOSE_EVERY = 1024 /* slots: sums in float stay short */
};

/* Sets of pairs (contacts.h): j is the particle behind i; i are side by side; or in two halves. */
enum pair_kind { PAIRS_NEXT, PAIRS_WHOLE, PAIRS_HALVES };

#define DIM        2
#define HYSTERETIC 0
#define FRICTIONAL 0
#define SINGLE     0
#include "sim/kernels/kernel_model.h"
#define DIM        2
#define HYSTERETIC 0
#define FRICTIONAL 0
#define SINGLE     1
#include "sim/kernels/kernel_model.h"
#define DIM        2
#define HYSTERETIC 0
#define FRICTIONAL 1
#define SINGLE     0
#include "sim/kernels/kernel_model.h"
#define DIM        2
#define HYSTERETIC 0
#define FRICTIONAL 1
#define SINGLE     1
#include "sim/kernels/kernel_model.h"
#define DIM        2
#define HYSTERETIC 1
#define FRICTIONAL 0
#define SINGLE     0
#include "sim/kernels/kernel_model.h"
#define DIM        2
#define HYSTERETIC 1
#define FRICTIONAL 0
#define SINGLE     1
#include "sim/kernels/kernel_model.h"
#define DIM        2
#define HYSTERETIC 1
#define FRICTIONAL 1
#define SINGLE     0
#include "sim/kernels/kernel_model.h"
#define DIM        2
#define HYSTERETIC 1
#define FRICTIONAL 1
#define SINGLE     1
#include "sim/kernels/kernel_model.h"
#define DIM        3
#define HYSTERETIC 0
#define FRICTIONAL 0
#define SINGLE     0
#include "sim/kernels/kernel_model.h"
#define DIM        3
#define HYSTERETIC 0
#define FRICTIONAL 0
#define SINGLE     1
#include "sim/kernels/kernel_model.h"
#define DIM        3
#define HYSTERETIC 0
#define FRICTIONAL 1
#define SINGLE     0
#include "sim/kernels/kernel_model.h"
#define DIM        3
#define HYSTERETIC 0
#define FRICTIONAL 1
#define SINGLE     1
#include "sim/kernels/kernel_model.h"
#define DIM        3
#define HYSTERETIC 1
#define FRICTIONAL 0
#define SINGLE     0
#include "sim/kernels/kernel_model.h"
#define DIM        3
#define HYSTERETIC 1
#define FRICTIONAL 0
#define SINGLE     1
#include "sim/kernels/kernel_model.h"
#define DIM        3
#define HYSTERETIC 1
#define FRICTIONAL 1
#define SINGLE     0
#include "sim/kernels/kernel_model.h"
#define DIM        3
#define HYSTERETIC 1
#define FRICTIONAL 1
#define SINGLE     1
#include "sim/kernels/kernel_model.h"

#define ENTRY(d, h, f, s)                                                                                              \
    {                                                                                                                  \
        NAME__(pair, ISA, d, h, f, s), NAME__(wall, ISA, d, h, f, s), NAME__(drift, ISA, d, h, f, s),                  \
            NAME__(kick, ISA, d, h, f, s), NAME__(advance, ISA, d, h, f, s)                                            \
    }
#define PRECISIONS(d, h, f)                                                                                            \
    {                                                                                                                  \
        ENTRY(d, h, f, 0), ENTRY(d, h, f, 1)                                                                           \
    }
#define TABLE__(isa) kernel_table_##isa
#define TABLE_(isa)  TABLE__(isa)

extern const struct kernels TABLE_(ISA)[2][2][2][2];
const struct kernels TABLE_(ISA)[2][2][2][2] = {
    {{PRECISIONS(2, 0, 0), PRECISIONS(2, 0, 1)}, {PRECISIONS(2, 1, 0), PRECISIONS(2, 1, 1)}},
    {{PRECISIONS(3, 0, 0), PRECISIONS(3, 0, 1)}, {PRECISIONS(3, 1, 0), PRECISIONS(3, 1, 1)}},
};
