#include "sim/lanes/instruction_set.h"

#include <stdlib.h>
#include <string.h>

const char *instruction_set_name(enum instruction_set isa)
{
    static const char *const names[] = {
#define ISA_NAME(name) #name,
        INSTRUCTION_SETS(ISA_NAME)
#undef ISA_NAME
    };
    return names[isa];
}

bool instruction_set_supported(enum instruction_set isa)
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

enum status instruction_set_select(enum instruction_set *isa)
{
    const char *forced = getenv("SHAKEDOWN_ISA");
    for (int k = ISA_COUNT - 1; k >= 0; k--) {
        bool named = forced && strcmp(forced, instruction_set_name(k)) == 0;
        if (named && !instruction_set_supported(k))
            return status_fail(STATUS_USAGE, "SHAKEDOWN_ISA=%s: this CPU cannot run it", forced);
        if (named || (!forced && instruction_set_supported(k))) {
            *isa = k;
            return STATUS_OK;
        }
    }
    return status_fail(STATUS_USAGE, "SHAKEDOWN_ISA=%s is unknown; allowed: reference avx2 avx512", forced);
}
