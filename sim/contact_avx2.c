/* The kernels in vectors; compiled for this instruction set alone (CMakeLists.txt). */
#include "sim/contacts.h"
#include "sim/lanes_avx2.h"

#define ISA avx2
#include "sim/contact_models.h"
