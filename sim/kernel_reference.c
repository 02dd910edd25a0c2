/* The kernels one contact at a time: the reference of the vector ones. */
#include <math.h>
#include <string.h>

#include "sim/kernels.h"
#include "sim/lanes_reference.h"

#define ISA reference
#include "sim/kernel_models.h"
