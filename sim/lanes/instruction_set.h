/* The instruction sets that kernels are compiled for, and the choice among them at the start of a run. */
#ifndef SHAKEDOWN_SIM_LANES_INSTRUCTION_SET_H
#define SHAKEDOWN_SIM_LANES_INSTRUCTION_SET_H

#include <stdbool.h>

#include "common/status.h"

/* Instruction sets, in the order of preference. */
#define INSTRUCTION_SETS(X) X(reference) X(avx2) X(avx512)
enum instruction_set {
#define INSTRUCTION_SET_ENUM(name) ISA_##name,
    INSTRUCTION_SETS(INSTRUCTION_SET_ENUM)
#undef INSTRUCTION_SET_ENUM
        ISA_COUNT
};

const char *instruction_set_name(enum instruction_set isa);
bool instruction_set_supported(enum instruction_set isa);

/* The last of the list that the CPU can run, or what SHAKEDOWN_ISA names. STATUS_USAGE if that is unknown or the CPU
 * cannot run it. */
enum status instruction_set_select(enum instruction_set *isa) MUST_USE;

#endif
