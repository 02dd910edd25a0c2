#include "sim/kernels/kernels.h"

/* Tables of kernel_models.h: [dimension - 2][hysteretic][frictional][single] */
#define DECLARE_TABLE(name) extern const struct kernels kernel_table_##name[2][2][2][2];
INSTRUCTION_SETS(DECLARE_TABLE)
#undef DECLARE_TABLE

struct kernels kernels_select(enum instruction_set isa, int dimension, bool hysteretic, bool frictional, bool single)
{
    static const struct kernels(*const tables[ISA_COUNT])[2][2][2] = {
#define TABLE(name) kernel_table_##name,
        INSTRUCTION_SETS(TABLE)
#undef TABLE
    };
    return tables[isa][dimension - 2][hysteretic][frictional][single];
}
