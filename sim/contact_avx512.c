/* The kernels in vectors; compiled for this instruction set alone (CMakeLists.txt). */
#include "sim/contacts.h"
#include "sim/lanes_avx512.h"

#define ISA avx512
#include "sim/contact_models.h"
