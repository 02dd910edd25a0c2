/* The kernels in vectors; compiled for this instruction set alone (CMakeLists.txt). */
#include <math.h>
#include <string.h>

#include "sim/kernels.h"
#include "sim/lanes_avx2.h"

#define ISA avx2
#include "sim/kernel_models.h"
