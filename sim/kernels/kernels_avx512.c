/* The kernels in vectors; compiled for this instruction set alone (CMakeLists.txt). */
#include <math.h>
#include <string.h>

#include "sim/kernels/kernels.h"
#include "sim/lanes/lanes_avx512.h"

#define ISA avx512
#include "sim/kernels/kernel_table.h"
