/* Looks with fused multiply-adds; compiled for such CPUs alone (CMakeLists.txt). */
#define ISA fma
#include "sim/sample/contact_look_table.h"
