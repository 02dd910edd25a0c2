/* Instantiates kernel_tmpl.h for every model under the including file's ISA, and the table of them:
 * [dimension - 2][hysteretic][frictional]. */
#define DIM        2
#define HYSTERETIC 0
#define FRICTIONAL 0
#include "sim/kernel_tmpl.h"
#undef FRICTIONAL
#define FRICTIONAL 1
#include "sim/kernel_tmpl.h"
#undef HYSTERETIC
#undef FRICTIONAL
#define HYSTERETIC 1
#define FRICTIONAL 0
#include "sim/kernel_tmpl.h"
#undef FRICTIONAL
#define FRICTIONAL 1
#include "sim/kernel_tmpl.h"
#undef DIM
#undef HYSTERETIC
#undef FRICTIONAL
#define DIM        3
#define HYSTERETIC 0
#define FRICTIONAL 0
#include "sim/kernel_tmpl.h"
#undef FRICTIONAL
#define FRICTIONAL 1
#include "sim/kernel_tmpl.h"
#undef HYSTERETIC
#undef FRICTIONAL
#define HYSTERETIC 1
#define FRICTIONAL 0
#include "sim/kernel_tmpl.h"
#undef FRICTIONAL
#define FRICTIONAL 1
#include "sim/kernel_tmpl.h"

#define ENTRY(d, h, f)                                                                                                 \
    {                                                                                                                  \
        NAME__(pair, ISA, d, h, f), NAME__(wall, ISA, d, h, f), NAME__(drift, ISA, d, h, f),                           \
            NAME__(kick, ISA, d, h, f)                                                                                 \
    }
#define TABLE__(isa) kernel_table_##isa
#define TABLE_(isa)  TABLE__(isa)

extern const struct kernels TABLE_(ISA)[2][2][2];
const struct kernels TABLE_(ISA)[2][2][2] = {
    {{ENTRY(2, 0, 0), ENTRY(2, 0, 1)}, {ENTRY(2, 1, 0), ENTRY(2, 1, 1)}},
    {{ENTRY(3, 0, 0), ENTRY(3, 0, 1)}, {ENTRY(3, 1, 0), ENTRY(3, 1, 1)}},
};
