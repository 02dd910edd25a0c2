#include "sim/kernels/kernels.h"

#include <stdlib.h>
#include <string.h>

/* Tables of kernel_models.h: [dimension - 2][hysteretic][frictional][single] */
#define DECLARE_TABLE(name) extern const struct kernels kernel_table_##name[2][2][2][2];
KERNEL_ISA_LIST(DECLARE_TABLE)
#undef DECLARE_TABLE

const char *kernel_isa_name(enum kernel_isa isa)
{
    static const char *const names[] = {
#define ISA_NAME(name) #name,
        KERNEL_ISA_LIST(ISA_NAME)
#undef ISA_NAME
    };
    return names[isa];
}

bool kernel_isa_supported(enum kernel_isa isa)
{
    __builtin_cpu_init();
    switch (isa) {
    case ISA_avx2:
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    case ISA_avx512:
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
               __builtin_cpu_supports("avx512vl");
    default:
        return true;
    }
}

enum status kernel_isa_select(enum kernel_isa *isa)
{
    const char *forced = getenv("SHAKEDOWN_ISA");
    for (int k = ISA_COUNT - 1; k >= 0; k--) {
        bool named = forced && strcmp(forced, kernel_isa_name(k)) == 0;
        if (named && !kernel_isa_supported(k))
            return status_fail(STATUS_USAGE, "SHAKEDOWN_ISA=%s: this CPU cannot run it", forced);
        if (named || (!forced && kernel_isa_supported(k))) {
            *isa = k;
            return STATUS_OK;
        }
    }
    return status_fail(STATUS_USAGE, "SHAKEDOWN_ISA=%s is unknown; allowed: reference avx2 avx512", forced);
}

struct kernels kernels_select(enum kernel_isa isa, int dimension, bool hysteretic, bool frictional, bool single)
{
    static const struct kernels(*const tables[ISA_COUNT])[2][2][2] = {
#define TABLE(name) kernel_table_##name,
        KERNEL_ISA_LIST(TABLE)
#undef TABLE
    };
    return tables[isa][dimension - 2][hysteretic][frictional][single];
}
