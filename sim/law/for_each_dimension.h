/* The models of one normal law (for_each_model.h). */
#define DIM 2
#include "sim/law/for_each_friction.h"
#undef DIM

#define DIM 3
#include "sim/law/for_each_friction.h"
#undef DIM
