/* Looks for every CPU. */
#define ISA plain
#include "sim/sample/contact_look_table.h"
