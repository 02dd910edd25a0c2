/* The kernels in vectors; compiled for this instruction set alone (CMakeLists.txt). */
#include <math.h>
#include <string.h>

#include "sim/kernels.h"
#include "sim/lanes_avx512.h"

#define ISA avx512
#include "sim/kernel_models.h"
