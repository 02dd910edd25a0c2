/* The kernels one contact at a time: the reference of the vector ones. */
#include <math.h>
#include <string.h>

#include "sim/kernels/kernels.h"
#include "sim/lanes/lanes_reference.h"

#define ISA reference
#include "sim/kernels/kernel_table.h"
