/* The kernels of one model (for_each_model.h says which macros choose it); each part uses the one before. */
#include "sim/law/contact_law_tmpl.h"

#include "sim/kernels/contact_kernel_tmpl.h"

#include "sim/kernels/particle_kernel_tmpl.h"
