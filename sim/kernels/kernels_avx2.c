/* The kernels in vectors; compiled for this instruction set alone (CMakeLists.txt). */
#include <math.h>
#include <string.h>

#include "sim/kernels/kernels.h"
#include "sim/lanes/lanes_avx2.h"

#define ISA avx2
#include "sim/kernels/kernel_table.h"
