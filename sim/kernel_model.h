/* The kernels of one model (kernel_law_tmpl.h says which macros choose it). */
#include "sim/kernel_law_tmpl.h"
#include "sim/kernel_pair_tmpl.h"
#include "sim/kernel_particle_tmpl.h"
#undef DIM
#undef HYSTERETIC
#undef FRICTIONAL
#undef SINGLE
