#include "sim/kernels/kernels.h"

/* Tables of kernel_table.h: [law][dimension - 2][friction][mixed] */
#define DECLARE_TABLE(name) extern const struct kernels kernel_table_##name[LAW_COUNT][2][4][2];
INSTRUCTION_SETS(DECLARE_TABLE)
#undef DECLARE_TABLE

struct kernels kernels_select(enum instruction_set isa, const struct contact_model *model)
{
    static const struct kernels(*const tables[ISA_COUNT])[2][4][2] = {
#define TABLE(name) kernel_table_##name,
        INSTRUCTION_SETS(TABLE)
#undef TABLE
    };
    return tables[isa][model->normal][model->dimension - 2][contact_model_friction(model)][model->mixed];
}
